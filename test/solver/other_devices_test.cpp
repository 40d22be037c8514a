// A process uses one device, that of the caller who needs it first. Needs two devices; skips where there are
// fewer. One test, as a process cannot begin anew.
#include <thread>

#include "perf/device_array.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::test {
namespace {

using perf::check;
using perf::DeviceArray;

void make_current(int device) {
  check(cudaSetDevice(device), "cudaSetDevice");
}

std::size_t free_bytes() {
  std::size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return free;
}

using OtherDevices = OnDevice;

TEST_F(OtherDevices, TheOneOfTheFirstCallerServesAll) {
  int count = 0;
  check(cudaGetDeviceCount(&count), "cudaGetDeviceCount");
  if (count < 2) GTEST_SKIP() << "one device";
  const int mine = count - 1, other = 0;
  const SparseMatrix a = grid_2d(300, 290);
  const std::vector<double> b = right_hand_sides(a, 2, a.n, 3);
  std::vector<double> x(b.size()), by_another(b.size());
  make_current(mine);
  const std::size_t free_before = free_bytes();
  Solver solver(options_);
  solver.factor(a.view());
  EXPECT_GE(free_before - free_bytes(), static_cast<std::size_t>(solver.report().bytes_used));
  {
    const DeviceArray<double> values(a.values), there(b), solution(b);
    solver.refactor_device(values.get());
    solver.solve_device(there.get(), solution.get(), 2);
    check(cudaMemcpy(x.data(), solution.get(), x.size() * sizeof(double), cudaMemcpyDeviceToHost), "copy");
    EXPECT_LE(worst_error(a, b, a.n, x, a.n, 2), kPromised);
  }

  // A thread begins with the first device; the factors stay where they are, also where they are made anew.
  Solver changed(options_);
  changed.factor(circulant(4).view());
  const SparseMatrix weak = circulant(0);
  std::thread([&] {
    solver.refactor(a.values.data());
    solver.solve(b.data(), by_another.data(), 2);
    const std::vector<double> right = right_hand_sides(weak, 1, weak.n, 5);
    std::vector<double> found(right.size());
    changed.refactor(weak.values.data());
    changed.solve(right.data(), found.data());
    EXPECT_LE(worst_error(weak, right, weak.n, found, weak.n, 1), kPromised);
  }).join();
  EXPECT_EQ(by_another, x);
  EXPECT_EQ(changed.report().rung, Rung::reanalysis) << "the test needs factors that are made anew";

  make_current(other);
  const DeviceArray<double> values(a.values), there(b), solution(b);
  expect_invalid([&] { solver.refactor_device(values.get()); }, "values");
  expect_invalid([&] { solver.solve_device(there.get(), solution.get()); }, "b");
  const auto error = failure_of<BackendError>([&] { Solver refused(options_); });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), testing::HasSubstr("device " + std::to_string(mine)));
  make_current(mine);
  Solver second(options_);
  second.factor(a.view());
  second.solve(b.data(), by_another.data(), 2);
  EXPECT_EQ(by_another, x);
}

}  // namespace
}  // namespace mfs::test
