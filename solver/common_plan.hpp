// Factors of one plan for one system of a batch after another, by the thread that calls. Nothing is left of
// a system when the next comes, so that what is computed depends on its own numbers alone.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include <mfs/error.hpp>
#include <mfs/options.hpp>

#include "accuracy/factorization.hpp"
#include "ordering/matrix_check.hpp"
#include "solver/analysis.hpp"
#include "solver/option_checks.hpp"
#include "solver/solve_rules.hpp"

namespace mfs {

/// One system: right-hand sides and the place of their solutions are n x nrhs, column-major.
template <class Scalar>
struct BatchedSystem {
  CsrView<Scalar> a;
  const Scalar* b;
  Scalar* x;
  Offset nrhs, ldb, ldx;
};

/// What a solution took, the most of its columns.
struct BatchedOutcome {
  double backward_error = 0;
  Rung rung = Rung::factors;
};

template <class Scalar>
class CommonPlan {
 public:
  /// `analysis` must outlive this. The factors are `single_precision` or not.
  CommonPlan(const Options& options, const Analysis& analysis, std::unique_ptr<Factorization<Scalar>> numeric,
             bool single_precision)
      : analysis_(analysis),
        numeric_(std::move(numeric)),
        policy_(pivot_tolerance_of<Scalar>(options.factor, single_precision)),
        controls_(controls_of<Scalar>(options.solve)) {
    const MatchedScaling& matched = analysis_.matched;
    std::copy(matched.row_scale.begin(), matched.row_scale.end(), numeric_->factors().row_scale());
    std::copy(matched.column_scale.begin(), matched.column_scale.end(), numeric_->factors().column_scale());
  }

  /// Writes the solution if all columns reach the tolerance with these factors. False where more has to be
  /// done, and x is as it was. Throws InvalidInput (NaN or infinity), std::bad_alloc.
  bool solve(const BatchedSystem<Scalar>& system, BatchedOutcome& outcome) {
    check_values(system.a, 1);
    check_finite(static_cast<Offset>(analysis_.pattern->n), system.nrhs, system.b, system.ldb);
    sum_into_slots(*analysis_.pattern, system.a, numeric_->factors().matrix_values(), 1);
    const FactorStatus status = numeric_->factor(policy_, {});
    if (status.nonfinite > 0 || status.perturbed > kMostCorrected) return false;
    const Offset n = analysis_.pattern->n, block = numeric_->factors().columns_at_once();
    solution_.resize(static_cast<std::size_t>(n * system.nrhs));
    for (Offset first = 0; first < system.nrhs; first += block) {
      if (!solve_block(system, first, std::min(block, system.nrhs - first), outcome)) return false;
    }
    for (Offset j = 0; j < system.nrhs; ++j)
      std::copy(solution_.data() + j * n, solution_.data() + (j + 1) * n, system.x + j * system.ldx);
    return true;
  }

 private:
  bool solve_block(const BatchedSystem<Scalar>& system, Offset first, Offset count, BatchedOutcome& outcome) {
    const Offset n = analysis_.pattern->n;
    const auto columns = static_cast<Vertex>(count);
    Scalar* rhs = numeric_->rhs(columns);
    for (Offset j = 0; j < count; ++j) {
      const Scalar* b = system.b + (first + j) * system.ldb;
      std::copy(b, b + n, rhs + j * n);
    }
    const SolveOutcome found = numeric_->solve(columns, nullptr, controls_);
    const bool reached = found.backward_error <= controls_.tolerance;
    if (!reached || found.doubtful || found.dependent_rows > 0) return false;
    outcome.backward_error = std::max(outcome.backward_error, found.backward_error);
    outcome.rung = std::max(outcome.rung, rung_of(found));
    std::copy(numeric_->solution(), numeric_->solution() + n * count, solution_.data() + first * n);
    return true;
  }

  const Analysis& analysis_;
  const std::unique_ptr<Factorization<Scalar>> numeric_;
  const PivotPolicy policy_;
  const SolveControls controls_;
  std::vector<Scalar> solution_;  // n x nrhs
};

}  // namespace mfs
