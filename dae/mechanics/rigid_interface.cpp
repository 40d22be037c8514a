#include "dae/mechanics/rigid_interface.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/rotation.hpp"
#include "dae/mechanics/whole_group.hpp"

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

/// Q with p^T Q u = lambda^T D(p) u, of m = lambda s^T, in which it is linear.
Eigen::Matrix4d contracted(const Eigen::Matrix3d& m) {
  const Eigen::Vector3d turn(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));  // s x lambda
  Eigen::Matrix4d q;
  q(0, 0) = m.trace();
  q.topRightCorner<1, 3>() = turn.transpose();
  q.bottomLeftCorner<3, 1>() = turn;
  q.bottomRightCorner<3, 3>() = m + m.transpose();
  q.bottomRightCorner<3, 3>().diagonal().array() -= m.trace();
  return q;
}

/// M with M s = D(p) u, of half_derivative.
Eigen::Matrix3d product(const Parameters& p, const Parameters& u) {
  Eigen::Matrix3d m;
  for (int k = 0; k < 3; ++k) m.col(k) = half_derivative(p, Eigen::Vector3d::Unit(k)) * u;
  return m;
}

/// What a frame has in a vector of a system: 3 of its origin, 4 parameters.
class FrameValues {
 public:
  FrameValues(const double* x, const int* place) {
    for (int k = 0; k < 7; ++k) values_[k] = x[place[k]];
  }
  double operator[](int k) const { return values_[k]; }
  Parameters parameters() const { return Parameters(values_ + 3); }

 private:
  double values_[7];
};

/// One element for each node: its 3 coordinates and the frame's 7.
class RigidInterface final : public WholeGroup {
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

  // Of the frame's share every link needs the same: A(p) and its derivatives by time, and forces and moments
  // of all together.
  void residual_of_all(const StateView& state, const int* coordinates, int row,
                       const ResidualView& residual) const override {
    const int* const frame = coordinates + kFrame;
    const FrameValues q(state.q, frame), v(state.v, frame), a(state.a, frame);
    const Eigen::Matrix3d at = product(q.parameters(), q.parameters()),
                          turning = 2 * product(q.parameters(), v.parameters()),
                          second_turning = 2 * (product(v.parameters(), v.parameters()) +
                                                product(q.parameters(), a.parameters()));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t e = 0; e < arms_.size(); ++e) {
      const Eigen::Vector3d& s = arms_[e];
      const int* const node = coordinates + kCoordinates * e;
      const Eigen::Vector3d arm = at * s, arm_rate = turning * s, arm_second = second_turning * s;
      for (int i = 0; i < 3; ++i) {
        const auto at_row = static_cast<std::size_t>(row + i) + 3 * e;
        residual.position[at_row] = state.q[node[i]] - q[i] - arm[i];
        residual.velocity[at_row] = state.v[node[i]] - v[i] - arm_rate[i];
        residual.acceleration[at_row] = state.a[node[i]] - a[i] - arm_second[i];
        residual.force[node[i]] += state.lambda[at_row];
        sum[i] += state.lambda[at_row];
      }
    }
    const Eigen::Vector4d turn = 2 * contracted(moments(state.lambda + row)) * q.parameters();
    for (int i = 0; i < 3; ++i) residual.force[frame[i]] -= sum[i];
    for (int i = 0; i < 4; ++i) residual.force[frame[3 + i]] -= turn[i];
  }

  void tangent_of_all(const StateView& state, int row, const TangentOfAll& tangent) const override {
    const int* const frame = coordinates(0) + kFrame;
    const FrameValues q(state.q, frame), v(state.v, frame), a(state.a, frame);
    const auto set = [&](double* values, double of_node, double factor, const FrameValues& of_frame) {
      if (values == nullptr) return;
      const int* rank = tangent.rank;
      for (const Eigen::Vector3d& s : arms_) {
        const Eigen::Matrix<double, 3, 4> by_p = factor * half_derivative(of_frame.parameters(), s);
        for (int i = 0; i < 3; ++i, values += kCoordinates) {
          std::fill_n(values, kCoordinates, 0.0);
          values[rank[i]] = of_node;
          values[rank[kFrame + i]] = -of_node;
          for (int k = 0; k < 4; ++k) values[rank[kP + k]] = by_p(i, k);
        }
        rank += kCoordinates;
      }
    };
    set(tangent.position_q, 1, -2, q);
    set(tangent.velocity_q, 0, -2, v);
    set(tangent.acceleration_q, 0, -2, a);
    set(tangent.acceleration_v, 0, -4, v);
    if (tangent.force_q == nullptr) return;
    const Eigen::Matrix4d by_p = -2 * contracted(moments(state.lambda + row));
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 4; ++j) tangent.force_q[(kP + k) * kCoordinates + kP + j] = by_p(k, j);
  }

 private:
  // Where the frame and its Euler parameters begin; node, origin, parameters.
  static constexpr int kFrame = 3, kP = 6, kCoordinates = 10;

  /// Of lambda s^T, over all links.
  Eigen::Matrix3d moments(const double* lambda) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& s : arms_) {
      sum += Eigen::Map<const Eigen::Vector3d>(lambda) * s.transpose();
      lambda += 3;
    }
    return sum;
  }

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
