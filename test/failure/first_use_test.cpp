// The first use of the library in a process starts its engine (a thread, Kokkos). Each allocation on that way
// is made to fail in a process of its own.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "test/failure/counted_memory.hpp"
#include "test/failure/fresh_solver.hpp"

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

// This process itself must not touch the library: a forked one would miss the engine's thread.
TEST(FirstUse, EveryAllocationMayFail) {
  const SparseMatrix a = from_entries(1, {{0, 0, 2.0}});
  for (long n = 0;; ++n) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      alarm(20);  // a process that hangs ends by a signal
      std::_Exit(first_use(a, n));
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status)) << "allocation " << n << ", signal " << WTERMSIG(status);
    if (WEXITSTATUS(status) == nothing_failed) {
      EXPECT_GT(n, 20);
      break;
    }
    ASSERT_EQ(WEXITSTATUS(status), all_is_well) << "allocation " << n;
  }
}

}  // namespace
}  // namespace mfs::test
