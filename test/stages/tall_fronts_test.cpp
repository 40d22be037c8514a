// Tall fronts whose pivots are searched in all rows, on the device (kernels/cuda/factor/strict_panel.hpp).
#include <string>

#include "test/stages/device_checks.hpp"
#include "test/stages/on_device.hpp"
#include "test/stages/weak_pivots.hpp"

namespace mfs::test {
namespace {

/// With tall fronts beside others, as roots and below them.
std::vector<StageProblem<double>> tall_fronts() {
  return {
      artificial_problem({{129, 0, -1}}, {30}),
      artificial_problem({{257, 0, -1}}, {31}),
      artificial_problem(leaf_and_root(200, 33), {36, 0.7}),
      artificial_problem(leaf_and_root(300, 270), {32}),
      artificial_problem(leaf_and_root(513, 1), {33, 0.7}),
      artificial_problem({{40, 200, 4}, {300, 90, 4}, {200, 33, 4}, {391, 310, 4}, {400, 0, -1}}, {34, 0.6}),
      artificial_problem({{700, 65, 1}, {80, 0, -1}}, {35, 1.0, 64, {}, 0.97}),
      zero_pivot_block(300, 1, 64, 100.0),
      zero_pivot_block(300, 70, 64, 100.0),
      low_rank_pivot_block(36, 330, 200, 130, 64, 100.0),
      pivots_below_the_tile(600, 128, 1e-3)};
}

template <class Scalar>
class TallFrontsTest : public OnDeviceTest {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(TallFrontsTest, Scalars);

// By launches for each panel, which is wide, narrow or in the memory of the device, or as a whole.
TYPED_TEST(TallFrontsTest, AreFactoredByPanelsToTheSameBits) {
  using Search = cuda::PivotSearch;
  this->on_device([&] {
    for (const StageProblem<double>& of_doubles : tall_fronts()) {
      const StageProblem<TypeParam> problem = turned<TypeParam>(of_doubles);
      SCOPED_TRACE(std::to_string(problem.plan->n) + " unknowns");
      const double tolerance = default_tolerance<TypeParam>();
      for (const PivotPolicy& policy :
           {PivotPolicy(tolerance), PivotPolicy(tolerance, TinyPivots::data, kBorderThreshold)}) {
        DeviceBench<TypeParam> whole(problem);
        whole.make_all_strict(Search::strict);
        const FactorStatus expected = whole.factor(policy);
        EXPECT_EQ(whole.passes(), 1);
        if (expected.perturbed == 0 && !policy.substitutes())
          expect_reference(problem, whole, followed(problem, whole, tolerance));
        for (const Vertex entries : {5000, 1 << 20, 0}) {
          SCOPED_TRACE(std::to_string(entries) + " entries of a panel");
          auto panels = DeviceBench<TypeParam>::with_panels(problem, entries);
          for (const Launches launches : {Launches::direct, Launches::recorded}) {
            panels.make_all_strict(Search::strict_by_panels);
            EXPECT_EQ(panels.factor(policy, launches).perturbed, expected.perturbed);
            expect_same_bits(panels.as_left(), whole.as_left());
          }
        }
        if (this->HasFailure()) return;
      }
    }
  });
}

}  // namespace
}  // namespace mfs::test
