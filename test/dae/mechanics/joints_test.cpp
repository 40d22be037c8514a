// Each joint leaves its freedoms and no other, without a redundant equation; drives prescribe what they say.
#include "dae/mechanics/joints.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "dae/mechanics/motions.hpp"
#include "dae/mechanics/rigid_interface.hpp"
#include "test/dae/mechanics/dense.hpp"
#include "test/dae/mechanics/two_bodies.hpp"

namespace mfs::dae {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Random;
using test::State;

/// Where b's attachment is, seen from a's: moved by `shift`, turned by `turn`, both in a's axes.
struct Relative {
  Vector3d shift = Vector3d::Zero();
  Matrix3d turn = Matrix3d::Identity();
};

Matrix3d about(int axis, double angle) {
  return AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix();
}

/// Two bodies, attachments on them, and what connects these.
struct Pair {
  MultibodyBuilder builder;
  Attachment a, b;
  std::unique_ptr<ConstrainedSystem> system;

  template <class Connect>
  Pair(Random& random, Connect connect) {
    a = test::random_attachment(
        random, add_rigid_body(builder, test::random_body(random, "first"), Vector3d::Zero()));
    b = test::random_attachment(
        random, add_rigid_body(builder, test::random_body(random, "second"), Vector3d::Zero()));
    connect(builder, a, b);
    system = builder.build(1);
  }

  State state(const Relative& relative, double t = 0.0) const {
    const Placement first = initial_placement(builder, a.frame);
    const Matrix3d axes = first.rotation * a.axes;
    const Matrix3d rotation = axes * relative.turn * b.axes.transpose();
    const Vector3d origin =
        first.position + first.rotation * a.point + axes * relative.shift - rotation * b.point;
    const Eigen::Quaterniond p(rotation);
    State state{t, builder.initial_q(), builder.initial_v(), builder.initial_v(), {}};
    const double second[] = {origin[0], origin[1], origin[2], p.w(), p.x(), p.y(), p.z()};
    std::copy_n(second, 7, state.q.begin() + b.frame.first);
    state.lambda.assign(system->constraints(), 0.0);
    return state;
  }
  double violation(const State& state) const {
    Residual residual = make_residual(*system);
    system->evaluate(state.view(), residual);
    double largest = 0.0;
    for (const double x : residual.position) largest = std::max(largest, std::abs(x));
    return largest;
  }
};

double smallest_singular_value(const ConstrainedSystem& system, const State& state) {
  Tangent tangent = make_tangent(system);
  system.evaluate(state.view(), tangent, BlockSet::all());
  const auto matrix = test::dense(system.tangent_pattern()[Block::position_q], tangent[Block::position_q]);
  return matrix.jacobiSvd().singularValues()[matrix.rows() - 1];
}

struct Freedom {
  const char* name;
  JointKind kind;
  int equations;
  bool shift[3], turn[3];  // what is free, in a's axes
};

const Freedom kFreedoms[] = {
    {"fixed", JointKind::fixed, 6, {false, false, false}, {false, false, false}},
    {"revolute", JointKind::revolute, 5, {false, false, false}, {false, false, true}},
    {"spherical", JointKind::spherical, 3, {false, false, false}, {true, true, true}},
    {"universal", JointKind::universal, 4, {false, false, false}, {false, false, true}},
    {"translational", JointKind::translational, 5, {false, false, true}, {false, false, false}},
    {"cylindrical", JointKind::cylindrical, 4, {false, false, true}, {false, false, true}},
};

/// Where the joint may be.
Relative random_allowed(Random& random, const Freedom& freedom) {
  Relative relative;
  for (int k = 0; k < 3; ++k) {
    if (freedom.shift[k]) relative.shift[k] = random.entry();
    if (freedom.turn[k]) relative.turn = relative.turn * about(k, 2 * random.entry());
  }
  // A universal joint's second axis: b's z is at first along -y of a, then as far from a's x as from its y.
  if (freedom.kind == JointKind::universal)
    relative.turn = about(2, 0.8) * about(0, std::acos(0.0)) * about(2, random.entry());
  return relative;
}

TEST(Joints, LeaveTheirFreedomsAndNoOther) {
  for (const Freedom& freedom : kFreedoms)
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(std::string(freedom.name) + ", seed " + std::to_string(seed));
      Random random(seed);
      const Pair pair(random, [&](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
        add_joint(builder, {"pin", freedom.kind, a, b});
      });
      ASSERT_EQ(pair.system->constraints(), freedom.equations + 2);  // and two of Euler parameters
      const Relative relative = random_allowed(random, freedom);
      EXPECT_LT(pair.violation(pair.state(relative)), 1e-13);
      EXPECT_GT(smallest_singular_value(*pair.system, pair.state(relative)), 1e-2);
      for (int k = 0; k < 3; ++k) {
        Relative shifted = relative, turned = relative;
        shifted.shift[k] += 0.1;
        turned.turn = about(k, 0.1) * relative.turn;
        const double by_shift = pair.violation(pair.state(shifted)),
                     by_turn = pair.violation(pair.state(turned));
        for (const auto& [free, by] : {std::pair(freedom.shift[k], by_shift), {freedom.turn[k], by_turn}}) {
          if (free) {
            EXPECT_LT(by, 1e-13) << k;
          } else {
            EXPECT_GT(by, 1e-2) << k;
          }
        }
      }
    }
}

TEST(Joints, ADriveTakesTheFreedom) {
  const Function angle = linear_function(0.4, 9.0), distance = linear_function(-0.3, 2.0);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    const Pair pair(random, [&](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
      add_joint(builder, {"pin", JointKind::cylindrical, a, b});
      add_rotation(builder, "turn", a, b, angle);
      add_translation(builder, "push", a, b, distance);
    });
    for (const double t : {0.0, 0.3, 0.55}) {
      Relative relative;
      relative.turn = about(2, angle->at(t).value);
      relative.shift[2] = distance->at(t).value;
      EXPECT_LT(pair.violation(pair.state(relative, t)), 1e-13);
      EXPECT_GT(smallest_singular_value(*pair.system, pair.state(relative, t)), 1e-2);
      EXPECT_GT(pair.violation(pair.state(relative, t + 0.01)), 1e-2);
      relative.shift[2] = 0.0;
      EXPECT_NEAR(pair.violation(pair.state(relative, t)), std::abs(distance->at(t).value), 1e-13);
    }
  }
}

TEST(Joints, APointIsMovedAlongGroundAxes) {
  Random random(4);
  const Function x = linear_function(1.0, 2.0), z = constant_function(-3.0);
  const Pair pair(random, [&](MultibodyBuilder& builder, const Attachment&, const Attachment& b) {
    add_point_motion(builder, "path", b, {x, nullptr, z});
  });
  ASSERT_EQ(pair.system->constraints(), 2 + 2);
  State state = pair.state({});
  state.t = 0.25;
  const Placement body = [&] {
    MultibodyBuilder placed;
    placed.add_coordinates("second", std::vector<double>(state.q.begin() + 7, state.q.end()),
                           std::vector<double>(7));
    return initial_placement(placed, {"second", 0});
  }();
  const Vector3d now = body.position + body.rotation * pair.b.point;
  state.q[7] += 1.5 - now[0];
  state.q[8] += 17;
  state.q[9] += -3.0 - now[2];
  EXPECT_LT(pair.violation(state), 1e-13);
  state.q[9] += 0.125;
  EXPECT_NEAR(pair.violation(state), 0.125, 1e-13);
}

TEST(Joints, ARigidInterfaceKeepsThePlacesOfItsNodes) {
  Random random(7);
  MultibodyBuilder builder;
  const std::vector<double> nodes = random.vector(12);
  const Vector3d origin(0.3, 0.1, -0.2), velocity(1, 2, 3), spin(0.5, -0.4, 0.8);
  std::vector<double> rates;
  for (int i = 0; i < 4; ++i) {
    const Vector3d v = velocity + spin.cross(Eigen::Map<const Vector3d>(nodes.data() + 3 * i) - origin);
    rates.insert(rates.end(), v.data(), v.data() + 3);
  }
  const CoordinateRange body = builder.add_coordinates("arm", nodes, rates);
  const Frame frame = add_rigid_interface(builder, "eye", body, {0, 1, 2, 3}, origin);
  const auto system = builder.build(1);
  ASSERT_EQ(system->constraints(), 13);

  State state{0.0, builder.initial_q(), builder.initial_v(), std::vector<double>(19),
              std::vector<double>(13)};
  Residual residual = make_residual(*system);
  system->evaluate(state.view(), residual);
  for (int i = 0; i < 13; ++i) {
    EXPECT_NEAR(residual.position[i], 0.0, 1e-14);
    EXPECT_NEAR(residual.velocity[i], 0.0, 1e-13);
  }
  EXPECT_TRUE(initial_placement(builder, frame).angular_velocity.isApprox(spin, 1e-12));
  EXPECT_GT(smallest_singular_value(*system, state), 1e-2);

  const Matrix3d turn = test::random_rotation(random);  // the whole moves rigidly
  const Vector3d shift = test::random_vector(random);
  for (int i = 0; i < 4; ++i) {
    Eigen::Map<Vector3d> node(state.q.data() + 3 * i);
    node = (turn * (node - origin) + origin + shift).eval();
  }
  Eigen::Map<Vector3d>(state.q.data() + 12) = origin + shift;
  const Eigen::Quaterniond p(turn);
  const double parameters[] = {p.w(), p.x(), p.y(), p.z()};
  std::copy_n(parameters, 4, state.q.begin() + 15);
  system->evaluate(state.view(), residual);
  for (const double x : residual.position) EXPECT_NEAR(x, 0.0, 1e-13);
  state.q[4] += 0.25;
  system->evaluate(state.view(), residual);
  EXPECT_NEAR(*std::max_element(residual.position.begin(), residual.position.end()), 0.25, 1e-13);
}

}  // namespace
}  // namespace mfs::dae
