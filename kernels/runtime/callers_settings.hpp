// What work in the thread of a caller must find, and leave as it was.
#pragma once

#include <omp.h>

#if defined(__x86_64__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace mfs {

/// As long as it lives: rounding to nearest, subnormal numbers, no traps. At its end the caller's modes and
/// flags, and his number of OpenMP threads, which OpenBLAS' openmp kind changes with its own.
class CallersSettings {
 public:
  CallersSettings() {
#if defined(__x86_64__)
    _mm_setcsr(0x1f80);
#else
    std::fegetenv(&modes_);
    std::fesetenv(FE_DFL_ENV);
#endif
  }
  ~CallersSettings() {
#if defined(__x86_64__)
    _mm_setcsr(modes_);
#else
    std::fesetenv(&modes_);
#endif
    if (omp_get_max_threads() != threads_) omp_set_num_threads(threads_);
  }
  CallersSettings(const CallersSettings&) = delete;
  CallersSettings& operator=(const CallersSettings&) = delete;

 private:
#if defined(__x86_64__)
  const unsigned modes_ = _mm_getcsr();
#else
  std::fenv_t modes_;
#endif
  const int threads_ = omp_get_max_threads();
};

}  // namespace mfs
