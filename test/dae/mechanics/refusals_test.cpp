// What cannot be is refused, by the name of the part.
#include <gtest/gtest.h>

#include <cmath>

#include "dae/mechanics/forces.hpp"
#include "dae/mechanics/joints.hpp"
#include "dae/mechanics/loads.hpp"
#include "dae/mechanics/motions.hpp"
#include "dae/mechanics/rigid_interface.hpp"
#include "test/dae/mechanics/expect_refused.hpp"
#include "test/dae/mechanics/two_bodies.hpp"

namespace mfs::dae {
namespace {

using test::expect_refused;

class Refusals : public testing::Test {
 protected:
  void SetUp() override {
    test::Random random(1);
    first_ = add_rigid_body(builder_, test::random_body(random, "crank"), Eigen::Vector3d::Zero());
    second_ = add_rigid_body(builder_, test::random_body(random, "rod"), Eigen::Vector3d::Zero());
    arm_ = builder_.add_coordinates("arm", {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0}, std::vector<double>(12));
  }
  MultibodyBuilder builder_;
  Frame first_, second_;
  CoordinateRange arm_;
  Function f_ = constant_function(1);
};

TEST_F(Refusals, Functions) {
  expect_refused("frequency", "not positive", [] { harmonic_function(0, 1, 0, 0); });
  expect_refused("end", "not after begin", [] { smooth_step(1, 1, 0, 1); });
  expect_refused("x", "two points", [] { spline_function({1}, {1}); });
  expect_refused("y", "2 points, but 3 values", [] { spline_function({1, 2}, {1, 2, 3}); });
  expect_refused("x", "does not ascend", [] { spline_function({1, 1}, {1, 2}); });
  expect_refused("x", "not finite", [] { spline_function({1, INFINITY}, {1, 2}); });
  expect_refused("y", "not finite", [] { spline_function({1, 2}, {NAN, 2}); });
}

TEST_F(Refusals, Bodies) {
  const auto with = [&](auto change) {
    test::Random random(2);
    RigidBody body = test::random_body(random, "knuckle");
    change(body);
    add_rigid_body(builder_, body, Eigen::Vector3d::Zero());
  };
  const std::string name = "body knuckle";
  expect_refused(name, "mass is not positive", [&] { with([](RigidBody& b) { b.mass = 0; }); });
  expect_refused(name, "mass is not positive", [&] { with([](RigidBody& b) { b.mass = NAN; }); });
  expect_refused(name, "not finite", [&] { with([](RigidBody& b) { b.inertia(1, 1) = NAN; }); });
  expect_refused(name, "not symmetric", [&] { with([](RigidBody& b) { b.inertia(0, 1) += 0.1; }); });
  expect_refused(name, "not positive definite", [&] { with([](RigidBody& b) { b.inertia *= -1; }); });
  expect_refused(name, "axes", [&] { with([](RigidBody& b) { b.placement.rotation *= 1.001; }); });
  expect_refused(name, "axes", [&] { with([](RigidBody& b) { b.placement.rotation.col(0) *= -1; }); });
  expect_refused(name, "position or velocity",
                 [&] { with([](RigidBody& b) { b.placement.velocity[1] = NAN; }); });
  expect_refused("axis", "no direction", [] { axes_along({0, 0, 0}); });
  expect_refused("axis", "no direction", [] { axes_along({0, 0, INFINITY}); });
  expect_refused("axis", "along the first", [] { axes_along({0, 0, 1}, {0, 0, 3}); });
}

TEST_F(Refusals, JointsAndMotions) {
  const Attachment a{first_}, b{second_}, ground;
  Attachment skew = b, nowhere = b;
  skew.axes(0, 0) = 2;
  nowhere.point[0] = NAN;
  const auto joint = [&](const Attachment& x, const Attachment& y) {
    add_joint(builder_, {"pin", JointKind::fixed, x, y});
  };
  expect_refused("joint pin", "both sides are on the same body, crank", [&] { joint(a, a); });
  expect_refused("joint pin", "both sides are on the same body, ground", [&] { joint(ground, ground); });
  expect_refused("joint pin on rod", "axes", [&] { joint(a, skew); });
  expect_refused("joint pin", "its point on rod is not finite", [&] { joint(nowhere, a); });
  expect_refused("motion drive", "same body", [&] { add_rotation(builder_, "drive", a, a, f_); });
  expect_refused("motion drive", "no function", [&] { add_rotation(builder_, "drive", a, b, nullptr); });
  expect_refused("motion drive", "no function", [&] { add_translation(builder_, "drive", a, b, nullptr); });
  expect_refused("motion drive", "no function", [&] { add_point_motion(builder_, "drive", a, {}); });
  expect_refused("motion drive", "ground", [&] { add_point_motion(builder_, "drive", ground, {f_}); });
  expect_refused("motion drive", "no function",
                 [&] { add_coordinate_motion(builder_, "drive", {0}, nullptr); });
  expect_refused("motion drive", "no coordinate", [&] { add_coordinate_motion(builder_, "drive", {}, f_); });
  expect_refused("motion drive", "coordinate 26", [&] {
    add_coordinate_motion(builder_, "drive", {0, 26}, f_);
  });
}

TEST_F(Refusals, Forces) {
  const Attachment a{first_}, b{second_}, ground;
  expect_refused("bushing rubber", "a stiffness is negative", [&] {
    add_bushing(builder_, {"rubber", a, b, {-1}, {}});
  });
  expect_refused("bushing rubber", "a damping is negative", [&] {
    add_bushing(builder_, {"rubber", a, b, {}, {-1}});
  });
  expect_refused("bushing rubber", "same body", [&] { add_bushing(builder_, {"rubber", a, a, {}, {}}); });
  const auto spring = [&](const Attachment& x, const Attachment& y, double k, double c, double l,
                          const Function& f) {
    add_spring_damper(builder_, {"coil", x, y, k, c, l, f});
  };
  expect_refused("spring coil", "stiffness is negative", [&] { spring(a, b, -1, 0, 0, nullptr); });
  expect_refused("spring coil", "damping is negative", [&] { spring(a, b, 1, NAN, 0, nullptr); });
  expect_refused("spring coil", "free length is negative", [&] { spring(a, b, 1, 0, -1, nullptr); });
  expect_refused("spring coil", "both a stiffness and a function", [&] { spring(a, b, 1, 0, 0, f_); });
  expect_refused("spring coil", "same body", [&] { spring(b, b, 1, 0, 0, nullptr); });
  Attachment on_ground;
  on_ground.point = initial_placement(builder_, first_).position;
  expect_refused("spring coil", "together", [&] { spring(a, on_ground, 1, 0, 1, nullptr); });
  expect_refused("spring coil", "together", [&] { spring(a, on_ground, 1, 1, 0, nullptr); });
  expect_refused("spring coil", "together", [&] { spring(a, on_ground, 0, 0, 0, f_); });
  expect_refused("force load", "no function", [&] { add_point_force(builder_, "load", a, {}); });
  expect_refused("force load", "ground", [&] { add_point_force(builder_, "load", ground, {f_}); });
  const auto nodal = [&](const std::vector<int>& nodes, const std::vector<double>& fractions,
                         const Function& f) {
    add_nodal_force(builder_, "load", arm_, nodes, fractions, {f});
  };
  expect_refused("force load", "no function", [&] { nodal({0}, {1}, nullptr); });
  expect_refused("force load", "no node", [&] { nodal({}, {}, f_); });
  expect_refused("force load", "1 nodes, but 2 fractions", [&] { nodal({0}, {1, 2}, f_); });
  expect_refused("force load", "node 4 is not one of the body's 4", [&] { nodal({4}, {1}, f_); });
}

TEST_F(Refusals, SpringWhoseEndsComeTogether) {
  const Attachment a{first_}, b{second_};
  add_spring_damper(builder_, {"coil", a, b, 1, 0, 1, nullptr});
  const auto system = builder_.build(1);
  std::vector<double> q = builder_.initial_q(), zero(q.size());
  std::copy_n(q.begin(), 3, q.begin() + 7);
  Residual residual = make_residual(*system);
  expect_refused("spring coil", "come together", [&] {
    system->evaluate({0, q.data(), zero.data(), zero.data(), zero.data()}, residual);
  });
}

TEST_F(Refusals, RigidInterfaces) {
  const auto tie = [&](const std::vector<int>& nodes) {
    add_rigid_interface(builder_, "eye", arm_, nodes, Eigen::Vector3d::Zero());
  };
  expect_refused("interface eye", "node 4 is not one of the body's 4", [&] { tie({0, 1, 4}); });
  expect_refused("interface eye", "node -1", [&] { tie({-1, 1, 3}); });
  expect_refused("interface eye", "node 3 is named twice", [&] { tie({0, 3, 1, 3}); });
  expect_refused("interface eye", "three nodes", [&] { tie({0, 1}); });
  expect_refused("interface eye", "on one line", [&] { tie({0, 1, 2}); });
  tie({0, 1, 3});
}

}  // namespace
}  // namespace mfs::dae
