// Solvers of several threads work at the same time, and each as if it were alone. That they do is seen where
// they call BLAS: whoever comes there first waits for the other.
#include <dlfcn.h>

#include <cfenv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

#include "test/failure/fresh_solver.hpp"

namespace {

/// Threads wait in arrive() until `awaited` of them have been there, or for good if they do not come.
class MeetingPoint {
 public:
  void expect(std::size_t threads) {
    const std::lock_guard<std::mutex> lock(mutex_);
    awaited_ = threads;
    came_.clear();
    missed_ = false;
  }
  void arrive() {
    std::unique_lock<std::mutex> lock(mutex_);
    if (awaited_ == 0 || missed_) return;
    came_.insert(std::this_thread::get_id());
    changed_.notify_all();
    // Long enough for any machine; only a failing test takes it.
    if (!changed_.wait_for(lock, std::chrono::seconds(240), [this] { return came_.size() >= awaited_; }))
      missed_ = true;
  }
  bool met() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !missed_ && came_.size() >= awaited_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t awaited_ = 0;
  std::set<std::thread::id> came_;
  bool missed_ = false;
};

MeetingPoint in_blas;

}  // namespace

// It stands before that of BLAS: the program exports it.
extern "C" void dgemm_(const char* ta, const char* tb, const int* m, const int* n, const int* k,
                       const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
                       const double* beta, double* c, const int* ldc) {
  static auto* const blas = reinterpret_cast<decltype(&dgemm_)>(dlsym(RTLD_NEXT, "dgemm_"));
  in_blas.arrive();
  blas(ta, tb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc);
}

namespace mfs::test {
namespace {

Options options_of(Backend backend, int threads) {
  Options options = with_threads(threads);
  options.backend = backend;
  return options;
}

template <class Work>
void in_threads(int count, const Work& work) {
  std::vector<std::thread> threads;
  for (int t = 0; t < count; ++t) threads.emplace_back([&work, t] { work(t); });
  for (std::thread& thread : threads) thread.join();
}

void expect_to_meet(const std::vector<Options>& all, const SparseMatrix& a) {
  std::vector<Solver> solvers;
  for (const Options& options : all) solvers.emplace_back(options).factor(a.view());
  in_blas.expect(all.size());
  in_threads(static_cast<int>(all.size()),
             [&](int t) { solvers[static_cast<std::size_t>(t)].refactor(a.values.data()); });
  EXPECT_TRUE(in_blas.met());
  in_blas.expect(0);
}

// More of them than processors: those of one thread wait for nobody.
TEST(ConcurrentSolvers, OfOneThreadEachFactorAtTheSameTime) {
  const SparseMatrix a =
      random_diagonally_dominant(400, 60, 1);  // one front, too large for kernels of our own
  for (const Backend backend : {Backend::serial, Backend::openmp}) {
    expect_to_meet({options_of(backend, 1), options_of(backend, 1)}, a);
    expect_to_meet(std::vector<Options>(5, options_of(backend, 1)), a);
  }
}

TEST(ConcurrentSolvers, WithProgressToo) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "a processor alone";
  Options told = with_threads(1);
  told.progress = [](const Progress&) {};
  expect_to_meet({told, told}, random_diagonally_dominant(400, 60, 1));
}

/// All that a solver of one matrix computes for three right-hand sides.
std::vector<double> results(Solver& solver, const SparseMatrix& a, const std::vector<double>& b) {
  std::vector<double> x(b.size()), all;
  solver.refactor(a.values.data());
  solver.solve(b.data(), x.data(), 3);
  all.insert(all.end(), x.begin(), x.end());
  solver.solve_transpose(b.data(), x.data(), 3);
  all.insert(all.end(), x.begin(), x.end());
  all.push_back(solver.report().backward_error);
  return all;
}

// Bit for bit what each computes alone: matrices of every size and rung, teams of one to three threads, all
// of whose analyses, factorizations and solves meet in every combination.
TEST(ConcurrentSolvers, ComputeWhatTheyDoAlone) {
  std::vector<SparseMatrix> matrices{grid_2d(4, 3), grid_2d(40, 41), grid_2d(120, 121),
                                     random_diagonally_dominant(300, 4, 1),
                                     adversarial_matrix("saddle point renumbered", 1)};
  struct Case {
    const SparseMatrix* matrix;
    Options options;
    std::vector<double> alone;
  };
  std::vector<Case> cases;
  for (const SparseMatrix& a : matrices) {
    for (const int threads : {1, 1, 2, 3}) cases.push_back({&a, with_threads(threads), {}});
    cases.push_back({&a, with_threads(1), {}});
    cases.back().options.factor.precision = Precision::single;
  }
  const auto run = [](const Case& one) {
    Solver solver(one.options);
    solver.factor(one.matrix->view());
    return results(solver, *one.matrix, right_hand_sides(*one.matrix, 3, one.matrix->n, 1));
  };
  for (Case& one : cases) one.alone = run(one);
  for (int round = 0; round < 3; ++round) {
    in_threads(static_cast<int>(cases.size()), [&](int t) {
      const Case& one = cases[static_cast<std::size_t>((t + 7 * round)) % cases.size()];
      const std::vector<double> found = run(one);
      EXPECT_EQ(found, one.alone) << "case " << t << ", round " << round;
    });
  }
}

// Errors of one do not touch the others.
TEST(ConcurrentSolvers, FailAlone) {
  const SparseMatrix good = grid_2d(30, 30), singular = from_entries(3, {{0, 0, 1}, {1, 1, 1}, {2, 1, 1}});
  in_threads(6, [&](int t) {
    Solver solver(with_threads(1 + t % 2));
    for (int k = 0; k < 10; ++k) {
      if (t % 3 == 0) failure_of<SingularMatrix>([&] { solver.analyze(singular.view()); });
      solver.analyze(good.view());
      solver.factor(good.view());
      expect_solves(solver, good);
    }
  });
}

// Work in the thread of the caller finds the rounding that it needs and leaves the caller's.
TEST(ConcurrentSolvers, ModesOfFloatingPointAreTheCallers) {
  const SparseMatrix a = grid_2d(9, 9);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  const std::vector<double> b = right_hand_sides(a, 3, a.n, 1);
  const std::vector<double> expected = results(solver, a, b);
  std::fenv_t before;
  std::fegetenv(&before);
  std::fesetround(FE_UPWARD);
  std::feclearexcept(FE_ALL_EXCEPT);
  const std::vector<double> found = results(solver, a, b);
  EXPECT_EQ(std::fegetround(), FE_UPWARD);
  EXPECT_EQ(std::fetestexcept(FE_DIVBYZERO | FE_INVALID), 0);
  std::fesetenv(&before);
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace mfs::test
