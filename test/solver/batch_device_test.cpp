// Batches whose arrays lie in the memory of the device. Needs a device; skips where there is none.
#include <algorithm>
#include <chrono>
#include <thread>

#include "perf/device_array.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/solver/batches.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::test {
namespace {

using perf::check;
using perf::DeviceArray;

/// The arrays of a batch on the device, with the gaps that they have on the host.
template <class Scalar>
struct OnTheDevice {
  explicit OnTheDevice(const Systems<Scalar>& all)
      : values(all.values), b(all.b), x(all.x), batch(all.batch) {
    batch.values = values.get();
    batch.b = b.get();
    batch.x = x.get();
  }
  std::vector<Scalar> solutions(std::size_t count) const {
    std::vector<Scalar> found(count);
    check(cudaMemcpy(found.data(), x.get(), count * sizeof(Scalar), cudaMemcpyDeviceToHost), "cudaMemcpy");
    return found;
  }
  DeviceArray<Scalar> values, b, x;
  Batch<Scalar> batch;
};

template <class Scalar>
class DeviceBatches : public OnDevice {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(DeviceBatches, Scalars);

TYPED_TEST(DeviceBatches, AreSolvedThere) {
  using Scalar = TypeParam;
  for (const Backend backend : {Backend::cuda, Backend::kokkos}) {
    this->options_.backend = backend;
    for (const std::int64_t count : {1, 31, 33, 500}) {
      for (const std::int64_t nrhs : {1, 3}) {
        Systems<Scalar> all(grid_2d(12, 9), count, nrhs, 2);
        BasicBatchSolver<Scalar> solver(this->options_);
        solver.analyze(in_scalar<Scalar>(grid_2d(12, 9)).view());
        OnTheDevice<Scalar> there(all);
        solver.solve_device(there.batch);
        EXPECT_EQ(solver.failed(), 0);
        solver.solve(all.batch);
        EXPECT_EQ(solver.failed(), 0);
        for (std::int64_t k = 0; k < count; ++k) ASSERT_LE(all.error_of(k), kPromisedFor<Scalar>) << k;
        EXPECT_TRUE(same_bits(there.solutions(all.x.size()), all.x))
            << "by the device's arrays and by copies";
      }
    }
  }
}

using DeviceBatch = OnDevice;

TEST_F(DeviceBatch, SystemsThatFailAreLeftToTheHost) {
  for (const std::int64_t gap : {0, 1}) {
    Systems<double> all(grid_2d(9, 8), 40, 2, gap), good(grid_2d(9, 8), 40, 2, gap);
    spoil(all);
    BatchSolver solver(options_);
    solver.analyze(good.matrices[0].view());
    OnTheDevice<double> spoilt(all), well(good);
    solver.solve_device(well.batch);
    EXPECT_EQ(solver.failed(), 0);
    solver.solve_device(spoilt.batch);
    const std::vector<double> found = spoilt.solutions(all.x.size()), expected = well.solutions(all.x.size());
    for (std::int64_t k = 0; k < 40; ++k) {
      SCOPED_TRACE(k);
      const SystemStatus status = solver.systems()[static_cast<std::size_t>(k)].status;
      const bool bad = k % 5 == 1 || k % 5 == 2 || k == 9;
      EXPECT_EQ(status, k % 5 == 1 ? SystemStatus::singular
                        : bad      ? SystemStatus::invalid_input
                                   : SystemStatus::solved);
      std::copy(found.begin() + k * all.batch.x_stride, found.begin() + (k + 1) * all.batch.x_stride,
                all.x.begin() + k * all.batch.x_stride);
      EXPECT_EQ(all.untouched(k), bad);
      EXPECT_TRUE(bad || all.error_of(k) <= kPromised);
      if (k % 5 != 0 || k == 0) continue;
      EXPECT_EQ(std::memcmp(found.data() + k * all.batch.x_stride, expected.data() + k * all.batch.x_stride,
                            72 * sizeof(double)),
                0);
    }
  }
}

// Without values in the analysis, and where fronts are large, nothing is for lanes.
TEST_F(DeviceBatch, TheHostServesWhatLanesDoNot) {
  for (const bool values : {false, true}) {
    const SparseMatrix pattern = values ? random_diagonally_dominant(300, 30, 2) : grid_2d(9, 8);
    Systems<double> all(pattern, 9, 2, 1);
    CsrView<double> view = all.matrices[0].view();
    if (!values) view.values = nullptr;
    BatchSolver solver(options_);
    solver.analyze(view);
    OnTheDevice<double> there(all);
    solver.solve_device(there.batch);
    EXPECT_EQ(solver.failed(), 0);
    all.x = there.solutions(all.x.size());
    for (std::int64_t k = 0; k < 9; ++k) EXPECT_LE(all.error_of(k), kPromised);
  }
}

TEST_F(DeviceBatch, IsSolvedInPartsWhereMemoryIsShort) {
  Systems<double> all(grid_2d(12, 9), 300, 1, 0);
  std::vector<double> first;
  for (const std::int64_t limit : {0, 3000000, 1000}) {
    options_.memory_limit = limit;
    BatchSolver solver(options_);
    solver.analyze(all.matrices[0].view());
    OnTheDevice<double> there(all);
    if (limit == 1000) {
      failure_of<OutOfMemory>([&] { solver.solve_device(there.batch); });
      continue;
    }
    solver.solve_device(there.batch);
    EXPECT_EQ(solver.failed(), 0);
    const std::vector<double> found = there.solutions(all.x.size());
    if (first.empty()) first = found;
    EXPECT_TRUE(same_bits(first, found));
  }
}

TEST_F(DeviceBatch, WaitsForTheStreamOfTheCaller) {
  Systems<double> all(grid_2d(12, 9), 64, 1, 0);
  BatchSolver solver(options_);
  solver.analyze(all.matrices[0].view());
  OnTheDevice<double> there(all);
  solver.solve_device(there.batch);
  const DeviceArray<double> values(all.values);
  check(cudaMemset(there.values.get(), 0xff, all.values.size() * sizeof(double)), "cudaMemset");
  cudaStream_t stream = nullptr;
  check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "cudaStreamCreate");
  const auto sleep = [](void*) { std::this_thread::sleep_for(std::chrono::milliseconds(30)); };
  check(cudaLaunchHostFunc(stream, sleep, nullptr), "cudaLaunchHostFunc");
  check(cudaMemcpyAsync(there.values.get(), values.get(), all.values.size() * sizeof(double),
                        cudaMemcpyDeviceToDevice, stream),
        "cudaMemcpyAsync");
  solver.solve_device(there.batch, stream);
  EXPECT_EQ(solver.failed(), 0);
  check(cudaStreamDestroy(stream), "cudaStreamDestroy");
}

}  // namespace
}  // namespace mfs::test
