// The last error of each thread. Keeping it allocates nothing, as it may tell of memory that was refused.
#pragma once

#include <cstdint>

namespace mfs::c {

struct LastError {
  int status = 0;
  char text[1024] = "";
  char argument[64] = "";
  std::int64_t row = -1, column = -1;
};

/// That of this thread.
LastError& last_error() noexcept;

/// Keeps the exception that is being handled. Returns its status.
int keep_current_exception() noexcept;

/// Runs `work`, and lets nothing out but a status.
template <class Work>
int attempt(const Work& work) noexcept {
  try {
    work();
    return 0;
  } catch (...) {
    return keep_current_exception();
  }
}

}  // namespace mfs::c
