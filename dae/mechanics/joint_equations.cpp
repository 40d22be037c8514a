#include "dae/mechanics/joint_equations.hpp"

#include <cmath>
#include <cstdio>

#include "dae/mechanics/joint_element.hpp"

namespace mfs::dae {
namespace {

/// Of the two directions along a line the one whose largest component is positive.
std::string line(const char* what, Eigen::Vector3d along) {
  along.normalize();
  Eigen::Index largest = 0;
  along.cwiseAbs().maxCoeff(&largest);
  if (along[largest] < 0) along = -along;
  for (double& component : along)
    if (std::abs(component) < 5e-4) component = 0.0;
  char text[80];
  std::snprintf(text, sizeof text, "%s [%.3g %.3g %.3g]", what, along[0], along[1], along[2]);
  return text;
}

}  // namespace

std::vector<std::string> directions_of(const MultibodyBuilder& builder, const Attachment& a,
                                       const Attachment& b, const std::vector<JointEquation>& equations) {
  using Kind = JointEquation::Kind;
  const Eigen::Matrix3d axes_a = initial_placement(builder, a.frame).rotation * a.axes;
  const Eigen::Matrix3d axes_b = initial_placement(builder, b.frame).rotation * b.axes;
  std::vector<std::string> directions;
  for (const JointEquation& equation : equations) switch (equation.kind) {
      case Kind::apart_ground:
        directions.push_back(std::string("along ground ") + "xyz"[equation.k]);
        break;
      case Kind::apart:
        directions.push_back(line("along", axes_a.col(equation.k)));
        break;
      case Kind::perpendicular:
        directions.push_back(line("about", axes_a.col(equation.k).cross(axes_b.col(equation.l))));
        break;
      case Kind::turned:
        directions.push_back(line("about", axes_a.col(2)));
        break;
    }
  return directions;
}

void add_joint_equations(MultibodyBuilder& builder, const std::string& owner, const Attachment& a,
                         const Attachment& b, const std::vector<JointEquation>& equations) {
  FramePair sides(a, b, owner);
  builder.add(make_pair_element<JointElement>(
      owner, a, b, JointEquations(std::move(sides), equations, directions_of(builder, a, b, equations))));
}

}  // namespace mfs::dae
