#include "dae/integrator/body_turns.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <cstddef>

namespace mfs::dae {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Second of the extents of a body, in parts of the first, below which its points are on one line.
constexpr double kOnOneLine = 1e-10;
/// Turned by more a rotation vector might be that of the other way round, rad.
constexpr double kMostTurn = 3.0;

/// The rotation by which points have come from X nearest to x, in least squares (Kabsch 1976); no rotation
/// where there are several. `known`: false then.
Matrix nearest_rotation(const Matrix& x_by_now, bool& known) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(x_by_now, Eigen::ComputeFullU | Eigen::ComputeFullV);
  known = svd.singularValues()[1] > kOnOneLine * svd.singularValues()[0];
  if (!known) return Matrix::Identity();
  Eigen::Vector3d sign(1.0, 1.0, 1.0);
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) sign[2] = -1.0;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

TurnedShares turned_shares(const std::vector<PointSums>& sums, int points,
                           const std::vector<double>& shares) {
  std::vector<Matrix> turn;
  std::vector<Eigen::Vector3d> centre;
  Eigen::Vector3d turn_between = Eigen::Vector3d::Zero(), centre_between = Eigen::Vector3d::Zero();
  bool known = true;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    bool here = true;
    turn.push_back(nearest_rotation(Eigen::Map<const Matrix>(sums[k].x_by_now.data()), here));
    const Eigen::AngleAxisd vector{Eigen::Matrix3d(turn.back())};
    known = known && here && std::abs(vector.angle()) < kMostTurn;
    centre.emplace_back(Eigen::Map<const Eigen::Vector3d>(sums[k].x.data()) / points);
    turn_between += shares[k] * vector.angle() * vector.axis();
    centre_between += shares[k] * centre.back();
  }
  const double angle = turn_between.norm();
  Eigen::Matrix3d between = Eigen::Matrix3d::Identity();
  if (known && angle > 0.0) between = Eigen::AngleAxisd(angle, turn_between / angle).toRotationMatrix();
  TurnedShares result;
  result.matrix.resize(sums.size());
  Eigen::Map<Eigen::Vector3d> shift(result.shift.data());
  shift = centre_between;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    Eigen::Map<Matrix> matrix(result.matrix[k].data());
    matrix = shares[k] * Eigen::Matrix3d::Identity();
    if (known) matrix = shares[k] * between * turn[k].transpose();
    shift -= matrix * centre[k];
  }
  return result;
}

}  // namespace mfs::dae
