// The probe of the factors on a CUDA device.
#include <complex>

#include "test/accuracy/probe_checks.hpp"
#include "test/stages/device_checks.hpp"
#include "test/stages/on_device.hpp"

namespace mfs::test {
namespace {

template <class Scalar>
class DeviceProbe : public OnDeviceTest {};
using Scalars = testing::Types<double, std::complex<double>>;
TYPED_TEST_SUITE(DeviceProbe, Scalars);

TYPED_TEST(DeviceProbe, FindsWhatPlainLoopsFind) {
  this->on_device([&] {
    for (const bool single : {false, true}) {
      SCOPED_TRACE(single ? "factors of single precision" : "");
      const auto problem = turned<TypeParam>(artificial_problem(leaf_and_root(150, 90), {3, 0.6}));
      const auto factors =
          cuda::plan_cuda_factors<TypeParam>(single, problem.plan, problem.pattern, {0, 0}).make();
      fill(problem, *factors);
      factors->factor(1e-10, {});
      expect_probes(problem, *factors, single ? 1e3 : 1e9);
      factors->factor(PivotPolicy(20, TinyPivots::noise, 1e3), {});  // perturbs pivots
      expect_steps_together(problem, *factors, single ? 1e-3 : 1e-6);
    }
  });
}

}  // namespace
}  // namespace mfs::test
