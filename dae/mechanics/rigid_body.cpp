#include "dae/mechanics/rigid_body.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>

#include <mfs/error.hpp>

#include "dae/mechanics/number_text.hpp"
#include "dae/mechanics/rotation.hpp"
#include "dae/mechanics/single_element.hpp"

namespace mfs::dae {
namespace {

using Vector4 = Eigen::Matrix<double, 4, 1>;
using Matrix34 = Eigen::Matrix<double, 3, 4>;

/// G(p), linear in p; G(p) x = -G(x) p.
Matrix34 g_matrix(const double* p) {
  Matrix34 g;
  g << -p[1], p[0], p[3], -p[2],  //
      -p[2], -p[3], p[0], p[1],   //
      -p[3], p[2], -p[1], p[0];
  return g;
}

/// d(G(p)^T y)/dp.
Eigen::Matrix4d g_transposed_by_p(const Eigen::Vector3d& y) {
  Eigen::Matrix4d by_p;
  by_p << 0.0, -y[0], -y[1], -y[2],  //
      y[0], 0.0, y[2], -y[1],        //
      y[1], -y[2], 0.0, y[0],        //
      y[2], y[1], -y[0], 0.0;
  return by_p;
}

class InertiaAndWeight final : public SingleElement<7> {
 public:
  InertiaAndWeight(const RigidBody& body, const std::array<int, 7>& coordinates,
                   const Eigen::Vector3d& gravity)
      : SingleElement<7>("body " + body.name, coordinates),
        mass_(body.mass),
        inertia_(body.inertia),
        gravity_(gravity) {}

  LocalStructure structure() const override {
    using Kind = LocalStructure::Kind;
    return {Kind::dense, Kind::dense, Kind::dense, false, false};
  }

  void residual(int, const LocalState& state, LocalResidual& residual) const override {
    for (int i = 0; i < 3; ++i) residual.force[i] = mass_ * (state.a[i] - gravity_[i]);
    const Euler of(state);
    Eigen::Map<Vector4>(residual.force + 3) = 4.0 * of.g.transpose() * (inertia_ * (of.g * of.a)) +
                                              8.0 * of.g_rate.transpose() * (inertia_ * (of.g * of.v));
  }

  void tangent(int, const LocalState& state, LocalTangent& tangent) const override {
    const Euler of(state);
    const Eigen::Vector3d spin = inertia_ * (of.g * of.v);
    const Matrix34 by_p = inertia_ * of.g, by_rate = inertia_ * of.g_rate;
    const auto turning = [](double* block) {
      return Eigen::Map<Eigen::Matrix<double, 7, 7, Eigen::RowMajor>>(block).bottomRightCorner<4, 4>();
    };
    turning(tangent.force_q) = 4.0 * (g_transposed_by_p(inertia_ * (of.g * of.a)) -
                                      of.g.transpose() * inertia_ * g_matrix(of.a.data())) -
                               8.0 * of.g_rate.transpose() * by_rate;
    turning(tangent.force_v) = 8.0 * (g_transposed_by_p(spin) + of.g_rate.transpose() * by_p);
    turning(tangent.force_a) = 4.0 * of.g.transpose() * by_p;
    for (int i = 0; i < 3; ++i) tangent.force_a[8 * i] = mass_;
  }

  Energy energy(int, const LocalState& state) const override {
    const Euler of(state);
    const Eigen::Vector3d half = of.g * of.v;  // of the angular velocity
    Energy energy;
    energy.kinetic = 2 * half.dot(inertia_ * half);
    for (int i = 0; i < 3; ++i) {
      energy.kinetic += 0.5 * mass_ * state.v[i] * state.v[i];
      energy.potential -= mass_ * gravity_[i] * state.q[i];
    }
    return energy;
  }
  Power power(int, const LocalState&) const override { return {}; }

 private:
  /// G(p), G(p'), and p's derivatives.
  struct Euler {
    Matrix34 g, g_rate;
    Eigen::Map<const Vector4> v, a;
    explicit Euler(const LocalState& state)
        : g(g_matrix(state.q + 3)), g_rate(g_matrix(state.v + 3)), v(state.v + 3), a(state.a + 3) {}
  };

  double mass_;
  Eigen::Matrix3d inertia_;
  Eigen::Vector3d gravity_;
};

void check(const RigidBody& body) {
  const std::string owner = "body " + body.name;
  if (!(body.mass > 0) || !std::isfinite(body.mass)) throw InvalidInput(owner, "its mass is not positive");
  if (!body.inertia.allFinite()) throw InvalidInput(owner, "its inertia tensor is not finite");
  const double size = body.inertia.cwiseAbs().maxCoeff();
  if ((body.inertia - body.inertia.transpose()).cwiseAbs().maxCoeff() > 1e-12 * size)
    throw InvalidInput(owner, "its inertia tensor is not symmetric");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(body.inertia, Eigen::EigenvaluesOnly);
  if (!(principal.eigenvalues()[0] > 1e-14 * size))
    throw InvalidInput(owner, "its inertia tensor is not positive definite");
  // Any distribution of mass has J1 + J2 - J3 = 2 int x3^2 dm >= 0; measured tensors are rounded.
  constexpr double kRounding = 0.01;
  const double largest = principal.eigenvalues()[2], others = principal.eigenvalues().sum() - largest;
  if (largest > (1 + kRounding) * others)
    throw InvalidInput(owner, "no body has its inertia tensor: the largest principal moment, " +
                                  number_text(largest) + " kg m^2, is more than the sum of the others, " +
                                  number_text(others));
}

}  // namespace

Frame add_rigid_body(MultibodyBuilder& builder, const RigidBody& body, const Eigen::Vector3d& gravity) {
  check(body);
  Frame frame = add_frame(builder, body.name, body.placement);
  builder.note_length(frame.first, std::sqrt(body.inertia.diagonal().maxCoeff() / body.mass));
  std::array<int, 7> coordinates;
  for (int k = 0; k < 7; ++k) coordinates[k] = frame.first + k;
  builder.add(std::make_shared<InertiaAndWeight>(body, coordinates, gravity));
  return frame;
}

}  // namespace mfs::dae
