// One library in a process with other things going on: threads of the caller, other solvers, BLAS and OpenMP
// settings, output, callbacks.
#include <dlfcn.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <set>
#include <thread>
#include <utility>

#include "test/failure/fresh_solver.hpp"
#include "test/failure/new_process.hpp"
#include "test/failure/refused_threads.hpp"

extern char** environ;

namespace mfs::test {
namespace {

double seconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processors that were busy for this process, on average. A loaded machine can only make it less.
template <class Work>
double busy_processors(const Work& work) {
  const double wall = seconds(CLOCK_MONOTONIC), used = seconds(CLOCK_PROCESS_CPUTIME_ID);
  work();
  return (seconds(CLOCK_PROCESS_CPUTIME_ID) - used) / (seconds(CLOCK_MONOTONIC) - wall);
}

TEST(Threads, NoMoreThanAskedForDoTheWork) {
  const SparseMatrix a = grid_2d(150, 150);
  const std::vector<double> b = right_hand_sides(a, 16, a.n, 1);
  std::vector<double> x(b.size());
  for (const int threads : {1, 2, 1}) {
    // Idle threads of BLAS (from its load on) and OpenMP spin for some milliseconds before they sleep.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const double busy = busy_processors([&] {
      Solver solver(with_threads(threads));
      for (int k = 0; k < 8; ++k) {
        solver.factor(a.view());
        solver.solve(b.data(), x.data(), 16);
      }
    });
    EXPECT_LE(busy, threads + 0.2);
  }
}

TEST(Threads, SettingsOfBlasAndOpenMpAreLeftAlone) {
  const auto get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  const auto set = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  const int omp_before = omp_get_max_threads();
  for (const int wanted : {1, 2}) {
    if (set) set(wanted);
    Options options = with_threads(2);
    options.solve.tolerance = 1e-30;  // an error on the way changes nothing
    Solver solver(options);
    const SparseMatrix a = grid_2d(40, 40);
    solver.factor(a.view());
    const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
    std::vector<double> x(b.size());
    failure_of<AccuracyNotReached>([&] { solver.solve(b.data(), x.data()); });
    if (get && set) {
      EXPECT_EQ(get(), wanted);
    }
    EXPECT_EQ(omp_get_max_threads(), omp_before);
  }
}

TEST(Threads, EnvironmentAndRandomNumbersAreLeftAlone) {
  const auto snapshot = [] {
    std::vector<std::string> all;
    for (char** variable = environ; *variable; ++variable) all.emplace_back(*variable);
    return all;
  };
  const std::vector<std::string> before = snapshot();
  const SparseMatrix a = grid_2d(40, 40);
  std::srand(5);
  const int first = std::rand(), second = std::rand();
  std::srand(5);
  EXPECT_EQ(std::rand(), first);
  Solver solver(with_threads(2));
  solver.factor(a.view());
  EXPECT_EQ(std::rand(), second);
  EXPECT_EQ(snapshot(), before);
}

void solve_often(int threads, std::uint64_t seed, Backend backend = Backend::openmp) {
  Options options = with_threads(threads);
  options.backend = backend;
  Solver solver(options);
  const SparseMatrix a = random_diagonally_dominant(200, 4, seed);
  solver.factor(a.view());
  for (int k = 0; k < 5; ++k) {
    solver.refactor(a.values.data());
    expect_solves(solver, a);
  }
}

TEST(Threads, CallsFromManyThreadsAtOnce) {
  std::vector<std::thread> callers;
  for (int t = 0; t < 5; ++t) {
    callers.emplace_back([t] { solve_often(1 + t % 3, static_cast<std::uint64_t>(t)); });
  }
  for (std::thread& caller : callers) caller.join();
}

TEST(Threads, CallsFromAParallelRegion) {
#pragma omp parallel for num_threads(3)
  for (int t = 0; t < 6; ++t) solve_often(1 + t % 2, static_cast<std::uint64_t>(t));
  EXPECT_FALSE(omp_in_parallel());
}

// Solvers with different numbers of threads and different backends, alternating: each finds the others'
// settings.
TEST(Threads, SolversTakeTurns) {
  const SparseMatrix small = grid_2d(12, 12), large = grid_2d(120, 120);
  for (const SparseMatrix* a : {&small, &large}) {
    std::vector<Solver> solvers;
    for (const int threads : {1, 2, 3, 2, 1}) solvers.emplace_back(with_threads(threads));
    Options serial;
    serial.backend = Backend::serial;
    solvers.emplace_back(serial);
    for (Solver& solver : solvers) solver.factor(a->view());
    for (int round = 0; round < 4; ++round) {
      for (Solver& solver : solvers) {
        solver.refactor(a->values.data());
        expect_solves(solver, *a);
      }
    }
  }
}

TEST(Threads, SolverMayMoveToAnotherThread) {
  const SparseMatrix a = grid_2d(30, 30);
  Solver solver(with_threads(2));
  std::thread([&] { solver.factor(a.view()); }).join();
  expect_solves(solver, a);
  std::thread([&] { expect_solves(solver, a); }).join();
}

TEST(Threads, RefusedByTheSystem) {
  const SparseMatrix a = grid_2d(5, 4);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  Solver many(with_threads(5));
  {
    const RefusedThreads none;
    if (const auto error = failure_of<BackendError>([&] { many.factor(a.view()); })) {
      EXPECT_EQ(error->library(), "threads");
      EXPECT_EQ(error->code(), EAGAIN);
    }
    expect_solves(solver, a);  // what is there goes on
  }
  expect_usable(many);
}

// The threads of the parent are not in the child: it has new ones, and so has its child.
TEST(Threads, ForkedProcessesGoOn) {
  const SparseMatrix a = grid_2d(150, 140);
#pragma omp parallel num_threads(3)
  {  // the caller's own threads are not there, either
  }
  Solver one(with_threads(1)), several(with_threads(3));
  one.factor(a.view());
  several.factor(a.view());
  const auto use = [&] {
    expect_solves(several, a);
    expect_solves(one, a);
    several.refactor(a.values.data());
    one.refactor(a.values.data());
    expect_solves(several, a);
    expect_solves(one, a);
    Solver made_here(with_threads(4));
    expect_usable(made_here);
    std::thread other([&] { expect_solves(several, a); });
    expect_solves(one, a);
    other.join();
  };
  check_in_new_process([&] {
    use();
    check_in_new_process(use);
  });
  check_in_new_process(use);
  use();
}

// What calls of the parent had locked nobody opens in the child. The callback comes while there is work, and
// once when it is done.
TEST(Threads, ForkedAtWorkIsRefused) {
  const SparseMatrix small = grid_2d(5, 4);
  constexpr int kRefused = 2;
  bool refused = false;
  Options options = with_threads(2);
  options.progress = [&](const Progress&) {
    if (refused) return;
    const auto factor = [&] {
      try {
        for (const int threads : {1, 2}) Solver(with_threads(threads)).factor(small.view());
      } catch (const StateError&) {
        return kRefused;
      }
      return 0;
    };
    const int outcome = in_new_process(factor, 60);
    EXPECT_TRUE(outcome == 0 || outcome == kRefused) << outcome;
    refused = outcome == kRefused;
  };
  Solver solver(options);
  const SparseMatrix large = grid_2d(600, 600);
  for (int k = 0; k < 20 && !refused; ++k) solver.factor(large.view());
  EXPECT_TRUE(refused);
}

TEST(Threads, ForkedFromKokkosIsRefusedToItAlone) {
  const SparseMatrix a = grid_2d(30, 20);
  Options options = with_threads(2);
  options.backend = Backend::kokkos;
  Solver by_kokkos(options), by_threads(with_threads(2));
  by_kokkos.factor(a.view());
  by_threads.factor(a.view());
  check_in_new_process([&] {
    failure_of<StateError>([&] { expect_solves(by_kokkos, a); });
    failure_of<StateError>([&] { Solver(options).factor(a.view()); });
    expect_solves(by_threads, a);
  });
  expect_solves(by_kokkos, a);
}

TEST(Callbacks, ProgressComesInTheCallersThreadAndGrows) {
  struct Told {
    std::string phase;
    double fraction;
  };
  std::vector<Told> told;
  std::set<std::thread::id> threads;
  Options options = with_threads(2);
  options.progress = [&](const Progress& progress) {
    told.push_back({progress.phase, progress.fraction});
    threads.insert(std::this_thread::get_id());
  };
  Solver solver(options);
  const SparseMatrix a = grid_2d(260, 260);
  solver.factor(a.view());
  const std::vector<double> b = right_hand_sides(a, 20, a.n, 1);
  std::vector<double> x(b.size());
  solver.solve(b.data(), x.data(), 20);
  EXPECT_EQ(threads, std::set<std::thread::id>{std::this_thread::get_id()});
  const std::set<std::string> known{"matching", "ordering", "symbolic", "factor", "solve"};
  ASSERT_FALSE(told.empty());
  for (std::size_t k = 0; k < told.size(); ++k) {
    EXPECT_TRUE(known.count(told[k].phase)) << told[k].phase;
    EXPECT_GE(told[k].fraction, 0.0);
    EXPECT_LE(told[k].fraction, 1.0 + 1e-9);
  }
  for (std::size_t k = 1; k < told.size(); ++k) {
    if (told[k].phase == told[k - 1].phase) {
      EXPECT_GE(told[k].fraction, told[k - 1].fraction) << told[k].phase;
    } else if (told[k - 1].phase == "factor") {
      EXPECT_NEAR(told[k - 1].fraction, 1.0, 1e-9);
    }
  }
  EXPECT_EQ(told.back().phase, "solve");
}

TEST(Callbacks, WhatProgressThrowsComesOutAndTheSolverStaysUsable) {
  struct Stop {};
  bool armed = true;
  Options options = with_threads(2);
  options.progress = [&](const Progress&) {
    if (armed) throw Stop();
  };
  Solver solver(options);
  const SparseMatrix a = grid_2d(260, 260);  // long enough to be told on the way
  EXPECT_THROW(solver.analyze(a.view()), Stop);
  EXPECT_THROW(solver.factor(a.view()), Stop);
  armed = false;
  expect_usable(solver);
}

// Whatever a callback throws at its n-th call, of whatever type, is what the caller gets.
template <class Thrown>
void expect_passed_on(const Thrown& thrown) {
  const SparseMatrix a = grid_2d(40, 40);
  for (const bool by_log : {false, true}) {
    int calls = 0, last = 1;
    Options options = with_threads(2);
    options.verbosity = 2;
    const auto call = [&] {
      if (++calls == last) throw thrown;
    };
    if (by_log)
      options.log = [&](const std::string&) { call(); };
    else
      options.progress = [&](const Progress&) { call(); };
    Solver solver(options);
    bool done = false;
    for (; !done && last < 100; ++last) {
      calls = 0;
      try {
        solver.factor(a.view());
        const std::vector<double> b(static_cast<std::size_t>(a.n), 1.0);
        std::vector<double> x(b.size());
        solver.solve(b.data(), x.data());
        done = true;
      } catch (const Thrown&) {
        EXPECT_GE(calls, last);
      }
    }
    EXPECT_TRUE(done);
    EXPECT_GT(last, 4) << "no phase was told of";
    last = -1;
    expect_usable(solver);
  }
}

TEST(Callbacks, WhatTheyThrowIsPassedOnAsItIs) {
  expect_passed_on(42);
  expect_passed_on(std::string("not derived from std::exception"));
  expect_passed_on(std::system_error(std::make_error_code(std::errc::interrupted)));
}

TEST(Callbacks, LogGetsLinesByLevel) {
  for (const int level : {0, 1, 2}) {
    std::vector<std::string> lines;
    Options options = with_threads(1);
    options.verbosity = level;
    options.log = [&](const std::string& line) { lines.push_back(line); };
    Solver solver(options);
    solver.factor(grid_2d(10, 10).view());
    EXPECT_EQ(lines.empty(), level == 0);
    const auto tells = [&](const std::string& begin) {
      return std::any_of(lines.begin(), lines.end(),
                         [&](const std::string& line) { return line.rfind(begin, 0) == 0; });
    };
    EXPECT_EQ(tells("plan: "), level == 2);
    EXPECT_EQ(tells("factors: 0 perturbed"), level == 2);
  }
}

TEST(Silence, NothingIsPrinted) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  for (const int threads : {1, 2, 7}) {
    Solver solver(with_threads(threads));
    for (const NamedMatrix& named : adversarial_matrices(5)) {
      try {
        solver.analyze(named.matrix.view());
        solver.factor(named.matrix.view());
        const std::vector<double> b(named.matrix.n, 1.0);
        std::vector<double> x(b.size());
        solver.solve(b.data(), x.data());
      } catch (const Error&) {
      }
    }
    try {
      solver.analyze(from_entries(2, {{0, 0, 1.0}}).view());
    } catch (const SingularMatrix&) {
    }
  }
  std::fflush(nullptr);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace mfs::test
