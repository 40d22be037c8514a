#include "dae/model/measure.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "dae/fem/by_threads.hpp"
#include "dae/mechanics/rotation.hpp"

namespace mfs::dae {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

Vector3d vector(const Triple<double>& x) {
  return {x[0], x[1], x[2]};
}

/// An element's own part of the state.
class Gathered {
 public:
  Gathered(const ModelElement& element, int e, const State& state)
      : count_(static_cast<std::size_t>(element.group->local_coordinates())),
        values_(3 * count_),
        t_(state.t) {
    const int* coordinates = element.group->coordinates(e);
    for (std::size_t k = 0; k < count_; ++k) {
      const auto i = static_cast<std::size_t>(coordinates[k]);
      values_[k] = state.q[i];
      values_[count_ + k] = state.v[i];
      values_[2 * count_ + k] = state.a[i];
    }
    lambda_ = state.lambda.data() + element.first_row + e * element.group->local_constraints();
  }
  LocalState view() const {
    return {t_, values_.data(), values_.data() + count_, values_.data() + 2 * count_, lambda_};
  }

 private:
  std::size_t count_;
  std::vector<double> values_;
  double t_;
  const double* lambda_;
};

/// The element's share of F: minus its forces.
std::vector<double> share(const ModelElement& element, int e, const State& state) {
  const auto nc = static_cast<std::size_t>(element.group->local_constraints());
  std::vector<double> force(static_cast<std::size_t>(element.group->local_coordinates())), constraint(3 * nc);
  LocalResidual residual{force.data(), constraint.data(), constraint.data() + nc, constraint.data() + 2 * nc};
  element.group->residual(e, Gathered(element, e, state).view(), residual);
  return force;
}

/// On the frame, about its origin. By virtual work the forces Q on the Euler parameters are the moment
/// G Q / 2 in the frame's axes, as p' = G^T w / 2.
Wrench wrench_on_frame(const Frame& frame, const ModelElement& element, const State& state) {
  const int* coordinates = element.group->coordinates(0);
  const int* found = std::find(coordinates, coordinates + element.group->local_coordinates(), frame.first);
  const std::vector<double> force = share(element, 0, state);
  const auto k = static_cast<std::size_t>(found - coordinates);
  if (k + 7 > force.size()) return {};  // it does not act on this frame
  const double* p = &state.q[static_cast<std::size_t>(frame.first) + 3];
  const Vector3d moment = -0.5 * vector(g_times(p, &force[k + 3]));
  return {-Vector3d(force[k], force[k + 1], force[k + 2]), vector(rotate(p, moment))};
}

double principal_angle(double angle) {
  return std::remainder(angle, 2 * std::acos(-1.0));
}

/// Of `direction` about the third of the axes, from the first.
double angle_about_z(const Matrix3d& axes, const Vector3d& direction) {
  return std::atan2(axes.col(1).dot(direction), axes.col(0).dot(direction));
}

}  // namespace

FrameMotion frame_motion(const Frame& frame, const State& state) {
  FrameMotion motion;
  if (frame.is_ground()) return motion;
  const auto first = static_cast<std::size_t>(frame.first);
  const double *q = &state.q[first], *v = &state.v[first], *a = &state.a[first];
  motion.position = Eigen::Map<const Vector3d>(q);
  motion.velocity = Eigen::Map<const Vector3d>(v);
  motion.acceleration = Eigen::Map<const Vector3d>(a);
  motion.rotation = Eigen::Quaterniond(q[3], q[4], q[5], q[6]).normalized().toRotationMatrix();
  // In the frame's axes w = 2 G p', and w' = 2 G p'' as G' p' = 0.
  motion.angular_velocity = 2 * motion.rotation * vector(g_times(q + 3, v + 3));
  motion.angular_acceleration = 2 * motion.rotation * vector(g_times(q + 3, a + 3));
  return motion;
}

PointMotion point_motion(const FrameMotion& frame, const Vector3d& arm) {
  const Vector3d s = frame.rotation * arm, &w = frame.angular_velocity;
  return {frame.position + s, frame.velocity + w.cross(s),
          frame.acceleration + frame.angular_acceleration.cross(s) + w.cross(w.cross(s))};
}

PointMotion motion_of(const MultibodyModel& model, const ModelPoint& point, const State& state) {
  if (point.node < 0) return point_motion(frame_motion(point.frame, state), point.point);
  const FlexibleBody& body = model.flexible_bodies[static_cast<std::size_t>(point.body)];
  const auto first = static_cast<std::size_t>(body.range.first + 3 * point.node);
  const auto at_node = [&](const std::vector<double>& x) {
    return Vector3d(x[first], x[first + 1], x[first + 2]);
  };
  return {at_node(state.q), at_node(state.v), at_node(state.a)};
}

Vector4d quaternion(const Matrix3d& rotation) {
  return euler_parameters(rotation);
}

Wrench wrench_on(const Attachment& b, const Attachment& a, const std::vector<ModelElement>& elements,
                 const State& state) {
  const Attachment& side = b.frame.is_ground() ? a : b;
  const Vector3d point = point_motion(frame_motion(b.frame, state), b.point).position;
  Wrench sum;
  for (const ModelElement& element : elements) {
    const Wrench about_origin = wrench_on_frame(side.frame, element, state);
    const Vector3d arm = point - frame_motion(side.frame, state).position;
    sum.force += about_origin.force;
    sum.moment += about_origin.moment - arm.cross(about_origin.force);
  }
  if (!b.frame.is_ground()) return sum;
  return {-sum.force, -sum.moment};
}

Vector3d joint_position(const ModelJoint& joint, const State& state) {
  const FrameMotion a = frame_motion(joint.a.frame, state), b = frame_motion(joint.b.frame, state);
  const Vector3d point = point_motion(b, joint.b.point).position;
  if (!rolls(joint.kind)) return point;
  return point + contact_arm(a.rotation * joint.a.axes.col(2), b.rotation * joint.b.axes.col(2), joint.radius,
                             roller_of(joint.kind));
}

Wrench reaction(const ModelJoint& joint, const State& state) {
  Wrench wrench = wrench_on(joint.b, joint.a, joint.elements, state);
  const Vector3d point = point_motion(frame_motion(joint.b.frame, state), joint.b.point).position;
  wrench.moment -= (joint_position(joint, state) - point).cross(wrench.force);
  return wrench;
}

Vector3d force_on_nodes(const MultibodyModel& model, const std::vector<ModelElement>& elements,
                        const State& state) {
  Vector3d sum = Vector3d::Zero();
  for (const ModelElement& element : elements)
    for (int e = 0; e < element.group->size(); ++e) {
      const std::vector<double> force = share(element, e, state);
      for (std::size_t k = 0; k < force.size(); ++k) {
        const int i = element.group->coordinates(e)[k];
        for (const FlexibleBody& body : model.flexible_bodies)
          if (i >= body.range.first && i < body.range.first + body.range.count)
            sum[(i - body.range.first) % 3] -= force[k];
      }
    }
  return sum;
}

double force_along(int coordinate, const std::vector<ModelElement>& elements, const State& state) {
  double sum = 0;
  for (const ModelElement& element : elements)
    for (int e = 0; e < element.group->size(); ++e) {
      const std::vector<double> force = share(element, e, state);
      for (std::size_t k = 0; k < force.size(); ++k)
        if (element.group->coordinates(e)[k] == coordinate) sum -= force[k];
    }
  return sum;
}

Power power(const std::vector<ModelElement>& elements, const State& state) {
  Power sum;
  for (const ModelElement& element : elements)
    for (int e = 0; e < element.group->size(); ++e)
      sum += element.group->power(e, Gathered(element, e, state).view());
  return sum;
}

Energy energy(const std::vector<ModelElement>& elements, const State& state, int threads) {
  Energy sum;
  for (const ModelElement& element : elements)
    sum += sum_by_threads<Energy>(threads, element.group->size(), [&](int e) {
      return element.group->energy(e, Gathered(element, e, state).view());
    });
  return sum;
}

int angles_of(JointKind kind) {
  if (kind == JointKind::universal) return 2;
  return kind == JointKind::revolute || kind == JointKind::cylindrical ? 1 : 0;
}

bool slides(JointKind kind) {
  return kind == JointKind::translational || kind == JointKind::cylindrical;
}

JointMotion joint_motion(const ModelJoint& joint, const State& state) {
  const FrameMotion a = frame_motion(joint.a.frame, state), b = frame_motion(joint.b.frame, state);
  const Matrix3d axes_a = a.rotation * joint.a.axes, axes_b = b.rotation * joint.b.axes;
  const Vector3d turning = b.angular_velocity - a.angular_velocity;
  JointMotion motion;
  if (joint.kind == JointKind::universal) {
    // The cross turns about a's axis by the angle of b's axis there, and b about its own against a's axis.
    const Vector3d z_a = axes_a.col(2), z_b = axes_b.col(2);
    motion.angle = {principal_angle(angle_about_z(axes_a, z_b) - joint.angle_begin[0]),
                    principal_angle(joint.angle_begin[1] - angle_about_z(axes_b, z_a))};
    motion.angle_rate = {turning.dot(z_a), turning.dot(z_b)};
  } else if (angles_of(joint.kind) == 1) {
    motion.angle = {angle_about_z(axes_a, axes_b.col(0))};
    motion.angle_rate = {turning.dot(axes_a.col(2))};
  }
  if (!slides(joint.kind)) return motion;
  const PointMotion from = point_motion(a, joint.a.point), to = point_motion(b, joint.b.point);
  const Vector3d apart = to.position - from.position, z = axes_a.col(2);
  motion.travel = z.dot(apart);
  motion.travel_rate = z.dot(to.velocity - from.velocity) + a.angular_velocity.cross(z).dot(apart);
  return motion;
}

}  // namespace mfs::dae
