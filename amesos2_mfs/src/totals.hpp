// What all solvers of the process have done: the figures of Amesos2::mfs_totals().
#pragma once

#include <cstdint>
#include <functional>

namespace mfs::amesos2 {

enum class Phase { analysis, factorization, solve };

/// Runs `work` and counts it `times` times with the seconds that it took; not where it throws.
void counted(Phase phase, std::int64_t times, const std::function<void()>& work);

/// The bytes that one solver holds, as part of the total.
class CountedBytes {
 public:
  CountedBytes() = default;
  ~CountedBytes() { set(0); }
  CountedBytes(const CountedBytes&) = delete;
  CountedBytes& operator=(const CountedBytes&) = delete;
  void set(std::int64_t bytes);

 private:
  std::int64_t bytes_ = 0;
};

}  // namespace mfs::amesos2
