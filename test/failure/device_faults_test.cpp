// Every call to CUDA, cuBLAS and cuSOLVER that a solver makes is let fail once, through all its phases: it
// must be told as what it is, leave no memory taken and no wrong solution behind, and an object that works.
// Needs a device; skips where there is none. The solver is compiled into this program: libmfs shows no seam.
#include <algorithm>
#include <limits>
#include <optional>

#include "kernels/cuda/runtime/device.hpp"
#include "kernels/cuda/runtime/faults.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/solver/on_device.hpp"
#include "test/stages/device_bench.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {
namespace {

using cuda::CallKind;

constexpr std::int64_t kColumns = 3;
constexpr double kUntouched = 12345;

/// Two matrices of one pattern and right-hand sides.
struct System {
  SparseMatrix a, next;
  std::vector<double> b;
};

System system_of(const SparseMatrix& a) {
  System system{a, a, right_hand_sides(a, kColumns, a.n, 3)};
  for (double& value : system.next.values) value *= -1.5;
  return system;
}

/// All phases; the last two factorizations and solves replay recorded graphs.
void use(Solver& solver, const System& system, std::vector<double>& x) {
  solver.analyze(system.a.view());
  solver.factor(system.a.view());
  for (int k = 0; k < 2; ++k) {
    solver.refactor(system.next.view());
    solver.solve(system.b.data(), x.data(), kColumns);
    x.assign(x.size(), kUntouched);
    solver.solve_transpose(system.b.data(), x.data(), kColumns);
    x.assign(x.size(), kUntouched);
  }
}

/// Runs work with the fault, and returns whether an error came out, which must be the right one.
template <class Work>
bool fails_properly(cuda::Fault& fault, const Work& work, const std::string& library = "cuBLAS") {
  bool failed = true;
  cuda::planned_fault = &fault;
  try {
    work();
    failed = false;
  } catch (const OutOfMemory& error) {
    EXPECT_TRUE(fault.kind == CallKind::device_memory || fault.kind == CallKind::host_memory) << error.what();
    EXPECT_EQ(error.space(), fault.kind == CallKind::host_memory ? MemorySpace::host : MemorySpace::device);
  } catch (const BackendError& error) {
    EXPECT_TRUE(fault.kind == CallKind::runtime || fault.kind == CallKind::library) << error.what();
    EXPECT_EQ(error.library(), fault.kind == CallKind::library ? library : "CUDA");
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another error: " << error.what();
  }
  cuda::planned_fault = nullptr;
  return failed;
}

/// After a fault: what is solved without a new factorization is right, or refused.
void expect_no_wrong_solution(Solver& solver, const System& system) {
  std::vector<double> x(system.b.size());
  try {
    solver.solve(system.b.data(), x.data(), kColumns);
  } catch (const Error&) {
    return;
  }
  const std::int64_t n = system.a.n;
  EXPECT_LE(std::min(worst_error(system.a, system.b, n, x, n, kColumns),
                     worst_error(system.next, system.b, n, x, n, kColumns)),
            kPromised);
}

void expect_survives(const Options& options, const System& system, long n) {
  SCOPED_TRACE("call " + std::to_string(n));
  std::optional<Solver> made;
  std::vector<double> x(system.b.size(), kUntouched);
  cuda::Fault fault{n};
  EXPECT_TRUE(fails_properly(fault, [&] { use(made.emplace(options), system, x); })) << "nothing was thrown";
  EXPECT_TRUE(fault.met);
  EXPECT_EQ(x, std::vector<double>(x.size(), kUntouched));
  Solver& solver = made ? *made : made.emplace(options);
  expect_no_wrong_solution(solver, system);
  solver.factor(system.a.view());
  expect_solves(solver, system.a, kColumns);
  solver.refactor(system.next.view());
  expect_solves(solver, system.next, kColumns);
}

class DeviceFaults : public OnDevice {
 protected:
  void TearDown() override { cuda::planned_fault = nullptr; }

  /// Calls of a use in which nothing fails.
  long count_calls(const System& system) const {
    cuda::Fault never{std::numeric_limits<long>::max()};
    cuda::planned_fault = &never;
    Solver solver(options_);
    std::vector<double> x(system.b.size());
    use(solver, system, x);
    cuda::planned_fault = nullptr;
    return never.calls;
  }
};

TEST_F(DeviceFaults, EveryCallThatFailsIsToldAndForgotten) {
  for (const SparseMatrix& a : {grid_2d(30, 29), random_diagonally_dominant(300, 4, 1)}) {
    const System system = system_of(a);
    const long calls = count_calls(system);
    ASSERT_GT(calls, 50);
    for (long n = 0; n < calls && !HasFailure(); ++n) expect_survives(options_, system, n);
  }
}

/// The least that does for a matrix, which OutOfMemory names.
std::int64_t least_limit(Options options, const SparseMatrix& a) {
  options.memory_limit = 1;
  Solver solver(options);
  try {
    solver.factor(a.view());
  } catch (const OutOfMemory& error) {
    return static_cast<std::int64_t>(error.needed());
  }
  ADD_FAILURE() << "one byte did";
  return 1;
}

// In segments, with copies beside the kernels; and with fronts divided and the matrix on the host.
TEST_F(DeviceFaults, EveryCallThatFailsIsToldWhereFactorsDoNotFit) {
  const SparseMatrix a = grid_3d(12);
  Solver full(options_);
  full.factor(a.view());
  const std::int64_t least = least_limit(options_, a);
  for (const std::int64_t limit : {least + full.report().bytes_peak / 2, least}) {
    options_.memory_limit = limit;
    Solver partial(options_);
    partial.analyze(a.view());
    ASSERT_TRUE(partial.report().partial);
    const System system = system_of(a);
    const long calls = count_calls(system);
    ASSERT_GT(calls, 100);
    for (long n = 0; n < calls && !HasFailure(); n += 5) expect_survives(options_, system, n);
  }
}

constexpr Offset kForTheDriver = Offset(300) << 20;

std::int64_t bytes_for(const Options& options, const SparseMatrix& a) {
  Solver solver(options);
  solver.analyze(a.view());
  return solver.report().bytes_peak;
}

/// Takes what is free but for so many bytes, as another process may.
cuda::DeviceArena take_all_but(Offset bytes) {
  return cuda::DeviceArena(cuda::free_memory() - bytes);
}

// There is no room for all factors then, but for segments. They are too large a part of this card to be made
// by the analysis.
TEST_F(DeviceFaults, MemoryTakenBetweenAnalysisAndFactorization) {
  const SparseMatrix a = grid_3d(60);
  const Offset needed = bytes_for(options_, a), left = kForTheDriver + needed * 6 / 10;
  ASSERT_LT(left, needed);
  {
    const cuda::DeviceArena others = take_all_but(2 * needed + kForTheDriver);
    Solver solver(options_);
    solver.analyze(a.view());
    ASSERT_FALSE(solver.report().partial);
    const cuda::DeviceArena taken = take_all_but(left);
    solver.factor(a.view());
    EXPECT_TRUE(solver.report().partial);
    expect_solves(solver, a, kColumns);
  }
  Solver again(options_);
  again.factor(a.view());
  EXPECT_FALSE(again.report().partial);
}

// Factors that are a small part of the card are made by the analysis: what others take later is no matter.
TEST_F(DeviceFaults, SmallFactorsHaveTheirMemorySinceTheAnalysis) {
  constexpr Offset kNoise = Offset(8) << 20;
  const SparseMatrix a = grid_3d(30), b = grid_2d(30, 29);
  Solver solver(options_);
  solver.factor(b.view());  // the driver has loaded what all need
  const Offset before = cuda::free_memory();
  solver.analyze(a.view());
  const Offset needed = solver.report().bytes_peak, analyzed = cuda::free_memory();
  ASSERT_GT(needed, 4 * kNoise);
  EXPECT_LE(analyzed, before - needed + kNoise);
  {
    const cuda::DeviceArena taken = take_all_but(needed / 2);
    solver.factor(a.view());
    EXPECT_FALSE(solver.report().partial);
  }
  EXPECT_GE(cuda::free_memory(), analyzed - kNoise);
  expect_solves(solver, a, kColumns);
  solver.analyze(b.view());
  EXPECT_GE(cuda::free_memory(), before - kNoise);
}

// The library's LU of a root, which a solver has for factors far too large for this only.
TEST_F(DeviceFaults, EveryCallForALibraryRootThatFailsIsTold) {
  in_engine(1, [] {
    Engine::use_cuda();
    const StageProblem<double> problem =
        artificial_problem({{150, 220, 1}, {257, 0, -1}}, {18, 1.0, 64, {}, 1.0});
    const auto factor = [&] {
      try {
        DeviceBench<double> bench(problem, 257);
        for (const Launches launches : {Launches::direct, Launches::recorded}) bench.factor(1.5e-8, launches);
        EXPECT_TRUE(bench.library_roots());
        expect_exact_factors(problem, bench.factored(), Measure::row);
      } catch (const std::bad_alloc&) {  // what the solver makes of it
        throw OutOfMemory(MemorySpace::host, 0, 0);
      }
    };
    int of_library = 0;
    bool failed = true;
    for (long n = 0; failed && !HasFailure(); ++n) {
      SCOPED_TRACE("call " + std::to_string(n));
      cuda::Fault fault{n};
      failed = fails_properly(fault, factor, "cuSOLVER");
      EXPECT_EQ(failed, fault.met);
      if (failed && fault.kind == CallKind::library) ++of_library;
    }
    EXPECT_EQ(of_library, 6) << "handle, parameters, stream, workspace, two LUs";
  });
}

// What the driver keeps for itself is there after the first rounds.
TEST_F(DeviceFaults, NoMemoryStaysTaken) {
  constexpr Offset kNoise = Offset(8) << 20;
  const System system = system_of(grid_2d(30, 29));
  const long calls = count_calls(system);
  const auto round = [&] {
    for (long n = 0; n < calls; n += 3) expect_survives(options_, system, n);
  };
  round();
  const Offset before = cuda::free_memory();
  round();
  EXPECT_GE(cuda::free_memory(), before - kNoise);
}

}  // namespace
}  // namespace mfs::test
