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

struct InertiaAndWeight {
  double mass;
  Eigen::Matrix3d inertia;
  Eigen::Vector3d gravity;

  template <class T>
  Triple<T> inertia_times(const Triple<T>& x) const {
    Triple<T> y;
    for (int i = 0; i < 3; ++i) y[i] = inertia(i, 0) * x[0] + inertia(i, 1) * x[1] + inertia(i, 2) * x[2];
    return y;
  }

  template <class T>
  void force(const T* q, const T* v, const T* a, T* f) const {
    for (int i = 0; i < 3; ++i) f[i] = mass * (a[i] - T(gravity[i]));
    const T *p = q + 3, *rate = v + 3;
    const Quadruple<T> inertial = g_transposed_times(p, inertia_times(g_times(p, a + 3)));
    const Quadruple<T> gyroscopic = g_transposed_times(rate, inertia_times(g_times(p, rate)));
    for (int i = 0; i < 4; ++i) f[3 + i] = 4.0 * inertial[i] + 8.0 * gyroscopic[i];
  }

  Energy energy(const double* q, const double* v) const {
    const Triple<double> half = g_times(q + 3, v + 3);  // of the angular velocity
    Energy energy;
    energy.kinetic = 2 * dot(half, inertia_times(half));
    for (int i = 0; i < 3; ++i) {
      energy.kinetic += 0.5 * mass * v[i] * v[i];
      energy.potential -= mass * gravity[i] * q[i];
    }
    return energy;
  }
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
  std::array<int, 7> coordinates;
  for (int k = 0; k < 7; ++k) coordinates[k] = frame.first + k;
  builder.add(std::make_shared<ForceElement<InertiaAndWeight, 7>>(
      "body " + body.name, coordinates, InertiaAndWeight{body.mass, body.inertia, gravity}));
  return frame;
}

}  // namespace mfs::dae
