#include "dae/mechanics/joints.hpp"

#include <vector>

#include "dae/mechanics/joint_equations.hpp"

namespace mfs::dae {
namespace {

constexpr int kX = 0, kY = 1, kZ = 2;

std::vector<JointEquation> equations_of(JointKind kind) {
  using Kind = JointEquation::Kind;
  std::vector<JointEquation> equations;
  const auto points_together = [&] {
    for (int k = 0; k < 3; ++k) equations.push_back({Kind::apart_ground, k});
  };
  const auto point_on_axis = [&] {
    for (const int k : {kX, kY}) equations.push_back({Kind::apart, k});
  };
  const auto perpendicular = [&](int k, int l) { equations.push_back({Kind::perpendicular, k, l}); };
  const auto axes_parallel = [&] {
    perpendicular(kX, kZ);
    perpendicular(kY, kZ);
  };
  const bool slides = kind == JointKind::translational || kind == JointKind::cylindrical;
  slides ? point_on_axis() : points_together();
  if (kind == JointKind::universal) perpendicular(kZ, kZ);
  if (kind != JointKind::universal && kind != JointKind::spherical) axes_parallel();
  if (kind == JointKind::fixed || kind == JointKind::translational) perpendicular(kX, kY);
  return equations;
}

}  // namespace

void add_joint(MultibodyBuilder& builder, const Joint& joint) {
  const std::string owner = "joint " + joint.name;
  if (rolls(joint.kind))
    return add_rolling(builder, owner, joint.a, joint.b, joint.radius, roller_of(joint.kind));
  add_joint_equations(builder, owner, joint.a, joint.b, equations_of(joint.kind));
}

}  // namespace mfs::dae
