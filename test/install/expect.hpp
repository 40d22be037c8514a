// What a program without GoogleTest tells of what failed.
#pragma once

#include <cstdio>

inline int failures = 0;

inline void expect(bool condition, const char* what) {
  if (condition) return;
  std::printf("failed: %s\n", what);
  ++failures;
}
