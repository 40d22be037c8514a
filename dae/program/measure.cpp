#include "dae/program/measure.hpp"

#include "dae/mechanics/rotation.hpp"

namespace mfs::dae {
namespace {

using Vector3 = Eigen::Map<const Eigen::Vector3d>;
using Vector4 = Eigen::Map<const Eigen::Vector4d>;

Eigen::Vector3d rotated(const Eigen::Vector4d& p, const Eigen::Vector3d& s) {
  const Triple<double> x = rotate(p.data(), s);
  return {x[0], x[1], x[2]};
}

}  // namespace

Eigen::Vector3d frame_point(const double* q, const Eigen::Vector3d& point) {
  return Vector3(q) + rotated(Vector4(q + 3), point);
}

Eigen::Vector3d point_acceleration(const MeasuredPoint& point, const State& state) {
  Eigen::Vector3d origin = Vector3(&state.a[point.first]);
  if (!point.on_frame) return origin;
  // A(p) s is quadratic in p, say B(p, p), so its second derivative is 2 B(p', p') + 2 B(p, p''), and
  // 2 B(p, p'') = B(p + p'', p + p'') - B(p, p) - B(p'', p'').
  const Eigen::Vector4d p = Vector4(&state.q[point.first + 3]), rate = Vector4(&state.v[point.first + 3]),
                        second = Vector4(&state.a[point.first + 3]);
  const Eigen::Vector3d& s = point.point;
  return origin + 2 * rotated(rate, s) + rotated(p + second, s) - rotated(p, s) - rotated(second, s);
}

double joint_force(const MeasuredJoint& joint, const State& state) {
  return Eigen::Map<const Eigen::VectorXd>(&state.lambda[joint.first_row], joint.rows).norm();
}

}  // namespace mfs::dae
