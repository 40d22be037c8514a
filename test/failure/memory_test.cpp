// Memory that is not there: each allocation of each phase is made to fail once. And memory that must not be
// taken: none in a Newton step, and none for a plan that cannot fit.
#include <malloc.h>
#include <sys/resource.h>

#include <cstdio>
#include <numeric>
#include <string>

#include "test/failure/counted_memory.hpp"
#include "test/failure/fresh_solver.hpp"

namespace mfs::test {
namespace {

/// A matrix and the way to treat it.
struct Treatment {
  std::string name;
  SparseMatrix matrix;  // repeated entries allowed
  Options options;
  Rung rung = Rung::factors;  // to which a solve climbs
  bool delayed = false;       // pivots are, because they fail
};

/// Rows unsorted, with repeated entries: the longest way through the check. Weak diagonal: matched.
SparseMatrix awkward_matrix() {
  std::vector<Entry> entries;
  for (const Entry& e : entries_of(grid_2d(14, 13))) {
    entries.push_back({e.row, e.column, e.row == e.column ? 0.5 * e.value : e.value});
    if (e.row == e.column) entries.push_back({e.row, e.column, 0.5 * e.value});
  }
  for (Entry& e : entries) {
    if (e.row == e.column && e.row % 40 == 3) e.value = 0;
  }
  return from_entries(14 * 13, entries);
}

/// Each way that a factorization and a solve can take.
std::vector<Treatment> treatments() {
  std::vector<Treatment> all;
  all.push_back({"matched", awkward_matrix(), with_threads(1)});
  all.push_back({"matched, 2 threads", awkward_matrix(), with_threads(2)});
  for (const int threads : {1, 2})
    all.push_back({"diagonal blocks, " + std::to_string(threads) + " threads",
                   permuted_blocks({20, 3, 1, 40, 1, 1, 20}, 5), with_threads(threads)});
  Options unmatched = with_threads(2);
  unmatched.analysis.matching = Matching::never;
  Options delayed = unmatched;
  // Without a step of refinement the error is 5e-13 to 2e-12, by the kernels that the processor gets.
  delayed.solve.tolerance = 1e-14;
  all.push_back(
      {"pivots delayed", adversarial_matrix("saddle point renumbered", 1), delayed, Rung::refinement, true});
  unmatched.factor.max_reanalyses = 0;
  all.push_back(
      {"pivots corrected", adversarial_matrix("saddle point renumbered", 1), unmatched, Rung::refinement});
  Options mixed = with_threads(1);
  mixed.factor.precision = Precision::single;
  all.push_back({"single precision factors", grid_2d(14, 13), mixed, Rung::refinement});
  mixed.solve.max_refinement_steps = 2;
  all.push_back({"FGMRES", floating_chains(130, 9, true, 1e-7), mixed, Rung::krylov});
  mixed.solve.max_refinement_steps = 0;
  all.push_back({"single precision given up", grid_2d(14, 13), mixed, Rung::full_precision});
  return all;
}

void expect_rung(const Treatment& treatment) {
  Solver solver(treatment.options);
  solver.factor(treatment.matrix.view());
  const std::vector<double> b = right_hand_sides(treatment.matrix, 1, treatment.matrix.n, 1);
  std::vector<double> x(b.size());
  solver.solve(b.data(), x.data());
  EXPECT_EQ(solver.report().rung, treatment.rung) << "the way of this name is not taken";
  EXPECT_EQ(solver.report().reanalyses > 0, treatment.delayed) << "the way of this name is not taken";
}

/// Makes the n-th allocation of `operation` fail, for n = 0, 1, ... until it runs through. Each failure must
/// come out as OutOfMemory, must leak nothing, and must leave an object that still does its work.
template <class Prepare, class Operation>
void fail_every_allocation(const std::string& name, const Treatment& treatment, const Prepare& prepare,
                           const Operation& operation) {
  SCOPED_TRACE(name + ", " + treatment.name);
  const SparseMatrix& a = treatment.matrix;
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
  const auto attempt = [&](long fail_at) {
    Solver solver(treatment.options);
    prepare(solver, a);
    bool failed = false;
    start_counting(fail_at);
    try {
      operation(solver, a);
    } catch (const OutOfMemory& error) {
      stop_counting();
      failed = true;
      EXPECT_EQ(error.space(), MemorySpace::host);
    } catch (const std::exception& error) {
      stop_counting();
      failed = true;
      ADD_FAILURE() << "allocation " << fail_at << " gives " << error.what();
    }
    const long allocations = stop_counting();
    const bool reached = one_has_failed();
    EXPECT_TRUE(!failed || reached);
    solver.factor(a.view());
    std::vector<double> x(b.size());
    solver.solve(b.data(), x.data());
    EXPECT_LE(backward_error(a, b, x), kPromised) << "after allocation " << fail_at << " failed";
    return std::pair(reached, allocations);
  };
  expect_rung(treatment);
  const long allocations = attempt(-1).second;
  attempt(-1);
  const long before = live_blocks();
  long n = 0;
  auto last = attempt(n);
  while (last.first && !testing::Test::HasFailure()) last = attempt(++n);
  EXPECT_LE(last.second, n) << "an allocation was not reached";
  // Which thread takes which front decides how often the thread's own arrays grow.
  if (treatment.options.threads == 1) {
    EXPECT_LE(n, allocations);
  }
  EXPECT_LE(live_blocks() - before, 2) << "leaked";  // googletest's own notes
}

void nothing(Solver&, const SparseMatrix&) {}
void analysed(Solver& solver, const SparseMatrix& a) {
  solver.analyze(a.view());
}
void factored(Solver& solver, const SparseMatrix& a) {
  solver.factor(a.view());
}
void solve_with(Solver& solver, const SparseMatrix& a, std::int64_t nrhs, bool transpose) {
  static const std::vector<double> b = Random(3).vector(24000);
  static std::vector<double> x(24000);
  ASSERT_LE(nrhs * a.n, static_cast<std::int64_t>(b.size()));
  (solver.*(transpose ? &Solver::solve_transpose : &Solver::solve))(b.data(), x.data(), nrhs, a.n, a.n);
}

TEST(AllocationFailure, InEveryPhase) {
  for (const Treatment& treatment : treatments()) {
    fail_every_allocation("analyze", treatment, nothing,
                          [](Solver& s, const SparseMatrix& a) { s.analyze(a.view()); });
    fail_every_allocation("factor", treatment, analysed,
                          [](Solver& s, const SparseMatrix& a) { s.factor(a.view()); });
    fail_every_allocation("refactor", treatment, factored,
                          [](Solver& s, const SparseMatrix& a) { s.refactor(a.view()); });
    fail_every_allocation("solve", treatment, factored,
                          [](Solver& s, const SparseMatrix& a) { solve_with(s, a, 1, false); });
    fail_every_allocation("solve, 20 right-hand sides", treatment, factored,
                          [](Solver& s, const SparseMatrix& a) { solve_with(s, a, 20, false); });
    fail_every_allocation("solve_transpose", treatment, factored,
                          [](Solver& s, const SparseMatrix& a) { solve_with(s, a, 2, true); });
    const auto if_known = [](const auto& ask) {
      return [ask](Solver& solver, const SparseMatrix&) {
        try {
          ask(solver);
        } catch (const AccuracyNotReached&) {  // too many pivots were perturbed
        }
      };
    };
    fail_every_allocation("condition_estimate", treatment, factored,
                          if_known([](Solver& s) { s.condition_estimate(); }));
    fail_every_allocation("determinant", treatment, factored, if_known([](Solver& s) { s.determinant(); }));
  }
}

// A batch: a call fails as a whole, or tells of the systems for which there was no memory.
TEST(AllocationFailure, InBatches) {
  const SparseMatrix a = grid_2d(3, 4);
  std::vector<double> values, b = Random(2).vector(9 * a.n), x(b.size());
  for (int k = 0; k < 9; ++k) values.insert(values.end(), a.values.begin(), a.values.end());
  const Batch<double> batch{9, values.data(), 0, b.data(), x.data()};
  std::fill_n(values.begin() + 3 * a.entries(), a.entries(), 0.0);  // a system that is solved by itself
  const auto attempt = [&](bool analysis, long fail_at) {
    BatchSolver solver(with_threads(1));
    if (!analysis) solver.analyze(a.view());
    start_counting(fail_at);
    try {
      analysis ? solver.analyze(a.view()) : solver.solve(batch);
    } catch (const OutOfMemory&) {
    } catch (const std::exception& error) {
      stop_counting();
      ADD_FAILURE() << "allocation " << fail_at << " gives " << error.what();
    }
    stop_counting();
    const bool reached = one_has_failed();
    solver.analyze(a.view());
    solver.solve(batch);
    EXPECT_EQ(solver.failed(), 1);
    return reached;
  };
  for (const bool analysis : {true, false}) {
    long n = 0;
    while (attempt(analysis, n) && !testing::Test::HasFailure()) ++n;
    EXPECT_GT(n, 5);
  }
}

TEST(Allocation, NoneInTheSecondBatch) {
  const SparseMatrix a = grid_2d(12, 13);
  std::vector<double> values, b = Random(2).vector(20 * a.n), x(b.size());
  for (int k = 0; k < 10; ++k) values.insert(values.end(), a.values.begin(), a.values.end());
  BatchSolver solver(with_threads(1));
  solver.analyze(a.view());
  Batch<double> batch{10, values.data(), 0, b.data(), x.data(), 2};
  for (int call = 0; call < 3; ++call) {
    start_counting();
    solver.solve(batch);
    EXPECT_EQ(stop_counting() > 0, call == 0);
    EXPECT_EQ(solver.failed(), 0);
  }
}

TEST(AllocationFailure, WhereNoLargeBlockIsLeft) {
  const SparseMatrix a = grid_2d(70, 71);
  Solver solver(with_threads(2));
  solver.factor(a.view());
  expect_solves(solver, a);
  for (const std::size_t bytes : {16384, 100000, 1000000}) {
    Solver other(with_threads(2));
    fail_large_ones(bytes);
    bool failed = false;
    try {
      other.factor(a.view());
    } catch (const OutOfMemory&) {
      failed = true;
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
    stop_counting();
    EXPECT_TRUE(failed);
    other.factor(a.view());
    expect_solves(other, a);
  }
}

TEST(Allocation, TheLibraryUsesThisOperatorNew) {
  const SparseMatrix a = grid_2d(10, 10);
  Solver solver(with_threads(1));
  start_counting();
  solver.analyze(a.view());
  EXPECT_GT(stop_counting(), 20);
}

// A Newton step: refactor, solve. Large enough for the path with threads, and small.
TEST(Allocation, NoneInANewtonStep) {
  for (const SparseMatrix& a : {grid_2d(12, 13), grid_2d(130, 131)}) {
    for (const int threads : {1, 2}) {
      SCOPED_TRACE("n = " + std::to_string(a.n) + ", threads " + std::to_string(threads));
      Solver solver(with_threads(threads));
      const std::vector<std::int32_t> narrow(a.offsets.begin(), a.offsets.end());
      const CsrView<double> view{a.n, a.n, narrow.data(), a.columns.data(), a.values.data()};
      const std::vector<double> b = right_hand_sides(a, 16, a.n, 1);
      std::vector<double> x(b.size());
      const auto step = [&](std::int64_t nrhs) {
        solver.refactor(view);
        solver.refactor(a.values.data());
        solver.solve(b.data(), x.data(), nrhs);
        solver.solve_transpose(b.data(), x.data(), nrhs);
      };
      solver.factor(view);
      for (const std::int64_t nrhs : {1, 16}) {
        step(nrhs);
        start_counting();
        step(nrhs);
        step(nrhs);
        EXPECT_EQ(stop_counting(), 0) << nrhs << " right-hand sides";
      }
      start_counting();
      step(1);
      EXPECT_EQ(stop_counting(), 0) << "one again";
    }
  }
}

/// Lets all threads allocate from one heap. Otherwise a helper of the team gives 64 MB of addresses of its
/// own heap back when it likes, and a test cannot say how many addresses a limit leaves. The allocators of
/// sanitizers have no such heaps, and refuse.
struct OneHeap : ::testing::Environment {
  void SetUp() override { mallopt(M_ARENA_MAX, 1); }
};
const ::testing::Environment* const one_heap = ::testing::AddGlobalTestEnvironment(new OneHeap);

/// A tridiagonal matrix in one front of all its unknowns: n^2 entries.
Options one_front(std::int64_t n) {
  Options options = with_threads(1);
  options.analysis.permutation.resize(static_cast<std::size_t>(n));
  std::iota(options.analysis.permutation.begin(), options.analysis.permutation.end(), 0);
  options.analysis.tree = {{0, n}, {-1}};
  return options;
}

void expect_too_large(std::int64_t n, std::size_t at_most) {
  const SparseMatrix a = tridiagonal(n);
  Solver solver(one_front(n));
  const auto bytes = 8 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  if (const auto error = failure_of<OutOfMemory>([&] { solver.factor(a.view()); })) {
    EXPECT_EQ(error->space(), MemorySpace::host);
    EXPECT_GE(error->needed(), bytes);
    EXPECT_LT(error->needed(), bytes + bytes / 2);
    EXPECT_GT(error->available(), 0u);
    EXPECT_LE(error->available(), at_most);
  }
  EXPECT_TRUE(solver.analyzed());
  EXPECT_FALSE(solver.factored());
  EXPECT_GE(solver.report().bytes_peak, static_cast<std::int64_t>(bytes));
  failure_of<StateError>([&] { solver.refactor(a.values.data()); });
}

TEST(PlanTooLarge, ForTheMachine) {
  expect_too_large(2000000, std::size_t{1} << 44);
}  // 32 TB

TEST(PlanTooLarge, ForTheLimitOfTheProcess) {
  {
    Solver warm(with_threads(1));
    expect_usable(warm);
  }
  std::FILE* statm = std::fopen("/proc/self/statm", "r");
  ASSERT_NE(statm, nullptr);
  unsigned long pages = 0;
  ASSERT_EQ(std::fscanf(statm, "%lu", &pages), 1);
  std::fclose(statm);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  const rlimit tight{pages * 4096 + (std::size_t{256} << 20), before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
  expect_too_large(10000, std::size_t{256} << 20);  // 800 MB
  {
    Solver solver(with_threads(1));
    expect_usable(solver);  // small ones still fit
  }
  ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
}

}  // namespace
}  // namespace mfs::test
