// Loops over long vectors on the host by all threads of the team. A step has some fifty passes over vectors
// of n numbers beside its elements and its factors; by one thread they would take longer than a factorization
// on a device. Sums and largest values are taken in blocks of a fixed length, then over the blocks in order,
// so that no result depends on the number of threads. Short vectors are not worth waking threads for.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mfs::dae {

/// Threads of a team that was asked for as `threads` (0: all).
inline int team_size(int threads) {
  return threads > 0 ? threads : omp_get_max_threads();
}

constexpr std::int64_t kBlockLength = 4096;

/// f(i) for all i in 0 ... count - 1, which looks at `work` numbers in all (0: one each).
template <class F>
void parallel_for(std::size_t count, int threads, const F& f, std::size_t work = 0) {
  const auto n = static_cast<std::int64_t>(count);
  const bool worth_threads = std::max(count, work) > 2 * kBlockLength;
#pragma omp parallel for num_threads(team_size(threads)) schedule(static) if (worth_threads)
  for (std::int64_t i = 0; i < n; ++i) f(static_cast<std::size_t>(i));
}

/// f(i) for all i in 0 ... start.size() - 2, which take start[i + 1] - start[i] operations: each thread gets
/// consecutive ones with as many operations as the others have.
template <class F>
void parallel_for_shares(const std::vector<std::size_t>& start, int threads, const F& f) {
  const std::size_t count = start.size() - 1, work = start.back();
  const bool worth_threads = work > 2 * kBlockLength;
#pragma omp parallel num_threads(team_size(threads)) if (worth_threads)
  {
    const auto team = static_cast<std::size_t>(omp_get_num_threads());
    const auto own = static_cast<std::size_t>(omp_get_thread_num());
    const auto first = [&](std::size_t part) {
      if (part == team) return count;
      const auto end = start.begin() + static_cast<std::ptrdiff_t>(count);
      return static_cast<std::size_t>(std::lower_bound(start.begin(), end, work / team * part) -
                                      start.begin());
    };
    for (std::size_t i = first(own), end = first(own + 1); i < end; ++i) f(i);
  }
}

/// All f(i), combined; `none` is that of nothing. In each block four values at a time, so that no operation
/// has to wait for the one before it.
template <class Value, class F, class Combine>
Value parallel_fold(std::size_t count, int threads, Value none, const F& f, const Combine& combine) {
  constexpr std::int64_t kAtOnce = 4;
  const auto n = static_cast<std::int64_t>(count), blocks = (n + kBlockLength - 1) / kBlockLength;
  std::vector<Value> folded(static_cast<std::size_t>(blocks), none);
#pragma omp parallel for num_threads(team_size(threads)) schedule(static) if (blocks > 2)
  for (std::int64_t b = 0; b < blocks; ++b) {
    const std::int64_t end = std::min(n, (b + 1) * kBlockLength);
    Value value[kAtOnce] = {none, none, none, none};
    std::int64_t i = b * kBlockLength;
    for (; i + kAtOnce <= end; i += kAtOnce)
      for (std::int64_t k = 0; k < kAtOnce; ++k)
        value[k] = combine(value[k], f(static_cast<std::size_t>(i + k)));
    for (; i < end; ++i) value[0] = combine(value[0], f(static_cast<std::size_t>(i)));
    folded[static_cast<std::size_t>(b)] = combine(combine(value[0], value[1]), combine(value[2], value[3]));
  }
  Value all = none;
  for (const Value& value : folded) all = combine(all, value);
  return all;
}

/// f(begin, end) for consecutive parts of 0 ... count - 1, short enough to stay in a core's first cache while
/// one array after the other is read for them.
template <class F>
void parallel_for_parts(std::size_t count, int threads, const F& f) {
  constexpr std::int64_t kPart = 512;
  const auto n = static_cast<std::int64_t>(count), parts = (n + kPart - 1) / kPart;
#pragma omp parallel for num_threads(team_size(threads)) schedule(static) if (n > 2 * kBlockLength)
  for (std::int64_t part = 0; part < parts; ++part)
    f(static_cast<std::size_t>(part * kPart), static_cast<std::size_t>(std::min(n, (part + 1) * kPart)));
}

}  // namespace mfs::dae
