// Springs, bushings and loads against plain formulas, energy and the balance of momentum.
#include "dae/mechanics/forces.hpp"
#include "dae/mechanics/loads.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "test/dae/mechanics/two_bodies.hpp"

namespace mfs::dae {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Random;
using test::State;

/// Force and moment about the frame's origin, in ground axes, of a share of F: f_p = 2 G^T A^T n.
struct Wrench {
  Vector3d force, moment;
};

Eigen::Quaterniond quaternion(const double* p) {
  return Eigen::Quaterniond(p[0], p[1], p[2], p[3]);
}

/// Two massless frames, as what is connected by `connect` sees them.
struct Pair {
  MultibodyBuilder builder;
  Attachment a, b;
  std::unique_ptr<ConstrainedSystem> system;
  State state;

  template <class Connect>
  Pair(Random& random, Connect connect) {
    a = test::random_attachment(random, add_frame(builder, "first", test::random_placement(random)));
    b = test::random_attachment(random, add_frame(builder, "second", test::random_placement(random)));
    connect(builder, a, b);
    system = builder.build(1);
    state = {0.0, builder.initial_q(), builder.initial_v(), std::vector<double>(14), std::vector<double>(2)};
  }
  /// What `frame` is pushed by: -F.
  Wrench wrench(const Frame& frame) const {
    Residual residual = make_residual(*system);
    system->evaluate(state.view(), residual);
    const double* f = residual.force.data() + frame.first;
    const Eigen::Quaterniond p = quaternion(state.q.data() + frame.first + 3);
    // n = A n', n' = G f_p / 2 and (0, G x) = vector part of conj(p) x.
    return {-Eigen::Map<const Vector3d>(f), -0.5 * (p * ((p.conjugate() * quaternion(f + 3)).vec()))};
  }
  Vector3d origin(const Attachment& side) const {
    return Eigen::Map<const Vector3d>(state.q.data() + side.frame.first);
  }
  Matrix3d axes(const Attachment& side) const {
    return quaternion(state.q.data() + side.frame.first + 3).toRotationMatrix() * side.axes;
  }
  Vector3d point(const Attachment& side) const {
    return origin(side) + quaternion(state.q.data() + side.frame.first + 3) * side.point;
  }
  Vector3d velocity(const Attachment& side) const {
    const Placement placement = initial_placement(builder, side.frame);
    return placement.velocity + placement.angular_velocity.cross(point(side) - placement.position);
  }
  void expect_balance() const {
    const Wrench on_a = wrench(a.frame), on_b = wrench(b.frame);
    EXPECT_LT((on_a.force + on_b.force).norm(), 1e-12);
    EXPECT_LT((on_a.moment + origin(a).cross(on_a.force) + on_b.moment + origin(b).cross(on_b.force)).norm(),
              1e-12);
  }
};

TEST(Forces, SpringPullsAlongItsLine) {
  const Function table = spline_function({-3, 0, 1, 4}, {-5, 0, 2, 7});
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const bool by_table = seed % 2 == 0;
    const Pair pair(random, [&](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
      add_spring_damper(builder, {"coil", a, b, by_table ? 0.0 : 7.0, 0.5, 0.8, by_table ? table : nullptr});
    });
    const Vector3d d = pair.point(pair.b) - pair.point(pair.a);
    const Vector3d u = d.normalized();
    const double elongation = d.norm() - 0.8, rate = u.dot(pair.velocity(pair.b) - pair.velocity(pair.a));
    const double pull = (by_table ? table->at(elongation).value : 7.0 * elongation) + 0.5 * rate;
    const Wrench on_b = pair.wrench(pair.b.frame);
    EXPECT_LT((on_b.force + pull * u).norm(), 1e-12);
    EXPECT_LT((on_b.moment - (pair.point(pair.b) - pair.origin(pair.b)).cross(on_b.force)).norm(), 1e-12);
    pair.expect_balance();
  }
}

const std::array<double, 6> kStiffness{30, 20, 10, 4, 5, 6};

TEST(Forces, BushingIsTheGradientOfItsEnergy) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    Pair pair(random, [&](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
      add_bushing(builder, {"rubber", a, b, kStiffness, {}});
    });
    const auto energy = [&] {  // on unit quaternions
      const Vector3d shift = pair.axes(pair.a).transpose() * (pair.point(pair.b) - pair.point(pair.a));
      const Eigen::AngleAxisd turn(Matrix3d(pair.axes(pair.a).transpose() * pair.axes(pair.b)));
      const Vector3d angles = 4 * std::tan(turn.angle() / 4) * turn.axis();
      double sum = 0.0;
      for (int k = 0; k < 3; ++k)
        sum += 0.5 * (kStiffness[k] * shift[k] * shift[k] + kStiffness[3 + k] * angles[k] * angles[k]);
      return sum;
    };
    const Wrench on_b = pair.wrench(pair.b.frame);
    const State before = pair.state;
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 3; ++k) {
      double shifted[2], turned[2];
      for (const int side : {0, 1}) {
        const double step = side == 0 ? -kStep : kStep;
        pair.state = before;
        pair.state.q[7 + k] += step;
        shifted[side] = energy();
        pair.state = before;
        const Eigen::Quaterniond p =
            Eigen::Quaterniond(Eigen::AngleAxisd(step, Vector3d::Unit(k))) * quaternion(before.q.data() + 10);
        const double parameters[] = {p.w(), p.x(), p.y(), p.z()};
        std::copy_n(parameters, 4, pair.state.q.begin() + 10);
        turned[side] = energy();
      }
      EXPECT_NEAR(on_b.force[k], -(shifted[1] - shifted[0]) / (2 * kStep), 1e-6) << k;
      EXPECT_NEAR(on_b.moment[k], -(turned[1] - turned[0]) / (2 * kStep), 1e-6) << k;
    }
    pair.state = before;
    pair.expect_balance();
  }
}

TEST(Forces, BushingDampsRelativeVelocities) {
  Random random(9);
  MultibodyBuilder builder;
  Placement moving;
  moving.velocity = {1, 2, 3};
  moving.angular_velocity = {4, 5, 6};
  const Frame body = add_frame(builder, "body", moving);
  const Attachment ground, on_body{body};
  add_bushing(builder, {"rubber", ground, on_body, {}, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6}});
  const auto system = builder.build(1);
  Residual residual = make_residual(*system);
  const std::vector<double> zero(7);
  system->evaluate({0.0, builder.initial_q().data(), builder.initial_v().data(), zero.data(), zero.data()},
                   residual);
  // At p = (1, 0, 0, 0): f_p = 2 (0, n).
  const double expected[] = {0.1, 0.4, 0.9, 0.0, 2 * 1.6, 2 * 2.5, 2 * 3.6};
  for (int k = 0; k < 7; ++k) EXPECT_NEAR(residual.force[k], expected[k], 1e-14) << k;
}

TEST(Forces, LoadsActWhereTheyAre) {
  Random random(11);
  const Function x = linear_function(2, 3), z = harmonic_function(1, 2, 0.5, 0);
  Pair pair(random, [&](MultibodyBuilder& builder, const Attachment&, const Attachment& b) {
    add_point_force(builder, "load", b, {x, nullptr, z});
  });
  pair.state.t = 0.4;
  const Vector3d load(2 + 3 * 0.4, 0, 1 + 2 * std::sin(std::acos(-1.0) * 0.4));
  const Wrench wrench = pair.wrench(pair.b.frame);
  EXPECT_LT((wrench.force - load).norm(), 1e-14);
  EXPECT_LT((wrench.moment - (pair.point(pair.b) - pair.origin(pair.b)).cross(load)).norm(), 1e-13);
  EXPECT_EQ(pair.wrench(pair.a.frame).force.norm(), 0.0);
}

TEST(Forces, FollowersTurnWithTheirFrame) {
  Random random(12);
  const Vector3d load(2, 0, -3);
  Pair pair(random, [&](MultibodyBuilder& builder, const Attachment&, const Attachment& b) {
    add_point_force(builder, "thrust", b, {constant_function(2), nullptr, constant_function(-3)},
                    LoadAxes::attachment);
  });
  const Wrench wrench = pair.wrench(pair.b.frame);
  const Vector3d turned = pair.axes(pair.b) * load;
  EXPECT_LT((wrench.force - turned).norm(), 1e-14);
  EXPECT_LT((wrench.moment - (pair.point(pair.b) - pair.origin(pair.b)).cross(turned)).norm(), 1e-13);
}

TEST(Forces, TorquesTurnOnly) {
  const Vector3d load(2, 0, -3);
  for (const LoadAxes axes : {LoadAxes::ground, LoadAxes::attachment}) {
    Random random(13);
    Pair pair(random, [&](MultibodyBuilder& builder, const Attachment&, const Attachment& b) {
      add_torque(builder, "motor", b, {constant_function(2), nullptr, constant_function(-3)}, axes);
    });
    const Wrench wrench = pair.wrench(pair.b.frame);
    const Vector3d turned = axes == LoadAxes::ground ? load : Vector3d(pair.axes(pair.b) * load);
    EXPECT_EQ(wrench.force.norm(), 0.0);
    EXPECT_LT((wrench.moment - turned).norm(), 1e-13);
  }
}

TEST(Forces, NodalForcesAreSplit) {
  MultibodyBuilder builder;
  builder.add_coordinates("other", {0}, {0});
  const CoordinateRange body = builder.add_coordinates("arm", std::vector<double>(9), std::vector<double>(9));
  add_nodal_force(builder, "load", body, {2, 0}, {0.25, 0.75}, {nullptr, linear_function(4, 8), nullptr});
  const auto system = builder.build(1);
  Residual residual = make_residual(*system);
  const std::vector<double> zero(10);
  system->evaluate({0.5, zero.data(), zero.data(), zero.data(), nullptr}, residual);
  EXPECT_EQ(residual.force, (std::vector<double>{0, 0, -6, 0, 0, 0, 0, 0, -2, 0}));
}

}  // namespace
}  // namespace mfs::dae
