// Amesos2::MFS with a matrix on the host whose later values are on a device.
#include <Amesos2_MFS.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include <mfs/mfs.hpp>

#include "perf/device_array.hpp"
#include "test/amesos2/systems.hpp"

namespace {

using namespace mfs::test;
using Solver = Amesos2::MFS<Matrix, Vector>;
using DeviceValues = mfs::perf::DeviceArray<double>;

class DeviceValuesTest : public testing::Test {
 protected:
  void SetUp() override {
    const std::vector<mfs::Backend> usable = mfs::backends();
    if (std::count(usable.begin(), usable.end(), mfs::Backend::cuda) == 0) GTEST_SKIP() << "no CUDA device";
    solver_->setParameters(amesos2_parameters([](auto& list) { list.set("Backend", "cuda"); }));
  }

  std::vector<double> values() const {
    const auto local = a_->getLocalMatrixHost().values;
    return {local.data(), local.data() + local.extent(0)};
  }
  /// Distance of the solution from `factor` times the one of the matrix itself.
  double distance(double factor) {
    const auto b = image(*a_);
    b->scale(factor);
    const auto x = rcp(new Vector(a_->getDomainMap(), 1));
    solver_->solve(x.ptr(), b.ptr().getConst());
    return distance_from_samples(*x);
  }

  const RCP<Matrix> a_ = assemble(grid_entries(40, 30), even_map(1200));
  const RCP<Solver> solver_ = rcp(new Solver(a_, Teuchos::null, Teuchos::null));
};

constexpr double kSmall = 1e-12;

TEST_F(DeviceValuesTest, AreTakenOnceAndThenTheMatrixAgain) {
  EXPECT_FALSE(solver_->takesDeviceValues());
  EXPECT_THROW(solver_->setDeviceValues(nullptr), mfs::StateError);
  solver_->symbolicFactorization().numericFactorization();
  EXPECT_LT(distance(1.0), kSmall);
  EXPECT_THROW(solver_->setDeviceValues(nullptr), mfs::InvalidInput);
  for (const double factor : {2.0, -0.5}) {
    std::vector<double> scaled = values();
    for (double& value : scaled) value *= factor;
    const DeviceValues on_device(scaled);
    ASSERT_TRUE(solver_->takesDeviceValues());
    solver_->setDeviceValues(on_device.get());
    solver_->numericFactorization();
    EXPECT_LT(distance(factor), kSmall) << factor;
  }
  solver_->numericFactorization();
  EXPECT_LT(distance(1.0), kSmall);
}

TEST_F(DeviceValuesTest, ThatAreNoNumbersAreRefusedWithTheirPlace) {
  solver_->symbolicFactorization().numericFactorization();
  const int row = 77, place = static_cast<int>(a_->getLocalMatrixHost().graph.row_map(row));
  std::vector<double> wrong = values();
  wrong[place] = std::numeric_limits<double>::quiet_NaN();
  const DeviceValues on_device(wrong);
  solver_->setDeviceValues(on_device.get());
  try {
    solver_->numericFactorization();
    FAIL() << "taken";
  } catch (const mfs::InvalidInput& e) {
    EXPECT_EQ(e.row(), row);
  }
  EXPECT_THROW(distance(1.0), mfs::StateError);
  solver_->numericFactorization();  // of the matrix itself
  EXPECT_LT(distance(1.0), kSmall);
}

TEST_F(DeviceValuesTest, RightHandSidesAndSolutionsMayLieThereToo) {
  const auto b = image(*a_), x = rcp(new Vector(a_->getDomainMap(), 1));
  const DeviceValues right_side(std::vector<double>(b->getData(0).begin(), b->getData(0).end()));
  const DeviceValues solution(b->getLocalLength());
  EXPECT_THROW(solver_->solveDevice(right_side.get(), solution.get()), mfs::StateError);
  solver_->symbolicFactorization().numericFactorization();
  solver_->solveDevice(right_side.get(), solution.get());
  double* const on_host = x->getDataNonConst(0).getRawPtr();
  ASSERT_EQ(cudaMemcpy(on_host, solution.get(), x->getLocalLength() * sizeof(double), cudaMemcpyDeviceToHost),
            cudaSuccess);
  EXPECT_LT(distance_from_samples(*x), kSmall);
  EXPECT_THROW(solver_->solveDevice(nullptr, solution.get()), mfs::InvalidInput);
}

TEST_F(DeviceValuesTest, AreForgottenWithTheMatrix) {
  solver_->symbolicFactorization().numericFactorization();
  const DeviceValues on_device(std::vector<double>(values().size(), 1.0));
  solver_->setDeviceValues(on_device.get());
  solver_->setA(a_);
  solver_->symbolicFactorization().numericFactorization();
  EXPECT_LT(distance(1.0), kSmall);
}

}  // namespace
