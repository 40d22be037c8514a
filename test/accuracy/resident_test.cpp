// Factors that lie elsewhere and refine there: where that misses the tolerance, the ladder goes on from what
// they have found, and asks for nothing twice. They are factors of the host whose inverse is wrong by a
// factor, and which count what they are asked for.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "accuracy/factorization.hpp"
#include "ordering/order_matrix.hpp"
#include "test/reference/generators.hpp"
#include "test/stages/artificial_problem.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {
namespace {

struct Counts {
  int starts = 0, corrections = 0;  // where the factors lie
  int inverses_of_b = 0;            // asked for by the ladder
  int inverses = 0;                 // of whatever
  int probes = 0, steps_together = 0;
  int solved = 0;  // where the factors lie, for arrays there
};

class CountingFactors final : public Factors<double>, public ResidentFactors<double> {
 public:
  CountingFactors(std::unique_ptr<Factors<double>> factors, const StageProblem<double>& problem, double wrong,
                  Counts& counts, const ProbeStep& step = {0, 0, 0, 0}, std::vector<ProbeStep> together = {})
      : factors_(std::move(factors)),
        problem_(problem),
        wrong_(wrong),
        counts_(counts),
        step_(step),
        together_(std::move(together)) {}

  double* matrix_values() override { return factors_->matrix_values(); }
  double* row_scale() override { return factors_->row_scale(); }
  double* column_scale() override { return factors_->column_scale(); }
  HostMatrix<double> matrix() override { return factors_->matrix(); }
  Factored factor(const PivotPolicy& policy, const std::function<void(double)>& progress) override {
    return factors_->factor(policy, progress);
  }
  void apply_inverse(const double* from, double* to, Vertex columns, bool transposed) override {
    ++counts_.inverses;
    if (std::equal(b_.begin(), b_.end(), from)) ++counts_.inverses_of_b;
    wrong_inverse(from, to, columns, transposed);
  }
  void make_room(Vertex columns) override { factors_->make_room(columns); }
  std::shared_ptr<char> host_vectors(Offset bytes) const override { return factors_->host_vectors(bytes); }
  Vertex local_row(Vertex position) const override { return factors_->local_row(position); }
  double pivot_shift(Vertex position) const override { return factors_->pivot_shift(position); }
  void diagonal_pivots(std::complex<double>* pivots) const override { factors_->diagonal_pivots(pivots); }
  MemorySpace memory() const override { return MemorySpace::device; }
  Offset bytes() const override { return factors_->bytes(); }
  ResidentFactors<double>* resident() override { return this; }

  void require_reachable(const void*, const char*) const override {}
  bool take_values(const double*, void*) override { return false; }
  void download(const double*, Offset, Offset, Vertex, double*, void*) override { FAIL(); }
  void upload(const double*, Offset, Vertex, double*, Offset, void*) override { FAIL(); }
  void start(const SolveBlock<double>& block, double, void*) override {
    ++counts_.starts;
    ASSERT_EQ(block.columns, 1);
    place_ = block.x;
    b_.assign(block.b, block.b + problem_.plan->n);
    x_.resize(b_.size());
    wrong_inverse(b_.data(), x_.data(), 1, false);
  }
  void start_from_host(const SolveBlock<double>& block, double row_floor) override {
    start(block, row_floor, nullptr);
  }
  double backward_error(double bound) override {
    double worst = 0;
    residual(&worst);
    if (worst <= bound) std::copy(x_.begin(), x_.end(), place_);
    return worst;
  }
  void correct() override {
    ++counts_.corrections;
    std::vector<double> r = residual(nullptr);
    wrong_inverse(r.data(), r.data(), 1, false);
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += r[i];
  }
  void bring_solution(double* x) override { std::copy(x_.begin(), x_.end(), x); }
  ProbeStep probe(bool) override {
    ++counts_.probes;
    return step_;
  }
  std::optional<ProbeStep> probe_together(bool from_nothing) override {
    if (from_nothing) EXPECT_EQ(counts_.steps_together, 0);
    const auto step = static_cast<std::size_t>(counts_.steps_together++);
    return step < together_.size() ? std::optional(together_[step]) : std::nullopt;
  }
  void solve_as(const PivotPolicy&) override {}

 private:
  void wrong_inverse(const double* from, double* to, Vertex columns, bool transposed) {
    factors_->apply_inverse(from, to, columns, transposed);
    for (Offset i = 0; i < static_cast<Offset>(problem_.plan->n) * columns; ++i) to[i] *= wrong_;
  }
  std::vector<double> residual(double* worst) const {
    const Pattern& pattern = *problem_.pattern;
    std::vector<double> r = b_;
    for (Vertex row = 0; row < pattern.n; ++row) {
      double size = std::abs(b_[row]);
      for (Offset k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k) {
        const double term = problem_.values[k] * x_[pattern.columns[k]];
        r[row] -= term;
        size += std::abs(term);
      }
      if (worst) *worst = std::max(*worst, std::abs(r[row]) / size);
    }
    return r;
  }

  std::unique_ptr<Factors<double>> factors_;
  const StageProblem<double>& problem_;
  double wrong_;
  Counts& counts_;
  ProbeStep step_;                   // that each probe finds
  std::vector<ProbeStep> together_;  // what steps together find
  double* place_ = nullptr;
  std::vector<double> b_, x_;
};

StageProblem<double> problem() {
  const SparseMatrix matrix = grid_2d(11, 9);
  return matrix_problem(matrix, order_matrix(pattern_of(matrix), MatchedScaling(), AnalysisOptions(), 1), 64);
}

enum class From { host, device };

/// Solves for A times ones and expects these, whose error is as good as the tolerance.
Counts solve(double wrong, From from) {
  Counts counts;
  const StageProblem<double> system = problem();
  in_engine(1, [&] {
    auto factors = std::make_unique<CountingFactors>(
        make_host_factors<double>(HostSpace::serial, false, system.plan, system.pattern, 1), system, wrong,
        counts);
    fill(system, *factors);
    const auto numeric =
        make_factorization<double>(HostSpace::serial, std::move(factors), system.plan, system.pattern);
    numeric->factor(1e-8, {});
    const Vertex n = system.plan->n;
    std::vector<double> b(static_cast<std::size_t>(n), 0.0), x(b);
    for (Vertex row = 0; row < n; ++row) {
      for (Offset k = system.pattern->offsets[row]; k < system.pattern->offsets[row + 1]; ++k)
        b[row] += system.values[k];
    }
    SolveOutcome outcome;
    if (from == From::device) {
      const auto found =
          numeric->solve_resident({b.data(), n, x.data(), n, 1}, SolveControls(), nullptr, outcome);
      EXPECT_EQ(found, wrong == 1 ? ResidentSolve::solved : ResidentSolve::missed);
    }
    if (from == From::host || wrong != 1) {
      std::copy(b.begin(), b.end(), numeric->rhs(1));
      outcome = numeric->solve(1, nullptr, SolveControls(), from == From::device ? &outcome : nullptr);
      std::copy(numeric->solution(), numeric->solution() + n, x.begin());
    }
    EXPECT_LE(outcome.backward_error, SolveControls().tolerance);
    EXPECT_THAT(x, testing::Each(testing::DoubleNear(1, 1e-9)));
    EXPECT_EQ(outcome.krylov_steps > 0, wrong != 1);
    EXPECT_GE(outcome.refinement_steps, counts.corrections);
  });
  return counts;
}

TEST(Resident, ASolveThatReachesTheToleranceNeedsNothingElse) {
  for (const From from : {From::host, From::device}) {
    const Counts counts = solve(1, from);
    EXPECT_EQ(counts.starts, 1);
    EXPECT_EQ(counts.inverses_of_b, 0);
  }
}

// 0.4 of the inverse: an error of 0.6, 0.36, ..., which is not halved, so the ladder goes on after one
// correction.
TEST(Resident, ASolveThatMissesTheToleranceIsNotRepeated) {
  for (const From from : {From::host, From::device}) {
    const Counts counts = solve(0.3, from);
    EXPECT_EQ(counts.starts, 1);
    EXPECT_GE(counts.corrections, 1);
    EXPECT_LE(counts.corrections, 2);
    EXPECT_EQ(counts.inverses_of_b, 0);
  }
}

// 2.5 of the inverse: the correction makes the error 1.5 times as large, so the ladder begins anew, but not
// there.
TEST(Resident, ASolutionThatACorrectionMadeWorseIsNotTaken) {
  for (const From from : {From::host, From::device}) {
    const Counts counts = solve(2.5, from);
    EXPECT_EQ(counts.starts, 1);
    EXPECT_EQ(counts.corrections, 1);
    EXPECT_EQ(counts.inverses_of_b, 1);
  }
}

/// Where tiny pivots are divided by: two solves for A times ones, if each probe there finds `step`, and steps
/// together what is given.
Counts solve_after_probes(const ProbeStep& step, From from, const std::vector<ProbeStep>& together = {}) {
  Counts counts;
  const StageProblem<double> system = problem();
  in_engine(1, [&] {
    auto factors = std::make_unique<CountingFactors>(
        make_host_factors<double>(HostSpace::serial, false, system.plan, system.pattern, 1), system, 1,
        counts, step, together);
    fill(system, *factors);
    const auto numeric =
        make_factorization<double>(HostSpace::serial, std::move(factors), system.plan, system.pattern);
    numeric->factor(PivotPolicy(1e-8, TinyPivots::data, 1e-8), {});
    const Vertex n = system.plan->n;
    std::vector<double> b(static_cast<std::size_t>(n), 1.0), x(b);
    for (int solve = 0; solve < 2; ++solve) {
      SolveOutcome outcome;
      const SolveBlock<double> block{b.data(), n, x.data(), n, 1};
      if (from == From::device &&
          numeric->solve_resident(block, SolveControls(), nullptr, outcome) == ResidentSolve::solved) {
        ++counts.solved;
        continue;
      }
      std::copy(b.begin(), b.end(), numeric->rhs(1));
      outcome = numeric->solve(1, nullptr, SolveControls());
      EXPECT_EQ(outcome.dependent_rows, 0);
      EXPECT_LE(outcome.backward_error, SolveControls().tolerance);
    }
  });
  return counts;
}

TEST(Resident, AProbeThatProvesItThereIsAskedForOnceAndNotRepeatedOnTheHost) {
  for (const From from : {From::host, From::device}) {
    for (const ProbeStep& regular : {ProbeStep{1e-9, 1, 1, 1}, ProbeStep{1e-9, 1e9, 1e-6, 1e9}}) {
      const Counts counts = solve_after_probes(regular, from);
      EXPECT_EQ(counts.probes, 1);
      EXPECT_EQ(counts.inverses, 0);
      EXPECT_EQ(counts.starts, 2);
      EXPECT_EQ(counts.solved, from == From::device ? 2 : 0);
    }
  }
}

TEST(Resident, StepsTogetherProveItThereWhereThoseAloneDoNot) {
  for (const From from : {From::host, From::device}) {
    const Counts counts =
        solve_after_probes({1, 1, 1, 1}, from, {{1, 1, 1, 1}, {0.5, 1, 1, 1}, {1e-9, 1e9, 1e-6, 1e9}});
    EXPECT_EQ(counts.probes, 2);
    EXPECT_EQ(counts.steps_together, 3);
    EXPECT_EQ(counts.inverses, 0);
    EXPECT_EQ(counts.starts, 2);
    EXPECT_EQ(counts.solved, from == From::device ? 2 : 0);
  }
}

// They stop where the residual does not become less, is no number, may be left by a null vector, or where
// there is no room for more.
TEST(Resident, WhatStepsTogetherLeaveOpenIsSettledOnTheHost) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN(),
                   kInfinite = std::numeric_limits<double>::infinity();
  struct Case {
    std::vector<ProbeStep> together;
    int steps;
  };
  const ProbeStep open{0.5, 1, 1, 1};
  for (const From from : {From::host, From::device}) {
    for (const Case& one : {Case{std::vector<ProbeStep>(20, open), 6}, Case{{open, {kInfinite, 1, 1, 1}}, 2},
                            Case{{{kNone, kNone, kNone, kNone}}, 1}, Case{{open, {1e-9, 1, 1e-17, 1}}, 2},
                            Case{{open, {1e-9, 1, kNone, 1}}, 2}, Case{{open, open}, 3}}) {
      const Counts counts = solve_after_probes({1, 1, 1, 1}, from, one.together);
      EXPECT_EQ(counts.steps_together, one.steps);
      EXPECT_GE(counts.inverses, 1);
      EXPECT_EQ(counts.solved, from == From::device ? 1 : 0);
    }
  }
}

// What is left does not become small, or is no number, or was left by what may be a null vector.
TEST(Resident, WhatAProbeThereLeavesOpenIsSettledOnTheHost) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const From from : {From::host, From::device}) {
    for (const ProbeStep& open : {ProbeStep{1, 1, 1, 1}, ProbeStep{kNone, kNone, kNone, kNone},
                                  ProbeStep{1e-9, 1e9, 1e-8, 1e9}, ProbeStep{1e-9, 1e9, kNone, 1e9}}) {
      const Counts counts = solve_after_probes(open, from);
      EXPECT_GE(counts.probes, 1);
      EXPECT_LE(counts.probes, 2);
      EXPECT_GE(counts.inverses, 1);
      EXPECT_EQ(counts.starts, 2);
      EXPECT_EQ(counts.solved, from == From::device ? 1 : 0);
    }
  }
}

}  // namespace
}  // namespace mfs::test
