// What every solve has in common, for one system or for each of a batch: what it must reach by the options,
// which right-hand sides it takes, and the name of what it took.
#pragma once

#include <algorithm>
#include <cmath>

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

/// Of n x count right-hand sides with the leading dimension ldb, of which the caller has `before` others.
/// Throws InvalidInput("b") with the first row and column, counted from the caller's first, that is NaN or
/// infinite.
template <class Scalar>
void check_finite(Offset n, Offset count, const Scalar* b, Offset ldb, Offset before = 0) {
  const auto bad = [](const Scalar& entry) { return !std::isfinite(std::abs(entry)); };
  for (Offset j = 0; j < count; ++j) {
    const Scalar *begin = b + j * ldb, *end = begin + n;
    // Counting takes half of the time of searching: it looks at several entries at once.
    if (std::count_if(begin, end, bad) > 0)
      throw InvalidInput("b", "NaN or infinity", std::find_if(begin, end, bad) - begin, before + j);
  }
}

/// Of the rungs that the present factors have.
inline Rung rung_of(const SolveOutcome& outcome) {
  return outcome.krylov_steps > 0       ? Rung::krylov
         : outcome.refinement_steps > 0 ? Rung::refinement
         : outcome.corrected_pivots > 0 ? Rung::correction
                                        : Rung::factors;
}

}  // namespace mfs
