// The first use of the library in a process starts its engine (a thread, Kokkos). Each allocation on that
// way, and the thread, are made to fail in a process of their own. This one must not touch the library, or
// theirs would not be the first use.
#include "test/failure/counted_memory.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/failure/new_process.hpp"
#include "test/failure/refused_threads.hpp"

namespace mfs::test {
namespace {

enum Outcome { all_is_well = 0, nothing_failed = 10, wrong_error = 11, not_usable = 12 };

/// What a process says whose very first call of the solver loses its n-th allocation.
Outcome first_use(const SparseMatrix& a, long fail_at) {
  start_counting(fail_at);
  try {
    Solver solver(with_threads(1));
    solver.factor(a.view());
  } catch (const OutOfMemory&) {  // or nothing, where an allocation can be done without
  } catch (...) {
    return wrong_error;
  }
  stop_counting();
  if (!one_has_failed()) return nothing_failed;
  try {
    Solver solver(with_threads(1));
    solver.factor(a.view());
    const std::vector<double> b = multiply(a, std::vector<double>(a.n, 1.0));
    std::vector<double> x(b.size());
    solver.solve(b.data(), x.data());
    return backward_error(a, b, x) <= kPromised ? all_is_well : not_usable;
  } catch (...) {
    return not_usable;
  }
}

TEST(FirstUse, EveryAllocationMayFail) {
  const SparseMatrix a = from_entries(1, {{0, 0, 2.0}});
  for (long n = 0;; ++n) {
    const int outcome = in_new_process([&] { return first_use(a, n); });
    if (outcome == nothing_failed) {
      EXPECT_GT(n, 20);
      break;
    }
    ASSERT_EQ(outcome, all_is_well) << "allocation " << n;
  }
}

TEST(FirstUse, TheEngineMayGetNoThread) {
  const SparseMatrix a = grid_2d(3, 3);
  EXPECT_EQ(in_new_process([&] {
              {
                const RefusedThreads none;
                failure_of<BackendError>([&] { Solver(with_threads(1)).factor(a.view()); });
              }
              Solver solver(with_threads(1));
              expect_usable(solver);
              return testing::Test::HasFailure() ? 1 : 0;
            }),
            0);
}

}  // namespace
}  // namespace mfs::test
