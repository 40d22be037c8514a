// One matrix from its values to a checked solution: what `mfs solve` and `mfs bench` have in common.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <mfs/options.hpp>

#include "parts/progress_display.hpp"
#include "solver/program/case_result.hpp"
#include "solver/program/matrix_market.hpp"

namespace mfs::program {

/// Of --rhs random: the same numbers every time.
constexpr std::uint64_t kRandomSeed = 20171121;

struct SolveRequest {
  Options options;
  std::string rhs = "ones";          ///< "ones", "random" or an array file
  std::optional<std::int64_t> nrhs;  ///< columns; a file brings its own
  bool transpose = false;
  double tolerance = 1e-12;  ///< for the solver and for the program's own check
  int refactor = 0;          ///< refactorizations and further solves with the same values, to time them
  std::string output;        ///< array file for X; empty: none
  bool condition = false;    ///< estimate the condition number
  bool determinant = false;
};

/// Throws nothing that concerns the case: the result says how far it came and what stopped it. A numerical
/// solution counts only if the program's own backward_error is small enough.
CaseResult solve_case(const std::string& name, const std::function<io::SquareMatrix()>& load,
                      const SolveRequest& request, ProgressDisplay& display);

}  // namespace mfs::program
