#include "dae/mechanics/frame.hpp"

#include <cmath>
#include <vector>

#include <mfs/error.hpp>

#include "dae/mechanics/rotation.hpp"
#include "dae/mechanics/single_element.hpp"

namespace mfs::dae {
namespace {

struct UnitLength {
  static constexpr bool kNormalizes = true;
  int count() const { return 1; }
  std::string direction(int) const { return {}; }
  template <class T>
  void positions(double, const T* p, T* x) const {
    x[0] = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3] - T(1.0);
  }
};

}  // namespace

Frame add_frame(MultibodyBuilder& builder, const std::string& name, const Placement& placement) {
  const std::string owner = "body " + name;
  check_axes(placement.rotation, owner);
  if (!placement.position.allFinite() || !placement.velocity.allFinite() ||
      !placement.angular_velocity.allFinite())
    throw InvalidInput(owner, "its position or velocity is not finite");
  const Eigen::Vector4d p = euler_parameters(placement.rotation);
  const Eigen::Vector3d half =
      0.5 * placement.rotation.transpose() * placement.angular_velocity;  // body axes
  const Quadruple<double> rate = g_transposed_times(p.data(), Triple<double>{half[0], half[1], half[2]});
  const Eigen::Vector3d &r = placement.position, &v = placement.velocity;
  const CoordinateRange range = builder.add_coordinates(
      name, {r[0], r[1], r[2], p[0], p[1], p[2], p[3]},
      {v[0], v[1], v[2], rate[0], rate[1], rate[2], rate[3]}, {"x", "y", "z", "e0", "e1", "e2", "e3"}, 3);
  const int e0 = range.first + 3;
  builder.add(std::make_shared<ConstraintElement<UnitLength, 4>>(
      owner + ", Euler parameters", std::array<int, 4>{e0, e0 + 1, e0 + 2, e0 + 3}, UnitLength{}));
  return {name, range.first};
}

Placement initial_placement(const MultibodyBuilder& builder, const Frame& frame) {
  Placement placement;
  if (frame.is_ground()) return placement;
  const double* q = builder.initial_q().data() + frame.first;
  const double* v = builder.initial_v().data() + frame.first;
  placement.position = Eigen::Map<const Eigen::Vector3d>(q);
  placement.velocity = Eigen::Map<const Eigen::Vector3d>(v);
  for (int k = 0; k < 3; ++k) {
    const Triple<double> axis = rotate(q + 3, Eigen::Vector3d::Unit(k));
    placement.rotation.col(k) = Eigen::Vector3d(axis[0], axis[1], axis[2]);
  }
  const Triple<double> half = g_times(q + 3, v + 3);
  placement.angular_velocity = 2 * placement.rotation * Eigen::Vector3d(half[0], half[1], half[2]);
  return placement;
}

Attachment attach(const MultibodyBuilder& builder, const Frame& frame, const Eigen::Vector3d& point,
                  const Eigen::Matrix3d& axes) {
  const Placement placement = initial_placement(builder, frame);
  const Eigen::Matrix3d into_frame = placement.rotation.transpose();
  return {frame, into_frame * (point - placement.position), into_frame * axes};
}

Eigen::Matrix3d axes_along(const Eigen::Vector3d& z, const Eigen::Vector3d& x) {
  if (z.isZero(0.0) || !z.allFinite()) throw InvalidInput("axis", "it has no direction");
  Eigen::Matrix3d axes;
  // The square of 1e300 is no number, that of 1e-300 is zero.
  axes.col(2) = (z / z.cwiseAbs().maxCoeff()).normalized();
  const Eigen::Vector3d across = x.isZero(0.0) ? Eigen::Vector3d(axes.col(2).unitOrthogonal())
                                               : Eigen::Vector3d(x - axes.col(2).dot(x) * axes.col(2));
  if (!(across.norm() > 1e-8 * x.norm())) throw InvalidInput("axis", "the second axis is along the first");
  axes.col(0) = across.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

void check_axes(const Eigen::Matrix3d& axes, const std::string& owner) {
  const double error = (axes.transpose() * axes - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error < 1e-10) || axes.determinant() < 0)
    throw InvalidInput(owner, "its axes are no right-handed unit vectors");
}

}  // namespace mfs::dae
