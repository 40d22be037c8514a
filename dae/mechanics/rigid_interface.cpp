#include "dae/mechanics/rigid_interface.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/rotation.hpp"

namespace mfs::dae {
namespace {

using Parameters = Eigen::Map<const Eigen::Vector4d>;

/// A(p) s is quadratic in p: it is D(p) p, with D linear in p and D(p) u = D(u) p.
Eigen::Matrix<double, 3, 4> half_derivative(const Parameters& p, const Eigen::Vector3d& s) {
  const Eigen::Vector3d e = p.tail<3>();
  Eigen::Matrix<double, 3, 4> d;
  d.col(0) = p[0] * s + e.cross(s);
  d.rightCols<3>() = e * s.transpose() - s * e.transpose() - p[0] * cross_matrix(s);
  d.rightCols<3>().diagonal().array() += e.dot(s);
  return d;
}

/// Q with p^T Q u = lambda^T D(p) u.
Eigen::Matrix4d contracted(const Eigen::Vector3d& lambda, const Eigen::Vector3d& s) {
  Eigen::Matrix4d q;
  q(0, 0) = lambda.dot(s);
  q.topRightCorner<1, 3>() = s.cross(lambda).transpose();
  q.bottomLeftCorner<3, 1>() = s.cross(lambda);
  q.bottomRightCorner<3, 3>() = s * lambda.transpose() + lambda * s.transpose();
  q.bottomRightCorner<3, 3>().diagonal().array() -= lambda.dot(s);
  return q;
}

/// One element for each node: its 3 coordinates and the frame's 7.
class RigidInterface final : public ElementGroup {
 public:
  RigidInterface(std::string name, const std::vector<int>& node_coordinates, int frame,
                 std::vector<Eigen::Vector3d> arms)
      : name_(std::move(name)), arms_(std::move(arms)) {
    for (std::size_t e = 0; e < arms_.size(); ++e) {
      for (int k = 0; k < 3; ++k) coordinates_.push_back(node_coordinates[3 * e + k]);
      for (int k = 0; k < 7; ++k) coordinates_.push_back(frame + k);
    }
  }

  int size() const override { return static_cast<int>(arms_.size()); }
  int local_coordinates() const override { return kCoordinates; }
  int local_constraints() const override { return 3; }
  const int* coordinates(int e) const override { return coordinates_.data() + kCoordinates * e; }
  LocalStructure structure() const override {
    LocalStructure structure;
    structure.coupled_from = kP;
    return structure;
  }
  std::string name(int e) const override { return name_ + ", tied node " + std::to_string(e); }

  void residual(int e, const LocalState& state, LocalResidual& residual) const override {
    const Eigen::Vector3d& s = arms_[e];
    const Parameters p(state.q + kP), rate(state.v + kP), second(state.a + kP);
    const auto d = half_derivative(p, s);
    const Eigen::Vector3d arm = d * p, arm_rate = 2 * d * rate;
    const Eigen::Vector3d arm_second = 2 * (half_derivative(rate, s) * rate + d * second);
    for (int i = 0; i < 3; ++i) {
      residual.position[i] = state.q[i] - state.q[3 + i] - arm[i];
      residual.velocity[i] = state.v[i] - state.v[3 + i] - arm_rate[i];
      residual.acceleration[i] = state.a[i] - state.a[3 + i] - arm_second[i];
      residual.force[i] = state.lambda[i];
      residual.force[3 + i] = -state.lambda[i];
    }
    const Eigen::Map<const Eigen::Vector3d> lambda(state.lambda);
    Eigen::Map<Eigen::Vector4d>(residual.force + kP) = -2 * d.transpose() * lambda;
  }

  void tangent(int e, const LocalState& state, LocalTangent& tangent) const override {
    const Eigen::Vector3d& s = arms_[e];
    const Eigen::Map<const Eigen::Vector3d> lambda(state.lambda);
    for (int i = 0; i < 3; ++i) {
      tangent.position_q[i * kCoordinates + i] = 1;
      tangent.position_q[i * kCoordinates + 3 + i] = -1;
    }
    const auto by_p = half_derivative(Parameters(state.q + kP), s);
    const auto by_rate = half_derivative(Parameters(state.v + kP), s);
    const auto by_second = half_derivative(Parameters(state.a + kP), s);
    const auto force_by_p = contracted(lambda, s);
    for (int k = 0; k < 4; ++k) {
      for (int i = 0; i < 3; ++i) {
        const int entry = i * kCoordinates + kP + k;
        tangent.position_q[entry] = -2 * by_p(i, k);
        tangent.velocity_q[entry] = -2 * by_rate(i, k);
        tangent.acceleration_q[entry] = -2 * by_second(i, k);
        tangent.acceleration_v[entry] = -4 * by_rate(i, k);
      }
      for (int j = 0; j < 4; ++j) tangent.force_q[(kP + k) * kCoordinates + kP + j] = -2 * force_by_p(k, j);
    }
  }

 private:
  static constexpr int kP = 6,
                       kCoordinates = 10;  // where the Euler parameters begin; node, origin, parameters

  std::string name_;
  std::vector<Eigen::Vector3d> arms_;  // s
  std::vector<int> coordinates_;
};

/// Throws InvalidInput unless the arms, which must be three or more, span a plane.
void check_spread(const std::vector<Eigen::Vector3d>& arms, const std::string& owner) {
  if (arms.size() < 3) throw InvalidInput(owner, "it needs three nodes or more");
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& arm : arms) mean += arm / static_cast<double>(arms.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& arm : arms) spread += (arm - mean) * (arm - mean).transpose();
  const Eigen::Vector3d squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues();
  if (!(squares[1] > 1e-12 * squares[2])) throw InvalidInput(owner, "its nodes are on one line");
}

/// r' and w of the rigid motion r' + w x s nearest to `velocity`, in the sense of least squares.
void fit_motion(const std::vector<Eigen::Vector3d>& arms, const std::vector<Eigen::Vector3d>& velocity,
                Placement& placement) {
  const auto n = static_cast<Eigen::Index>(arms.size());
  Eigen::MatrixXd matrix(3 * n, 6);
  Eigen::VectorXd right(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d& s = arms[static_cast<std::size_t>(i)];
    matrix.block<3, 3>(3 * i, 0) = Eigen::Matrix3d::Identity();
    matrix.block<3, 3>(3 * i, 3) = -cross_matrix(s);
    right.segment<3>(3 * i) = velocity[static_cast<std::size_t>(i)];
  }
  const Eigen::VectorXd motion = matrix.colPivHouseholderQr().solve(right);
  placement.velocity = motion.head<3>();
  placement.angular_velocity = motion.tail<3>();
}

}  // namespace

std::vector<int> node_coordinates(CoordinateRange body, const std::vector<int>& nodes,
                                  const std::string& owner) {
  std::vector<int> coordinates;
  for (const int node : nodes) {
    if (node < 0 || node >= body.count / 3)
      throw InvalidInput(owner, "node " + std::to_string(node) + " is not one of the body's " +
                                    std::to_string(body.count / 3));
    for (int k = 0; k < 3; ++k) coordinates.push_back(body.first + 3 * node + k);
  }
  return coordinates;
}

Frame add_rigid_interface(MultibodyBuilder& builder, const std::string& name, CoordinateRange body,
                          const std::vector<int>& nodes, const Eigen::Vector3d& origin) {
  const std::string owner = "interface " + name;
  const std::vector<int> coordinates = node_coordinates(body, nodes, owner);
  std::vector<int> sorted = nodes;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) throw InvalidInput(owner, "node " + std::to_string(*twice) + " is named twice");

  std::vector<Eigen::Vector3d> arms, velocities;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto first = static_cast<std::size_t>(coordinates[3 * i]);
    arms.push_back(Eigen::Map<const Eigen::Vector3d>(builder.initial_q().data() + first) - origin);
    velocities.emplace_back(Eigen::Map<const Eigen::Vector3d>(builder.initial_v().data() + first));
  }
  check_spread(arms, owner);
  Placement placement;
  placement.position = origin;
  fit_motion(arms, velocities, placement);
  Frame frame = add_frame(builder, name, placement);
  builder.add(std::make_shared<RigidInterface>(owner, coordinates, frame.first, std::move(arms)));
  return frame;
}

}  // namespace mfs::dae
