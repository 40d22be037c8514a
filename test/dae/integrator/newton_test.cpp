// How many corrections and Jacobians the steps of a body that turns take.
#include <gtest/gtest.h>

#include <vector>

#include "dae/integrator/independent_constraints.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/turning_bodies.hpp"
#include "test/dae/integrator/dense_system.hpp"
#include "test/dae/integrator/turning_point.hpp"

namespace mfs::dae::test {
namespace {

/// The integrator takes it for a mesh.
class Mesh : public DenseSystem<TurningPoint>, public TurningBodies {
 public:
  using DenseSystem<TurningPoint>::DenseSystem;
  std::vector<PointRange> turning_bodies() const override { return {{0, 1}}; }
};

IntegrationReport turn(const ConstrainedSystem& system) {
  IntegratorOptions options;
  options.rtol = 1e-6;
  options.threads = 1;
  options.backend = Backend::serial;
  Integrator integrator(system, options);
  Observer nobody;
  integrator.run(0.0, {1.0, 0.0}, {0.0, TurningPoint::kSpeed}, 1.0, {}, nobody);
  return integrator.report();
}

// A kept Jacobian is no good after some 0.1 rad. Where searches began with it all the same they took 3.8
// corrections a step.
TEST(Newton, SearchesOfMeshesDoNotBeginWithAJacobianThatIsTooOld) {
  const IntegrationReport report = turn(Mesh(TurningPoint{1e8, 1e5}));
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
