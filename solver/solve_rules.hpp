// What every solve has in common, for one system or for each of a batch: what it must reach by the options,
// which right-hand sides it takes, and the name of what it took.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include <mfs/error.hpp>
#include <mfs/options.hpp>
#include <mfs/report.hpp>

#include "accuracy/solve_controls.hpp"
#include "solver/option_checks.hpp"

namespace mfs {

template <class Scalar>
SolveControls controls_of(const SolveOptions& options) {
  return {tolerance_of<Scalar>(options), options.max_refinement_steps, options.row_floor,
          options.solve_singular};
}

/// count * stride, where so many numbers of `bytes` can have addresses. Throws InvalidInput (`name`).
inline Offset addressed(const char* name, Offset count, Offset stride, std::size_t bytes) {
  const Offset most = std::numeric_limits<Offset>::max() / static_cast<Offset>(bytes);
  if (stride > most / std::max<Offset>(count, 1)) throw InvalidInput(name, "leads beyond all addresses");
  return count * stride;
}

/// Calls work(column, begin, end) for all rows [begin, end) of all columns, in blocks of which threads do
/// some each.
template <class Work>
void for_blocks_of_columns(Offset n, Offset count, int threads, const Work& work) {
  constexpr Offset kRows = 4096;
  const Offset blocks = (n + kRows - 1) / kRows, all = blocks * count;
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1)
  for (Offset k = 0; k < all; ++k) {
    const Offset begin = k % blocks * kRows;
    work(k / blocks, begin, std::min(begin + kRows, n));
  }
}

/// Of n x count right-hand sides with the leading dimension ldb, of which the caller has `before` others.
/// Throws InvalidInput("b") with the first row and column, counted from the caller's first, that is NaN or
/// infinite.
template <class Scalar>
void check_finite(Offset n, Offset count, const Scalar* b, Offset ldb, Offset before = 0, int threads = 1) {
  const auto bad = [](const Scalar& entry) { return !std::isfinite(std::abs(entry)); };
  std::atomic<bool> good{true};
  for_blocks_of_columns(n, count, threads, [&](Offset j, Offset begin, Offset end) {
    // Counting takes half of the time of searching: it looks at several entries at once.
    if (std::count_if(b + j * ldb + begin, b + j * ldb + end, bad) > 0) good = false;
  });
  for (Offset j = 0; !good && j < count; ++j) {
    const Scalar *begin = b + j * ldb, *end = begin + n, *found = std::find_if(begin, end, bad);
    if (found != end) throw InvalidInput("b", "NaN or infinity", found - begin, before + j);
  }
}

/// to = from, n x count each.
template <class Scalar>
void copy_columns(Offset n, Offset count, const Scalar* from, Offset from_ld, Scalar* to, Offset to_ld,
                  int threads) {
  for_blocks_of_columns(n, count, threads, [=](Offset j, Offset begin, Offset end) {
    std::copy(from + j * from_ld + begin, from + j * from_ld + end, to + j * to_ld + begin);
  });
}

/// Of the rungs that the present factors have.
inline Rung rung_of(const SolveOutcome& outcome) {
  return outcome.krylov_steps > 0       ? Rung::krylov
         : outcome.refinement_steps > 0 ? Rung::refinement
         : outcome.corrected_pivots > 0 ? Rung::correction
                                        : Rung::factors;
}

}  // namespace mfs
