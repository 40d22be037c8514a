#include "parts/interrupt.hpp"

#include <csignal>
#include <initializer_list>

namespace mfs::program {
namespace {

volatile std::sig_atomic_t interrupted_by = 0;

extern "C" void note_interrupt(int signal) {
  interrupted_by = signal;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

Interrupted::Interrupted(int signal)
    : std::runtime_error(signal == SIGINT ? "interrupted" : "terminated"), signal_(signal) {}

void catch_interrupts() {
  for (const int signal : {SIGINT, SIGTERM})
    if (std::signal(signal, note_interrupt) == SIG_IGN)
      std::signal(signal, SIG_IGN);  // nohup, a job behind &
}

bool is_interrupted() {
  return interrupted_by != 0;
}

void throw_if_interrupted() {
  if (is_interrupted()) throw Interrupted(interrupted_by);
}

}  // namespace mfs::program
