// What is known about one matrix after `mfs solve` or `mfs bench` went through it, or as far as it came.
#pragma once

#include <complex>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <mfs/options.hpp>
#include <mfs/report.hpp>

#include "parts/exit_code.hpp"
#include "solver/program/rates.hpp"

namespace mfs::program {

struct CaseResult {
  std::string name;
  std::int64_t n = 0;
  std::int64_t entries = 0;  ///< as read, both triangles, duplicates apart
  Backend backend = Backend::openmp;
  int threads = 0;  ///< as asked for; the report knows better once the solver ran
  bool complex = false;
  std::int64_t right_hand_sides = 0;
  int refactorizations = 0;
  double tolerance = 0;

  double time_read = 0;      ///< s
  double time_refactor = 0;  ///< s, the least of all refactorizations; 0 without any
  double time_solve = 0;     ///< s, the least of all solves; 0 without any
  /// The solver's report, once the matrix was analysed; its later figures are 0 until their phase is through.
  std::optional<Report> report;
  /// The program's own figure for the x that was returned.
  std::optional<double> backward_error;
  // Where they were asked for.
  std::optional<double> condition;  ///< infinite for a singular matrix
  std::optional<Determinant<std::complex<double>>> determinant;
  /// Those that were asked for in vain, since more pivots were perturbed than can be taken back.
  std::vector<std::string> not_known;
  std::vector<DepthSummary> depths;  ///< of the tree in use, once the matrix was analysed
  /// From the rates of this machine, or else why there is none.
  std::optional<Prediction> prediction;
  std::string no_prediction;

  ExitCode code = ExitCode::solved;
  std::string message;
};

}  // namespace mfs::program
