// Loops over long vectors by all threads of the team. A step has some fifty passes over vectors of n numbers
// beside its elements and its factors; by one thread they would take longer than a factorization on a device.
// Sums and largest values are taken in blocks of a fixed length, then over the blocks in order, so that no
// result depends on the number of threads. Short vectors are not worth waking threads for.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
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

/// combine(combine(first, f(0)), f(1)) ... over blocks, then combine over what the blocks have given.
template <class Value, class F, class Combine>
Value parallel_fold(std::size_t count, int threads, Value first, const F& f, const Combine& combine) {
  const auto n = static_cast<std::int64_t>(count), blocks = (n + kBlockLength - 1) / kBlockLength;
  std::vector<Value> folded(static_cast<std::size_t>(blocks), first);
#pragma omp parallel for num_threads(team_size(threads)) schedule(static) if (blocks > 2)
  for (std::int64_t b = 0; b < blocks; ++b) {
    Value value = first;
    for (std::int64_t i = b * kBlockLength; i < std::min(n, (b + 1) * kBlockLength); ++i)
      value = combine(value, f(static_cast<std::size_t>(i)));
    folded[static_cast<std::size_t>(b)] = value;
  }
  Value all = first;
  for (const Value& value : folded) all = combine(all, value);
  return all;
}

/// Root of the mean of (e(i) / w_i)^2: 1 is what the user's tolerances allow. Sums in a fixed order; e is
/// called once for each i.
template <class Error>
double weighted_rms(const Error& e, const std::vector<double>& weights, int threads) {
  const double sum = parallel_fold(
      weights.size(), threads, 0.0,
      [&](std::size_t i) {
        const double ratio = e(i) / weights[i];
        return ratio * ratio;
      },
      std::plus<>());
  return weights.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(weights.size()));
}

}  // namespace mfs::dae
