// The derivatives of every part that has formulas, at random states.
#include <gtest/gtest.h>

#include <functional>

#include "dae/mechanics/forces.hpp"
#include "dae/mechanics/joints.hpp"
#include "dae/mechanics/loads.hpp"
#include "dae/mechanics/measures.hpp"
#include "dae/mechanics/motions.hpp"
#include "dae/mechanics/rigid_interface.hpp"
#include "test/dae/mechanics/two_bodies.hpp"

namespace mfs::dae {
namespace {

using test::Random;

using AddPart = std::function<void(MultibodyBuilder&, const Attachment&, const Attachment&)>;

struct Part {
  std::string name;
  AddPart add;
};

Part joint(const std::string& name, JointKind kind) {
  return {name, [kind](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
            add_joint(builder, {"pin", kind, a, b, 0.4});
          }};
}

const Function kSwing = harmonic_function(0.2, 0.7, 0.5, 0.3);
const Function kStep = smooth_step(-0.5, 1.5, 0.1, 0.9);

/// An expression in x and y, which are these coordinates of the system, the rate w of the second, and t.
StateFunction expression_of(const std::string& text, int x, int y) {
  using Kind = StateFunction::Argument::Kind;
  const Expression expression(text);
  std::vector<StateFunction::Argument> arguments;
  for (const std::string& name : expression.variables())
    arguments.push_back(name == "x"   ? StateFunction::Argument{Kind::coordinate, 0.1, x}
                        : name == "y" ? StateFunction::Argument{Kind::coordinate, 0.0, y}
                        : name == "w" ? StateFunction::Argument{Kind::rate, 0.0, y}
                                      : StateFunction::Argument{Kind::time});
  return {expression, arguments};
}

Part measure(const std::string& name, Measure kind) {
  return {name, [kind](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
            add_measure(builder, "gauge", a, b, kind);
          }};
}

/// With sizes that depend on the angle between the sides and the height of the second.
Part load(const std::string& name, decltype(&add_torque) add, LoadAxes axes) {
  return {name, [add, axes](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
            const int angle = add_measure(builder, "angle", a, b, Measure::angle);
            const int height = add_measure(builder, "height", a, b, Measure::z);
            add(builder, "load", b.frame.is_ground() ? a : b,
                {expression_of("3*sin(x)*y - w*y", angle, height), nullptr,
                 expression_of("t*x^2 + w^3", height, angle)},
                axes);
          }};
}

std::vector<Part> parts() {
  return {
      measure("angle", Measure::angle),
      measure("travel", Measure::travel),
      measure("distance", Measure::distance),
      measure("place", Measure::y),
      load("force", add_point_force, LoadAxes::ground),
      load("follower", add_point_force, LoadAxes::attachment),
      load("torque", add_torque, LoadAxes::ground),
      load("torque that follows", add_torque, LoadAxes::attachment),
      {"coordinate force",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         const int own = add_measure(builder, "angle", a, b, Measure::angle);
         const int other = add_measure(builder, "height", a, b, Measure::z);
         add_coordinate_force(builder, "drive", own, expression_of("x*y*w + sin(t*x)", own, other));
       }},
      {"coordinate spring",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         const Function table = spline_function({-4, -1, 0, 1, 2, 5}, {-9, -1, 0, 2, 5, 9});
         const int angle = add_measure(builder, "angle", a, b, Measure::angle);
         add_coordinate_spring(builder, {"coil", angle, 0.0, 0.3, 0.4, table});
         add_coordinate_spring(builder, {"bar", angle, 2.0, 0.3, 0.4, nullptr});
       }},
      {"motion that depends on others",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         const int angle = add_measure(builder, "angle", a, b, Measure::angle);
         const int travel = add_measure(builder, "travel", a, b, Measure::travel);
         add_coordinate_motion(builder, "gear", {0, 8}, expression_of("x^2*y*t + sin(x)*y^3", angle, travel));
       }},
      {"bodies only", [](MultibodyBuilder&, const Attachment&, const Attachment&) {}},
      joint("fixed", JointKind::fixed),
      joint("revolute", JointKind::revolute),
      joint("spherical", JointKind::spherical),
      joint("universal", JointKind::universal),
      joint("translational", JointKind::translational),
      joint("cylindrical", JointKind::cylindrical),
      joint("rolling wheel", JointKind::rolling_wheel),
      joint("rolling ball", JointKind::rolling_ball),
      {"rotation", [](MultibodyBuilder& builder, const Attachment& a,
                      const Attachment& b) { add_rotation(builder, "drive", a, b, kSwing); }},
      {"translation", [](MultibodyBuilder& builder, const Attachment& a,
                         const Attachment& b) { add_translation(builder, "drive", a, b, kStep); }},
      {"point motion",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         add_point_motion(builder, "drive", b.frame.is_ground() ? a : b, {kSwing, nullptr, kStep});
       }},
      {"coordinate motion",
       [](MultibodyBuilder& builder, const Attachment&, const Attachment&) {
         add_coordinate_motion(builder, "drive", {1, 4}, kSwing);
       }},
      {"bushing",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         add_bushing(builder, {"rubber", a, b, {3, 2, 1, 4, 5, 6}, {0.3, 0.2, 0.1, 0.4, 0.5, 0.6}});
       }},
      {"spring",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         add_spring_damper(builder, {"coil", a, b, 2.0, 0.3, 0.4, nullptr});
       }},
      {"spring by table",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         const Function table = spline_function({-4, -1, 0, 1, 2, 5}, {-9, -1, 0, 2, 5, 9});
         add_spring_damper(builder, {"coil", a, b, 0.0, 0.3, 0.4, table});
       }},
      {"point force",
       [](MultibodyBuilder& builder, const Attachment& a, const Attachment& b) {
         add_point_force(builder, "load", b.frame.is_ground() ? a : b, {nullptr, kSwing, kStep});
       }},
  };
}

enum class Sides { two_bodies, ground_first, ground_second };

void expect_true_derivatives(const Part& part, Sides sides, std::uint64_t seed) {
  SCOPED_TRACE(part.name + ", sides " + std::to_string(static_cast<int>(sides)) + ", seed " +
               std::to_string(seed));
  Random random(seed);
  MultibodyBuilder builder;
  const Frame first = add_rigid_body(builder, test::random_body(random, "first"), {0, 0, -9.81});
  const Frame second = add_rigid_body(builder, test::random_body(random, "second"), {1, 2, 3});
  const Attachment a = test::random_attachment(random, sides == Sides::ground_first ? Frame{} : first);
  const Attachment b = test::random_attachment(random, sides == Sides::ground_second ? Frame{} : second);
  part.add(builder, a, b);
  const auto system = builder.build(1);
  test::expect_true_derivatives(*system, test::random_state(random, builder, system->constraints()));
}

TEST(Derivatives, OfAllPartsAreTrue) {
  for (const Part& part : parts())
    for (const Sides sides : {Sides::two_bodies, Sides::ground_first, Sides::ground_second})
      for (std::uint64_t seed = 1; seed <= 3; ++seed) expect_true_derivatives(part, sides, seed);
}

TEST(Derivatives, OfARigidInterfaceAreTrue) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    MultibodyBuilder builder;
    const CoordinateRange body = builder.add_coordinates("arm", random.vector(15), random.vector(15));
    add_rigid_interface(builder, "eye", body, {4, 0, 2}, test::random_vector(random));
    add_nodal_force(builder, "load", body, {1, 4}, {0.25, 0.75}, {kSwing, nullptr, kStep});
    const auto system = builder.build(1);
    test::expect_true_derivatives(*system, test::random_state(random, builder, system->constraints()));
  }
}

}  // namespace
}  // namespace mfs::dae
