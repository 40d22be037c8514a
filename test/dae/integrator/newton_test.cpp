// How many corrections and Jacobians the steps of a body that turns take.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dae/integrator/independent_constraints.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/turning_bodies.hpp"
#include "test/dae/integrator/dense_system.hpp"

namespace mfs::dae::test {
namespace {

/// A point of 1 kg that turns about the origin, held at a distance of 1 m by a damped spring.
struct TurningPoint {
  double speed = 30.0, stiffness = 1e6, damping = 1e3;
  int coordinates() const { return 2; }
  int constraints() const { return 0; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    using std::sqrt;
    const T r = sqrt(q[0] * q[0] + q[1] * q[1]), x = q[0] / r, y = q[1] / r;
    const T pull = stiffness * (r - 1.0) + speed * speed + damping * (x * v[0] + y * v[1]);
    return {T(a[0] + pull * x), T(a[1] + pull * y)};
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& /*q*/) const {
    return {};
  }
};

/// The integrator takes it for a mesh.
class Mesh : public DenseSystem<TurningPoint>, public TurningBodies {
 public:
  using DenseSystem<TurningPoint>::DenseSystem;
  std::vector<PointRange> turning_bodies() const override { return {{0, 1}}; }
};

IntegrationReport turn(const ConstrainedSystem& system, double speed) {
  IntegratorOptions options;
  options.rtol = 1e-6;
  options.threads = 1;
  options.backend = Backend::serial;
  Integrator integrator(system, options);
  Observer nobody;
  integrator.run(0.0, {1.0, 0.0}, {0.0, speed}, 1.0, {}, nobody);
  return integrator.report();
}

// A kept Jacobian is no good after some 0.1 rad. Where searches began with it all the same they took 3.8
// corrections a step.
TEST(Newton, SearchesOfMeshesDoNotBeginWithAJacobianThatIsTooOld) {
  const TurningPoint point{30.0, 1e8, 1e5};
  const IntegrationReport report = turn(Mesh(point), point.speed);
  EXPECT_LT(report.newton_iterations, 3.2 * report.steps);
  EXPECT_LT(report.jacobians, report.steps);
}

// Searches are those of the system without what is redundant.
TEST(Newton, MeshesAreKnownAsSuchWithoutRedundantConstraints) {
  const Mesh mesh(TurningPoint{});
  EXPECT_EQ(turning_bodies_of(IndependentConstraints(mesh, {})).size(), 1u);
}

}  // namespace
}  // namespace mfs::dae::test
