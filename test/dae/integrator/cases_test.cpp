// Where the integrator has to choose, to repair, to reject or to refuse.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <mfs/error.hpp>

#include "dae/integrator/integrator.hpp"
#include "dae/integrator/partition.hpp"
#include "dae/integrator/projection.hpp"
#include "test/dae/integrator/chain.hpp"
#include "test/dae/integrator/driven_circle.hpp"
#include "test/dae/integrator/pendulum.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae::test {
namespace {

using testing::HasSubstr;
using testing::Property;
using testing::Throws;

/// That a run for one second from q0 and v0 ends with an Error whose text matches.
template <class Error, class Matcher>
void expect_refused(Integrator& integrator, const std::vector<double>& q0, const std::vector<double>& v0,
                    const Matcher& text) {
  Observer nobody;
  EXPECT_THAT([&] { integrator.run(0.0, q0, v0, 1.0, {}, nobody); },
              Throws<Error>(Property(&Error::what, text)));
}

IntegratorOptions tolerance(double value) {
  IntegratorOptions options;
  options.rtol = options.atol_position = options.atol_velocity = value;
  options.threads = 1;
  return options;
}

double largest_difference(const std::vector<double>& x, const std::vector<double>& y) {
  double most = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(x[i] - y[i]));
  return most;
}

State run_chain(const DenseSystem<Chain>& system, const IntegratorOptions& options,
                IntegrationReport& report) {
  const Chain chain;
  Integrator integrator(system, options);
  Observer nobody;
  State end = integrator.run(0.0, chain.start(), std::vector<double>(2 * chain.links, 0.0), 0.2, {}, nobody);
  report = integrator.report();
  return end;
}

TEST(Integrator, TrajectoryDoesNotDependOnHowItIsComputed) {
  const DenseSystem<Chain> system;
  IntegrationReport report, other;
  const IntegratorOptions options = tolerance(1e-7);
  const State reduced = run_chain(system, options, report);
  EXPECT_LE(report.violation[0], options.constraint_position);
  EXPECT_LE(report.violation[1], options.constraint_velocity);
  EXPECT_LE(report.violation[2], options.constraint_acceleration);
  EXPECT_LT(report.jacobians, report.newton_iterations);
  EXPECT_EQ(report.analyses, 1);

  IntegratorOptions full = options;
  full.unknowns = Unknowns::full;
  EXPECT_LT(largest_difference(run_chain(system, full, other).q, reduced.q), 2e-5);
  EXPECT_GE(other.unknowns, report.unknowns);

  IntegratorOptions fresh = options;
  fresh.keep_factors = false;
  EXPECT_LT(largest_difference(run_chain(system, fresh, other).q, reduced.q), 2e-5);
  EXPECT_EQ(other.factorizations, 2 + other.newton_iterations);  // two before the first step

  IntegratorOptions serial = options;
  serial.backend = Backend::serial;
  EXPECT_LT(largest_difference(run_chain(system, serial, other).q, reduced.q), 2e-5);
}

TEST(Integrator, ResultsAreTheSameBitForBit) {
  const DenseSystem<Chain> system;
  IntegrationReport report;
  IntegratorOptions options = tolerance(1e-4);
  options.threads = 2;
  EXPECT_EQ(run_chain(system, options, report).q, run_chain(system, options, report).q);
}

TEST(Integrator, GoesRoundAndRoundWithOneAnalysis) {
  const DrivenCircle motion{0.0, 4.0};
  const DenseSystem<DrivenCircle> system(motion);
  Integrator integrator(system, tolerance(1e-7));
  Recorder recorder;
  const double t_end = M_PI;  // two revolutions
  const State end = integrator.run(0.0, motion.position(0.0), motion.velocity(0.0), t_end, {}, recorder);
  EXPECT_LT(largest_difference(end.q, motion.position(t_end)), 1e-4);
  EXPECT_EQ(integrator.report().analyses, 1);
  EXPECT_EQ(integrator.report().error_rejections, 0);
}

TEST(Integrator, MeetsOutputsExactly) {
  const DrivenCircle motion;
  const DenseSystem<DrivenCircle> system(motion);
  Integrator integrator(system, tolerance(1e-6));
  Recorder recorder;
  const std::vector<double> outputs = {0.0, 0.1, 0.2, 0.200001, 0.9};
  const State end = integrator.run(0.0, motion.position(0.0), motion.velocity(0.0), 1.0, outputs, recorder);
  ASSERT_EQ(recorder.outputs.size(), outputs.size());
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    const State& s = recorder.outputs[k];
    EXPECT_EQ(s.t, outputs[k]);
    EXPECT_LT(largest_difference(s.q, motion.position(s.t)), 1e-4);
    EXPECT_LT(largest_difference(s.v, motion.velocity(s.t)), 1e-4);
    EXPECT_LT(largest_difference(s.a, motion.acceleration(s.t)), 1e-2);
    EXPECT_NEAR(s.lambda[0], motion.multiplier(s.t), 1e-2);
  }
  EXPECT_EQ(end.t, 1.0);
  EXPECT_EQ(static_cast<std::int64_t>(recorder.steps.size()), integrator.report().steps);
}

TEST(InitialConditions, AreProjected) {
  const DenseSystem<Pendulum> system;
  Integrator integrator(system, tolerance(1e-6));
  Recorder recorder;
  // Off the circle, and with a velocity away from it.
  integrator.run(0.0, {1.2, 0.0}, {3.0, 0.5}, 0.01, {0.0}, recorder);
  const State& s = recorder.outputs.at(0);
  EXPECT_NEAR(s.q[0], 1.0, 1e-8);
  EXPECT_NEAR(s.q[1], 0.0, 1e-8);
  EXPECT_NEAR(s.v[0], 0.0, 1e-8);
  EXPECT_NEAR(s.v[1], 0.5, 1e-8);
  EXPECT_NEAR(s.a[0], -0.25, 1e-8);  // v^2 / r
  EXPECT_NEAR(s.a[1], -Pendulum::kGravity, 1e-8);
  EXPECT_NEAR(s.lambda[0], 0.25, 1e-8);
}

/// Nothing resists the second of its accelerations.
struct Massless {
  int coordinates() const { return 2; }
  int constraints() const { return 0; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& /*v*/,
                       const std::vector<T>& a) const {
    return {a[0], T(q[1] - 0.5)};
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& /*q*/) const {
    return {};
  }
};

TEST(InitialConditions, WithoutAccelerationsAreRefused) {
  const DenseSystem<Massless> system;
  Integrator integrator(system);
  expect_refused<SingularMatrix>(integrator, {0.0, 0.0}, {0.0, 0.0}, HasSubstr("initial conditions: q[1]"));
}

/// No circle has such a radius.
struct Unreachable : Pendulum {
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {T(q[0] * q[0] + q[1] * q[1] - (-1.0))};
  }
};

TEST(InitialConditions, OutOfReachAreRefused) {
  const DenseSystem<Unreachable> system;
  Integrator integrator(system);
  expect_refused<InvalidInput>(integrator, {1.0, 0.3}, {0.0, 0.0}, HasSubstr("constraint 0"));
}

/// The pendulum with its constraint said twice, the second time `factor` times as large and, of time, `drift`
/// off.
struct SaidTwice : Pendulum {
  double drift = 0.0;
  int constraints() const { return 2; }
  template <class T>
  std::vector<T> constraint(const T& t, const std::vector<T>& q) const {
    const T phi = T(0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0));
    return {phi, T(3.0 * phi + drift * (t * t * t))};
  }
};

TEST(RedundantConstraints, AreLeftOutWithANote) {
  const DenseSystem<SaidTwice> system;
  const DenseSystem<Pendulum> once;
  Integrator twice(system, tolerance(1e-6)), reference(once, tolerance(1e-6));
  Observer nobody;
  const State end = twice.run(0.0, pendulum_at(1.0), {0.0, 0.0}, 1.0, {}, nobody);
  const State expected = reference.run(0.0, pendulum_at(1.0), {0.0, 0.0}, 1.0, {}, nobody);
  EXPECT_EQ(twice.report().redundant.size(), 1u);
  EXPECT_EQ(twice.report().constraints, 1);
  EXPECT_LT(largest_difference(end.q, expected.q), 1e-5);
  ASSERT_EQ(end.lambda.size(), 2u);
  // Together they pull as the one does.
  EXPECT_NEAR(end.lambda[0] + 3.0 * end.lambda[1], expected.lambda[0], 1e-3);
}

TEST(RedundantConstraints, ThatContradictAreRefused) {
  SaidTwice drifting;
  drifting.drift = 1.0;
  const DenseSystem<SaidTwice> system(drifting);
  Integrator integrator(system);
  expect_refused<InvalidInput>(integrator, pendulum_at(1.0), {0.0, 0.0}, HasSubstr("contradicts"));
}

/// Its derivatives cannot be had, or are no numbers, between two times.
class Interrupted : public DenseSystem<Pendulum> {
 public:
  enum class Fault { throws, nan, singular };
  Interrupted(Fault fault, int times) : fault_(fault), left_(times) {}
  using DenseSystem<Pendulum>::evaluate;
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override {
    DenseSystem<Pendulum>::evaluate(state, tangent, blocks);
    if (state.t < 0.1 || left_ == 0) return;
    --left_;
    if (fault_ == Fault::throws) throw std::runtime_error("a flat tyre");
    const double value = fault_ == Fault::nan ? std::numeric_limits<double>::quiet_NaN() : 0.0;
    for (const Block block : {Block::force_a, Block::position_q})
      if (blocks.has(block))
        for (double& entry : tangent[block]) entry = value;
  }

 private:
  Fault fault_;
  mutable int left_;
};

TEST(Rejection, AFailingSolverCostsAShorterStep) {
  for (const auto fault :
       {Interrupted::Fault::throws, Interrupted::Fault::nan, Interrupted::Fault::singular}) {
    const Interrupted system(fault, 3);
    IntegratorOptions options = tolerance(1e-6);
    options.keep_factors = false;
    Integrator integrator(system, options);
    Recorder recorder;
    const State end = integrator.run(0.0, pendulum_at(1.0), {0.0, 0.0}, pendulum_period(1.0), {}, recorder);
    EXPECT_GE(integrator.report().solver_rejections, 1);
    EXPECT_NEAR(end.q[0], std::sin(1.0), 1e-3);
  }
}

TEST(Rejection, AFixedStepComesBack) {
  const Interrupted system(Interrupted::Fault::throws, 3);
  IntegratorOptions options = tolerance(1e-6);
  options.method = Method::generalized_alpha;
  options.fixed_step = 0.01;
  options.keep_factors = false;
  Integrator integrator(system, options);
  Recorder recorder;
  integrator.run(0.0, pendulum_at(1.0), {0.0, 0.0}, 1.0, {}, recorder);
  EXPECT_GE(integrator.report().solver_rejections, 1);
  EXPECT_NEAR(recorder.steps.back().h, options.fixed_step, 1e-3);
  EXPECT_LT(recorder.steps.size(), 105U);
}

TEST(Rejection, OneThatNeverEndsIsReported) {
  const Interrupted system(Interrupted::Fault::throws, -1);
  IntegratorOptions options = tolerance(1e-6);
  options.keep_factors = false;
  Integrator integrator(system, options);
  expect_refused<Error>(integrator, pendulum_at(1.0), {0.0, 0.0},
                        testing::AllOf(HasSubstr("too small"), HasSubstr("t = 0.1"), HasSubstr("order"),
                                       HasSubstr("a flat tyre")));
}

TEST(Rejection, ErrorOfAnObserverEndsTheRun) {
  struct Stubborn : Observer {
    void step(const StepReport&, const std::function<const State&()>&) override {
      throw std::logic_error("enough");
    }
  } observer;
  const DenseSystem<Pendulum> system;
  Integrator integrator(system);
  EXPECT_THROW(integrator.run(0.0, pendulum_at(1.0), {0.0, 0.0}, 1.0, {}, observer), std::logic_error);
}

TEST(Refusals, NameTheArgument) {
  const DenseSystem<Pendulum> system;
  const auto refused = [&](const char* argument, const IntegratorOptions& options, std::vector<double> q0,
                           double t_end, const std::vector<double>& outputs) {
    Observer nobody;
    try {
      Integrator(system, options).run(0.0, std::move(q0), {0.0, 0.0}, t_end, outputs, nobody);
      ADD_FAILURE() << argument << " was accepted";
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.argument(), argument);
    }
  };
  const auto with = [](auto member, auto value) {
    IntegratorOptions options;
    options.*member = value;
    return options;
  };
  using O = IntegratorOptions;
  const std::vector<double> q0 = pendulum_at(1.0);
  refused("rtol", with(&O::rtol, -1.0), q0, 1.0, {});
  refused("rtol", with(&O::rtol, 1.5), q0, 1.0, {});
  refused("atol_position", with(&O::atol_position, -1.0), q0, 1.0, {});
  refused("rtol", with(&O::rtol, 0.0), q0, 1.0, {});
  refused("max_order", with(&O::max_order, 6), q0, 1.0, {});
  refused("rho_inf", with(&O::rho_inf, 1.5), q0, 1.0, {});
  refused("max_step", with(&O::max_step, std::nan("")), q0, 1.0, {});
  refused("rtol", with(&O::rtol, 1e-13), q0, 1.0, {});
  refused("max_step", with(&O::max_step, 1e-12), q0, 1.0, {});
  refused("fixed_step", with(&O::fixed_step, 1e-12), q0, 1.0, {});
  IntegratorOptions crossed;
  crossed.min_step = 2.0 * (crossed.max_step = 0.1);
  refused("min_step", crossed, q0, 1.0, {});
  refused("q0", {}, {1.0}, 1.0, {});
  refused("q0", {}, {std::nan(""), 0.0}, 1.0, {});
  refused("t_end", {}, q0, 0.0, {});
  refused("outputs", {}, q0, 1.0, {0.5, 0.5});
  refused("outputs", {}, q0, 1.0, {1.5});
}

TEST(Partition, PicksLargeEntries) {
  // x + 1e-3 y = ..., z + x = ...
  const Pattern two{2, 3, {0, 2, 4}, {0, 1, 0, 2}};
  const Partition partition(two, {1.0, 1e-3, 1.0, 1.0}, {1.0, 1.0, 1.0}, 1);
  EXPECT_THAT(partition.independent(), testing::ElementsAre(0, 1, 0));
  // In other units y is the strong one.
  const Partition scaled(two, {1.0, 1e-3, 1.0, 1.0}, {1.0, 1e6, 1.0}, 1);
  EXPECT_EQ(scaled.independent()[1], 0);
}

TEST(Partition, DegradesWithTheCoordinatesNotWithThePivotsOfEarlierValues) {
  const Pattern pattern{2, 3, {0, 3, 6}, {0, 1, 2, 0, 1, 2}};
  const std::vector<double> first = {1.0, 0.5, 0.1, 0.5, 1.0, 0.1};
  Partition partition(pattern, first, {1.0, 1.0, 1.0}, 2);
  ASSERT_THAT(partition.independent(), testing::ElementsAre(0, 0, 1));
  EXPECT_FALSE(partition.degraded({0.0, 1.0, 0.1, 1.0, 0.0, 0.1}));  // zero where the pivots were
  EXPECT_TRUE(partition.degraded({1.0, 1.0, 0.1, 1.0, 1.0, 0.2}));   // they do not fix x and y
  EXPECT_FALSE(partition.degraded(first));
}

/// Two points that are tied to a third by a linear constraint each, which stays on a circle.
struct TiedToACircle {
  int coordinates() const { return 4; }
  int constraints() const { return 3; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& /*q*/, const std::vector<T>& /*v*/,
                       const std::vector<T>& a) const {
    return a;
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {T(q[2] - q[0]), T(q[0] * q[0] + q[1] * q[1] - 1.0), T(q[3] - q[0] - 2.0 * q[1])};
  }
};

TEST(Projection, TiesWhatOneConstraintAloneMovesWithAnEntryThatLasts) {
  const DenseSystem<TiedToACircle> system;
  const Projection projection = find_projection(system, 0.0, {1.0, 0.0, 1.0, 1.0}, 1.0);
  EXPECT_THAT(projection.role, testing::ElementsAre(Role::shared, Role::shared, Role::tied, Role::tied));
  EXPECT_THAT(projection.rows, testing::ElementsAre(1));
  EXPECT_THAT(projection.directions.row_start, testing::ElementsAre(0, 1, 2, 2, 2));
  EXPECT_THAT(projection.source, testing::ElementsAre(4, 5));  // of a dense Phi_q
}

}  // namespace
}  // namespace mfs::dae::test
