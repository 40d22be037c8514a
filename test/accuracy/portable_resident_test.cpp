// Vectors, residuals and refinement of backend kokkos in the memory of its space: its code for devices, here
// with a space of the host, so that it is tested where there is no device.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "accuracy/factorization.hpp"
#include "accuracy/resident_refinement.hpp"
#include "kernels/portable/portable_factors_def.hpp"
#include "test/accuracy/probe_checks.hpp"
#include "test/stages/artificial_problem.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {
namespace {

template <class Value_, class Scalar_>
struct Numbers {
  using Value = Value_;
  using Scalar = Scalar_;
};
using AllNumbers =
    testing::Types<Numbers<double, double>, Numbers<std::complex<double>, std::complex<double>>,
                   Numbers<double, float>>;

template <class T>
class PortableResident : public testing::Test {
 protected:
  using Value = typename T::Value;
  using Made =
      portable::PortableFactors<Kokkos::Serial, Value, typename T::Scalar,
                                portable::OwnDense<DeviceScalar<typename T::Scalar>>, /*kResident=*/true>;

  PortableResident() : problem_(in_numbers_of<Value>(artificial_problem(leaf_and_root(150, 90), {3, 0.6}))) {}

  Vertex n() const { return problem_.plan->n; }
  /// Runs work(factors) with factors of the problem.
  template <class Work>
  void with_factors(const Work& work) {
    in_engine(1, [&] {
      auto factors =
          std::make_unique<Made>(problem_.plan, problem_.pattern, 1, Made::lists_for(*problem_.plan, 1));
      std::copy(problem_.values.begin(), problem_.values.end(), factors->matrix_values());
      std::copy(problem_.row_scale.begin(), problem_.row_scale.end(), factors->row_scale());
      std::copy(problem_.column_scale.begin(), problem_.column_scale.end(), factors->column_scale());
      factors->factor(1e-10, {});
      work(*factors);
    });
  }
  std::vector<Value> numbers(Offset count) const { return Random(5).vector<Value>(count); }

  /// Componentwise backward error of a column, by plain loops.
  double error_of(const Value* b, const Value* x, bool transposed, double floor = 0) const {
    std::vector<std::complex<double>> sum(static_cast<std::size_t>(n()));
    std::vector<double> size(sum.size());
    const Pattern& pattern = *problem_.pattern;
    double largest = 0;
    for (Vertex i = 0; i < n(); ++i) {
      sum[i] = std::complex<double>(b[i]);
      size[i] = std::abs(b[i]);
      largest =
          std::max(largest, std::abs(x[i]) / (transposed ? problem_.row_scale : problem_.column_scale)[i]);
    }
    for (Vertex i = 0; i < n(); ++i) {
      for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
        const Vertex j = pattern.columns[k], row = transposed ? j : i, column = transposed ? i : j;
        const auto product = std::complex<double>(problem_.values[k]) * std::complex<double>(x[column]);
        sum[row] -= product;
        size[row] += std::abs(product);
      }
    }
    double worst = 0;
    for (Vertex i = 0; i < n(); ++i) {
      size[i] += floor * largest / (transposed ? problem_.column_scale : problem_.row_scale)[i];
      worst = std::max(worst, std::abs(sum[i]) / size[i]);
    }
    return worst;
  }

  StageProblem<Value> problem_;
};
TYPED_TEST_SUITE(PortableResident, AllNumbers, );

constexpr double kGood = 1e-14;

// With gaps between the columns, which must stay as they are; by single precision factors only with
// refinement.
TYPED_TEST(PortableResident, SolvesForArraysOfTheSpace) {
  using Number = typename TypeParam::Value;
  constexpr bool kSingle = sizeof(typename TypeParam::Scalar) < sizeof(Number);
  this->with_factors([&](auto& factors) {
    const Offset n = this->n(), ldb = n + 3, ldx = n + 5;
    const TransposedPattern pattern = transpose(*this->problem_.pattern, 1);
    for (const Vertex columns : {1, 3, 16}) {
      for (const bool transposed : {false, true}) {
        SCOPED_TRACE(std::to_string(columns) + (transposed ? " transposed" : ""));
        const std::vector<Number> b = this->numbers(ldb * columns);
        std::vector<Number> x(static_cast<std::size_t>(ldx * columns), Number(7));
        ResidentFactors<Number>& resident = *factors.resident();
        resident.start({b.data(), ldb, x.data(), ldx, columns, transposed ? &pattern : nullptr}, 0, nullptr);
        SolveControls controls;
        controls.tolerance = kGood;
        bool improved = false;
        const SolveOutcome outcome = refine_resident(resident, controls, improved);
        EXPECT_TRUE(improved);
        EXPECT_GE(outcome.refinement_steps, kSingle ? 1 : 0);
        double worst = 0;
        for (Vertex j = 0; j < columns; ++j) {
          worst = std::max(worst, this->error_of(b.data() + j * ldb, x.data() + j * ldx, transposed));
          for (Offset i = n; i < ldx; ++i) EXPECT_EQ(x[static_cast<std::size_t>(j * ldx + i)], Number(7));
        }
        EXPECT_LE(worst, 1.01 * kGood);
        EXPECT_NEAR(outcome.backward_error, worst, 1e-15);
      }
    }
  });
}

TYPED_TEST(PortableResident, ProbesAsPlainLoopsDo) {
  constexpr bool kSingle = sizeof(typename TypeParam::Scalar) < sizeof(typename TypeParam::Value);
  this->with_factors([&](auto& factors) { expect_probes(this->problem_, factors, kSingle ? 1e3 : 1e9); });
}

TYPED_TEST(PortableResident, TakesStepsOfAProbeTogetherAsPlainLoopsDo) {
  constexpr bool kSingle = sizeof(typename TypeParam::Scalar) < sizeof(typename TypeParam::Value);
  this->with_factors([&](auto& factors) {
    factors.factor(PivotPolicy(20, TinyPivots::noise, 1e3), {});  // perturbs pivots
    expect_steps_together(this->problem_, factors, kSingle ? 1e-3 : 1e-6);
  });
}

TYPED_TEST(PortableResident, MeasuresWithAFloorAndKeepsWhatIsNotGoodEnough) {
  using Number = typename TypeParam::Value;
  this->with_factors([&](auto& factors) {
    const Vertex n = this->n();
    const std::vector<Number> b = this->numbers(n);
    std::vector<Number> x(b.size(), Number(7)), found(b.size());
    ResidentFactors<Number>& resident = *factors.resident();
    for (const double floor : {0.0, 0.5, 0.01}) {
      resident.start({b.data(), n, x.data(), n, 1, nullptr}, floor, nullptr);
      const double error = resident.backward_error(0);
      resident.bring_solution(found.data());
      EXPECT_NEAR(error, this->error_of(b.data(), found.data(), false, floor), 0.01 * error);
      const bool kept = x == std::vector<Number>(b.size(), Number(7));
      EXPECT_TRUE(kept || error == 0);
    }
    resident.start_from_host({b.data(), n, x.data(), n, 1, nullptr}, 0);
    resident.backward_error(1);
    EXPECT_EQ(x, found);
  });
}

TYPED_TEST(PortableResident, TakesValuesAndFindsThoseThatAreNone) {
  using Number = typename TypeParam::Value;
  this->with_factors([&](auto& factors) {
    std::vector<Number> values = this->problem_.values;
    for (Number& value : values) value *= RealOf<Number>(2);
    EXPECT_TRUE(factors.resident()->take_values(values.data(), nullptr));
    EXPECT_TRUE(std::equal(values.begin(), values.end(), factors.matrix().values));
    factors.factor(1e-10, {});
    const std::vector<Number> b = this->numbers(this->n());
    std::vector<Number> x(b.size()), doubled(b);
    factors.apply_inverse(b.data(), x.data(), 1, false);
    for (Number& entry : x) entry *= RealOf<Number>(2);
    EXPECT_LT(this->error_of(b.data(), x.data(), false),
              sizeof(typename TypeParam::Scalar) > 4 ? 1e-8 : 1e-2);
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
      values.back() = Number(bad);
      EXPECT_FALSE(factors.resident()->take_values(values.data(), nullptr));
    }
  });
}

TYPED_TEST(PortableResident, CopiesColumns) {
  using Number = typename TypeParam::Value;
  this->with_factors([&](auto& factors) {
    const std::vector<Number> from = this->numbers(3 * 7);
    std::vector<Number> packed(3 * 5), spread(from.size(), Number(7));
    factors.resident()->download(from.data(), 7, 5, 3, packed.data(), nullptr);
    factors.resident()->upload(packed.data(), 5, 3, spread.data(), 7, nullptr);
    for (std::size_t i = 0; i < from.size(); ++i) EXPECT_EQ(spread[i], i % 7 < 5 ? from[i] : Number(7));
  });
}

}  // namespace
}  // namespace mfs::test
