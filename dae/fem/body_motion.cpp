#include "dae/fem/body_motion.hpp"

#include <Eigen/Dense>
#include <Eigen/StdVector>

#include "dae/fem/by_threads.hpp"

namespace mfs::dae {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Sums over the mass matrix M: of one and of two of the fields X (mesh), x, x', x''. Positions are measured
// from a node of the body, so that nothing is lost far from the origin.
struct Moments {
  double mass = 0;
  Vector3d mesh = Vector3d::Zero(), q = mesh, v = mesh, a = mesh;
  Matrix3d q_mesh = Matrix3d::Zero(), q_q = q_mesh, q_v = q_mesh, q_a = q_mesh;  // sum M_ij x_i y_j^T

  Moments& operator+=(const Moments& other) {
    mass += other.mass;
    mesh += other.mesh;
    q += other.q;
    v += other.v;
    a += other.a;
    q_mesh += other.q_mesh;
    q_q += other.q_q;
    q_v += other.q_v;
    q_a += other.q_a;
    return *this;
  }
};

Moments moments_of(const SolidGroup& body, int e, const double* q, const double* v, const double* a) {
  constexpr int kMostNodes = 20;
  const int nodes = nodes_per_element(body.mesh().kind);
  const int* element = &body.mesh().elements[static_cast<std::size_t>(e) * static_cast<std::size_t>(nodes)];
  const auto at = [](const double* field, int node) {
    return Eigen::Map<const Vector3d>(field + 3 * static_cast<std::ptrdiff_t>(node));
  };
  double place[3 * kMostNodes];
  body.gather_nodes(e, place);
  const Vector3d mesh_origin = Eigen::Map<const Vector3d>(body.mesh().nodes[0].data());
  Moments sum;
  // The mass times the four fields, at each node.
  Eigen::Matrix<double, 3, 4> weighted[kMostNodes];
  double mass[kMostNodes] = {};
  for (int i = 0; i < nodes; ++i) weighted[i].setZero();
  Eigen::Matrix<double, 3, 4> field[kMostNodes];
  for (int i = 0; i < nodes; ++i)
    field[i] << at(place, i) - mesh_origin, at(q, element[i]) - at(q, 0), at(v, element[i]),
        at(a, element[i]);
  body.for_each_mass(e, [&](int i, int j, double m) {
    weighted[i] += m * field[j];
    mass[i] += m;
    if (j == i) return;
    weighted[j] += m * field[i];
    mass[j] += m;
  });
  for (int i = 0; i < nodes; ++i) {
    const Vector3d x = field[i].col(1);
    sum.mass += mass[i];
    sum.mesh += weighted[i].col(0);
    sum.q += weighted[i].col(1);
    sum.v += weighted[i].col(2);
    sum.a += weighted[i].col(3);
    sum.q_mesh += x * weighted[i].col(0).transpose();
    sum.q_q += x * weighted[i].col(1).transpose();
    sum.q_v += x * weighted[i].col(2).transpose();
    sum.q_a += x * weighted[i].col(3).transpose();
  }
  return sum;
}

// The sum of x_i x y_i, from that of x_i y_i^T.
Vector3d cross_sum(const Matrix3d& product) {
  return {product(1, 2) - product(2, 1), product(2, 0) - product(0, 2), product(0, 1) - product(1, 0)};
}

Matrix3d inertia_of(const Matrix3d& second_moment) {
  return second_moment.trace() * Matrix3d::Identity() - second_moment;
}

Matrix3d nearest_rotation(const Matrix3d& moment) {
  const Eigen::JacobiSVD<Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

}  // namespace

BodyMotion body_motion(const SolidGroup& body, const double* q, const double* v, const double* a,
                       int threads) {
  const auto sum =
      sum_by_threads<Moments>(threads, body.size(), [&](int e) { return moments_of(body, e, q, v, a); });
  const double m = sum.mass;
  const Vector3d c = sum.q / m, mesh_c = sum.mesh / m, rate = sum.v / m, second = sum.a / m;
  const Matrix3d q_q = sum.q_q - m * c * c.transpose(), q_v = sum.q_v - m * c * rate.transpose();
  const Eigen::LDLT<Matrix3d> inertia(inertia_of(q_q));
  BodyMotion motion;
  motion.position = Eigen::Map<const Vector3d>(q) + c;
  motion.velocity = rate;
  motion.acceleration = second;
  motion.rotation = nearest_rotation(sum.q_mesh - m * c * mesh_c.transpose());
  motion.angular_velocity = inertia.solve(cross_sum(q_v));
  motion.angular_acceleration = inertia.solve(cross_sum(sum.q_a - m * c * second.transpose()) -
                                              inertia_of(q_v + q_v.transpose()) * motion.angular_velocity);
  return motion;
}

}  // namespace mfs::dae
