// What is done with the Jacobian of a step: which blocks are evaluated, how long a matrix and its factors are
// kept, what becomes of corrections by the matrix of another step.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/integrator/step_equations.hpp"
#include "test/dae/integrator/pendulum.hpp"
#include "test/dae/mechanics/dense.hpp"

namespace mfs::dae::test {
namespace {

/// Counts what the integrator asks for.
class Counted : public DenseSystem<Pendulum> {
 public:
  Counted() { pattern_.constant[static_cast<std::size_t>(Block::force_a)] = true; }
  using DenseSystem<Pendulum>::evaluate;
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override {
    DenseSystem<Pendulum>::evaluate(state, tangent, blocks);
    for (int b = 0; b < kBlocks; ++b)
      if (blocks.has(static_cast<Block>(b))) ++asked[b];
  }
  mutable std::array<std::int64_t, kBlocks> asked{};
};

void expect_few_blocks(Unknowns unknowns, std::int64_t for_first_jacobian) {
  SCOPED_TRACE(static_cast<int>(unknowns));
  const Counted system;
  IntegratorOptions options;
  options.unknowns = unknowns;
  Integrator integrator(system, options);
  Observer nobody;
  integrator.run(0.0, pendulum_at(1.0), {0.0, 0.0}, 1.0, {}, nobody);
  const IntegrationReport& report = integrator.report();
  ASSERT_GT(report.jacobians, 5);
  for (const Block block :
       {Block::force_q, Block::force_v, Block::velocity_q, Block::acceleration_q, Block::acceleration_v})
    EXPECT_EQ(system.asked[static_cast<std::size_t>(block)], report.jacobians);
  EXPECT_EQ(system.asked[static_cast<std::size_t>(Block::force_a)], 1);  // once for all Jacobians
  // For each Jacobian, the directions of each attempt at a step, the projection (twice), and to see which
  // constraints are redundant.
  const std::int64_t attempts =
      report.steps + report.error_rejections + report.newton_rejections + report.solver_rejections;
  EXPECT_EQ(system.asked[static_cast<std::size_t>(Block::position_q)],
            report.jacobians + attempts + 2 + 1 + for_first_jacobian);
}

TEST(Jacobian, AsksForNoMoreBlocksThanItNeeds) {
  expect_few_blocks(Unknowns::full, 1);     // its directions
  expect_few_blocks(Unknowns::reduced, 0);  // condensed
}

/// Masses on nonlinear springs, all tied to each other: a dense matrix, whose factorization is worth several
/// solves.
class Bundle : public ConstrainedSystem {
 public:
  Bundle() {
    Pattern dense{kMasses, kMasses, {0}, {}}, diagonal = dense, none{0, kMasses, {0}, {}};
    for (int i = 0; i < kMasses; ++i) {
      for (int j = 0; j < kMasses; ++j) dense.column.push_back(j);
      dense.row_start.push_back(static_cast<int>(dense.column.size()));
      diagonal.column.push_back(i);
      diagonal.row_start.push_back(i + 1);
    }
    pattern_.block = {
        dense, Pattern{kMasses, kMasses, std::vector<int>(kMasses + 1), {}}, diagonal, none, none, none,
        none};
    pattern_.constant[static_cast<std::size_t>(Block::force_a)] = true;
  }
  int coordinates() const override { return kMasses; }
  int constraints() const override { return 0; }
  const TangentPattern& tangent_pattern() const override { return pattern_; }
  void evaluate(const StateView& state, Residual& residual) const override {
    double sum = 0.0;
    for (int i = 0; i < kMasses; ++i) sum += weight(i) * state.q[i];
    for (int i = 0; i < kMasses; ++i)
      residual.force[i] = state.a[i] +
                          (100.0 * (1.0 + state.q[i] * state.q[i]) + moving(i, state.t)) * state.q[i] +
                          weight(i) * sum;
  }
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override {
    if (blocks.has(Block::force_a)) tangent[Block::force_a].assign(kMasses, 1.0);
    if (!blocks.has(Block::force_q)) return;
    double* value = tangent[Block::force_q].data();
    for (int i = 0; i < kMasses; ++i)
      for (int j = 0; j < kMasses; ++j)
        *value++ = weight(i) * weight(j) +
                   (i == j ? 100.0 * (1.0 + 3.0 * state.q[i] * state.q[i]) + moving(i, state.t) : 0.0);
  }

  static constexpr int kMasses = 700;
  double swing = 0.0;  ///< of stiffnesses that change with time, each by itself

 private:
  double moving(int i, double t) const { return swing * (1.0 + 0.9 * std::sin(100.0 * t + i)); }
  static double weight(int i) { return 1.0 + 0.5 * std::sin(i); }
  TangentPattern pattern_;
};

/// Where the bundle is after `time`; `swing` as in Bundle.
State run_bundle(double time, int krylov_steps, IntegrationReport& report, double swing = 0.0) {
  Bundle system;
  system.swing = swing;
  IntegratorOptions options;
  options.rtol = options.atol_position = options.atol_velocity = 1e-5;
  options.krylov_steps = krylov_steps;
  if (swing > 0) options.initial_step = 1e-3;  // with much shorter ones all matrices are alike
  options.threads = 1;
  options.backend = Backend::serial;
  Integrator integrator(system, options);
  Observer nobody;
  std::vector<double> q0(Bundle::kMasses);
  for (std::size_t i = 0; i < q0.size(); ++i) q0[i] = std::cos(static_cast<double>(i));
  State end = integrator.run(0.0, q0, std::vector<double>(q0.size(), 0.0), time, {}, nobody);
  report = integrator.report();
  return end;
}

TEST(Jacobian, IsSolvedOnTheFactorsOfAnOlderOneWhereThatIsCheaper) {
  IntegrationReport with, without;
  const State end = run_bundle(0.2, 8, with), other = run_bundle(0.2, 0, without);
  EXPECT_GT(with.krylov_solves, 0);
  EXPECT_LT(with.factorizations, with.jacobians);
  EXPECT_EQ(without.krylov_solves, 0);
  EXPECT_EQ(without.factorizations, 1 + without.jacobians);  // one for the initial accelerations
  for (std::size_t i = 0; i < end.q.size(); ++i) ASSERT_NEAR(end.q[i], other.q[i], 1e-4) << i;
}

TEST(Jacobian, IsFactoredAtOnceWhereFgmresHasLostAFactorization) {
  IntegrationReport report;
  run_bundle(0.1, 1, report, 1e5);  // one step of FGMRES does not suffice
  EXPECT_GT(report.jacobians, 20);
  EXPECT_EQ(report.factorizations, 1 + report.jacobians);
  EXPECT_GT(report.krylov_solves, 0);
  EXPECT_LE(report.krylov_solves, 6);  // what a factorization is worth
}

TEST(Jacobian, IsFactoredAtOnceWhereItsSystemsAreMoreThanAFactorizationIsWorth) {
  IntegrationReport report;
  run_bundle(0.3, 8, report, 5.0);
  EXPECT_GT(report.jacobians, 4);
  EXPECT_GT(report.newton_iterations, 20 * report.jacobians);
  EXPECT_EQ(report.krylov_solves, 0);
}

/// Three springs whose elongations add up to zero: all equations are linear.
struct Linear {
  int coordinates() const { return 3; }
  int constraints() const { return 1; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    std::vector<T> f;
    for (int i = 0; i < 3; ++i) f.push_back(T(a[i] + 3.0 * v[i] + (10.0 + 700.0 * i) * q[i]));
    return f;
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {q[0] + q[1] + q[2]};
  }
};

const Executor& host() {
  static const Executor executor(Executor::Place::host, 1);
  return executor;
}

StepRelation relation_at(double rate, const std::vector<double>& q, const std::vector<double>& v,
                         const std::vector<double>& a) {
  return {0.0, 1.0 / rate, 1.0 / rate, make_array(host(), q), make_array(host(), v), make_array(host(), a)};
}

/// Of three coordinates and a constraint that is linear in the last one.
Projection last_is_tied() {
  Projection projection = no_projection(3);
  projection.role[2] = Role::tied;
  return projection;
}

/// The matrix that is factored, of `state`.
Eigen::MatrixXd jacobian(const StepEquations& equations, const StepState& state,
                         const StepRelation& relation) {
  const Pattern& pattern = equations.pattern();
  std::vector<double> values(pattern.entries());
  equations.jacobian(state, relation, values.data());
  if (equations.remote_matrix() != nullptr) equations.remote_matrix()->read(values.data());
  return mfs::test::dense(pattern, values);
}

TEST(Jacobian, OneCorrectionSolvesLinearEquationsAndThatOfAnotherStepKeepsConstraintsAndRelations) {
  const DenseSystem<Linear> system;
  const auto relation = [](double rate) {
    return relation_at(rate, {1.0, -3.0, 2.0}, {-5.0, 2.0, 3.0}, {100.0, 30.0, -130.0});
  };
  for (const Unknowns unknowns : {Unknowns::full, Unknowns::reduced})
    for (const double factor : {0.8, 1.0, 1.25}) {
      const StepEquations equations(system, unknowns, last_is_tied(), host());
      const auto n = static_cast<Eigen::Index>(equations.size());
      const StepRelation old = relation(20.0), now = relation(20.0 * factor);
      Eigen::VectorXd x(n), h(n), b(n);
      StepState state;
      const double lambda = 0.7;
      equations.pack(now, &lambda, x.data());
      equations.unpack(x.data(), now, state);
      equations.residual(x.data(), state, now, h.data());

      const Eigen::MatrixXd matrix = jacobian(equations, state, old);
      EXPECT_NEAR(equations.ratio(now), factor * factor, 1e-12);
      equations.scale_rows(now, h.data(), b.data());
      const Eigen::VectorXd solution = matrix.lu().solve(b);
      Eigen::VectorXd correction(n);
      equations.correct(now, solution.data(), correction.data());
      x -= correction;

      const double before = h.head(3).norm();
      equations.unpack(x.data(), now, state);
      equations.residual(x.data(), state, now, h.data());
      EXPECT_LT(h.head(3).norm(), (factor == 1.0 ? 1e-9 : 0.5) * before);  // F gets smaller,
      EXPECT_LT(h.tail(n - 3).norm(), 1e-9);                               // and all else stays fulfilled
    }
}

TEST(Jacobian, OneCorrectionByThatOfAnotherStepMeetsConstraintsThatWereOff) {
  const DenseSystem<Linear> system;
  const auto relation = [](double rate) {
    return relation_at(rate, {1.0, -3.0, 2.5}, {-5.0, 2.0, 3.7}, {100.0, 30.0, -90.0});
  };
  for (const Unknowns unknowns : {Unknowns::full, Unknowns::reduced})
    for (const double factor : {0.8, 1.0, 1.25}) {
      const StepEquations equations(system, unknowns, last_is_tied(), host());
      const auto n = static_cast<Eigen::Index>(equations.size());
      const StepRelation old = relation(20.0), now = relation(20.0 * factor);
      Eigen::VectorXd x(n), h(n), b(n), correction(n);
      StepState state;
      const double lambda = 0.7;
      equations.pack(now, &lambda, x.data());
      equations.unpack(x.data(), now, state);
      equations.residual(x.data(), state, now, h.data());
      EXPECT_GT(h.segment(equations.first_constraint(), StepEquations::kLevels).cwiseAbs().minCoeff(), 0.4);

      const Eigen::MatrixXd matrix = jacobian(equations, state, old);
      equations.scale_rows(now, h.data(), b.data());
      const Eigen::VectorXd solution = matrix.lu().solve(b);
      equations.correct(now, solution.data(), correction.data());
      x -= correction;
      equations.unpack(x.data(), now, state);
      equations.residual(x.data(), state, now, h.data());
      EXPECT_LT(h.tail(n - 3).norm(), 1e-9) << factor;
    }
}

/// A stiff spring between two small masses, the second of which is tied to a coordinate without inertia.
struct Tied {
  int coordinates() const { return 3; }
  int constraints() const { return 1; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    const T pull = 1e9 * (q[1] - q[0]) + 1e4 * (v[1] - v[0]);
    return {T(1e-3 * a[0] - pull), T(1e-3 * a[1] + pull), T(0.0 * a[2])};
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {q[1] - q[2]};
  }
};

TEST(Jacobian, HasAPivotWithoutInertiaAndNoStepMakesItLargeOrSmall) {
  const DenseSystem<Tied> system;
  for (const Unknowns unknowns : {Unknowns::full, Unknowns::reduced})
    for (const double rate : {1.0, 1e3, 1e6, 1e9}) {
      const StepEquations equations(system, unknowns, last_is_tied(), host());
      const std::vector<double> rest(3, 0.0);
      const StepRelation relation = relation_at(rate, rest, rest, rest);
      StepState state;
      assign(host(), State{0.0, rest, rest, rest, {0.0}}, state);
      const Eigen::MatrixXd matrix = jacobian(equations, state, relation);
      EXPECT_GT(matrix(2, 1 + 2), 0.1) << rate;  // behind one multiplier
      EXPECT_LT(matrix.cwiseAbs().maxCoeff(), 5.0) << rate;
      EXPECT_GT(matrix.rowwise().lpNorm<Eigen::Infinity>().minCoeff(), 0.1) << rate;
      EXPECT_GT(matrix.colwise().lpNorm<Eigen::Infinity>().minCoeff(), 0.1) << rate;
    }
}

class AwayMatrix : public RemoteMatrix {
 public:
  AwayMatrix(std::size_t entries, std::vector<int> places)
      : values_(entries), places_(std::move(places)), own_(places_.size(), 1e9) {}
  double* own() override { return own_.data(); }
  void begin() override {
    std::fill(values_.begin(), values_.end(), 0.0);
    for (std::size_t k = 0; k < own_.size(); ++k) values_.at(places_[k]) = own_[k];
  }
  const double* values() override { return values_.data(); }
  void* stream() const override { return nullptr; }
  void read(double* values) override { std::copy(values_.begin(), values_.end(), values); }

  std::vector<double> values_;

 private:
  std::vector<int> places_;
  std::vector<double> own_;
};

/// The same system with the derivatives of some rows of F elsewhere.
template <class Inner>
class Divided : public DenseSystem<Inner> {
 public:
  Divided(int first, int end) : away_(std::make_unique<Away>(*this, first, end)) {
    const int n = this->coordinates();
    for (const Block block : {Block::force_q, Block::force_v, Block::force_a}) {
      Pattern& here = this->pattern_.block[static_cast<std::size_t>(block)];
      here = {n, n, {0}, {}};
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n && (i < first || i >= end); ++j) here.column.push_back(j);
        here.row_start.push_back(static_cast<int>(here.column.size()));
      }
    }
  }
  std::vector<RemoteTangent*> remote_tangents() const override { return {away_.get()}; }
  using DenseSystem<Inner>::evaluate;
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override {
    const DenseSystem<Inner> whole;
    Tangent all = make_tangent(whole);
    whole.evaluate(state, all, blocks);
    for (int b = 0; b < kBlocks; ++b) {
      const Pattern& from = whole.tangent_pattern().block[b];
      const Pattern& to = this->pattern_.block[b];
      if (!blocks.has(static_cast<Block>(b))) continue;
      for (int i = 0; i < to.rows; ++i)
        for (int k = 0; k < to.row_start[i + 1] - to.row_start[i]; ++k)
          tangent.values[b][to.row_start[i] + k] = all.values[b][from.row_start[i] + k];
    }
  }

 private:
  class Away : public RemoteTangent {
   public:
    Away(const ConstrainedSystem& system, int first, int end) : first_(first) {
      const int n = system.coordinates();
      pattern_ = {n, n, {0}, {}};
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n && i >= first && i < end; ++j) pattern_.column.push_back(j);
        pattern_.row_start.push_back(static_cast<int>(pattern_.column.size()));
      }
    }
    const Pattern& pattern() const override { return pattern_; }
    std::unique_ptr<RemoteMatrix> make_matrix(std::size_t entries, const std::vector<int>& own) override {
      return std::make_unique<AwayMatrix>(entries, own);
    }
    void place(const std::array<const int*, 3>& target, RemoteMatrix& matrix) override {
      for (int b = 0; b < 3; ++b) target_[b].assign(target[b], target[b] + pattern_.entries());
      matrix_ = &dynamic_cast<AwayMatrix&>(matrix);
    }
    void begin_tangent(const StateView& state) override {
      const DenseSystem<Inner> whole;
      all_ = make_tangent(whole);
      whole.evaluate(state, all_, BlockSet::all());
    }
    void begin_tangent(const Executor&, const StateView& state) override { begin_tangent(state); }
    void add_diagonals(const ByAVQ& factor, DiagonalsByAVQ& diagonals) override {
      for (int i = 0; i < pattern_.rows; ++i)
        if (pattern_.row_start[i + 1] > pattern_.row_start[i])
          for (int b = 0; b < 3; ++b) diagonals[b][i] += factor[b] * value(b, i, i);
    }
    void begin_sum(const ByAVQ& factor) override {
      for (std::size_t k = 0; k < pattern_.entries(); ++k)
        for (int b = 0; b < 3; ++b)
          matrix_->values_.at(target_[b][k]) +=
              factor[b] * value(b, first_ + static_cast<int>(k) / pattern_.columns, pattern_.column[k]);
    }

   private:
    double value(int b, int row, int column) const {
      constexpr Block kBlock[] = {Block::force_a, Block::force_v, Block::force_q};
      return all_[kBlock[b]][row * pattern_.columns + column];
    }
    int first_;
    Pattern pattern_;
    std::vector<int> target_[3];
    AwayMatrix* matrix_ = nullptr;
    Tangent all_;
  };
  std::unique_ptr<Away> away_;
};

TEST(Jacobian, IsTheSameWhereSomeRowsAreSummedElsewhere) {
  const DenseSystem<Tied> whole;
  const State given{0.0, {0.1, 0.3, 0.3}, {1.0, 2.0, 2.0}, {-5.0, 3.0, 3.0}, {7.0}};
  StepState state;
  assign(host(), given, state);
  for (const Unknowns unknowns : {Unknowns::full, Unknowns::reduced})
    for (const auto& [first, end] : {std::pair{0, 2}, {1, 3}, {0, 3}}) {
      const Divided<Tied> divided(first, end);
      const StepEquations equations(divided, unknowns, last_is_tied(), host()),
          expected(whole, unknowns, last_is_tied(), host());
      for (const double rate : {2.0, 1e3, 1e6}) {
        const StepRelation relation = relation_at(rate, given.q, given.v, given.a);
        const Eigen::MatrixXd difference =
            jacobian(equations, state, relation) - jacobian(expected, state, relation);
        EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-14) << rate;
      }
    }
}

}  // namespace
}  // namespace mfs::dae::test
