// A module that brings libmfs into a process that was not linked with it.
#include "tiny_system.hpp"

extern "C" __attribute__((visibility("default"))) int solve_tiny_system() {
  return TinySystem().solve() ? 0 : 1;
}
