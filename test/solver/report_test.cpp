// What the solver says about its work, and that it does the same work every time.
#include <string>

#include "test/reference/generators.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

TEST(Report, FiguresFitTogether) {
  for (const int threads : {1, 2}) {
    const SparseMatrix a = grid_2d(60, 61);
    Solver solver(with_threads(threads));
    solver.analyze(a.view());
    const Report analysed = solver.report();
    EXPECT_EQ(analysed.n, a.n);
    EXPECT_EQ(analysed.nnz, a.entries());
    EXPECT_EQ(analysed.threads, threads);
    EXPECT_FALSE(analysed.matched);
    EXPECT_GE(analysed.nnz_factor, a.entries());
    EXPECT_GE(analysed.bytes_factor, analysed.nnz_factor * 8);
    EXPECT_GT(analysed.bytes_peak, analysed.bytes_factor);
    EXPECT_EQ(analysed.bytes_used, 0);
    EXPECT_GT(analysed.time_order, 0);
    EXPECT_GT(analysed.time_symbolic, 0);

    const std::vector<DepthSummary> depths = solver.depths();
    ASSERT_EQ(static_cast<std::int64_t>(depths.size()), analysed.depths);
    std::int64_t pivots = 0, fronts = 0, entries = 0, largest = 0;
    Flops flops;
    for (std::size_t d = 0; d < depths.size(); ++d) {
      EXPECT_EQ(depths[d].depth, static_cast<std::int32_t>(d));
      pivots += depths[d].pivots;
      fronts += depths[d].fronts;
      entries += depths[d].factor_entries;
      largest = std::max(largest, depths[d].max_front);
      flops.getrf += depths[d].flops.getrf;
      flops.trsm += depths[d].flops.trsm;
      flops.gemm += depths[d].flops.gemm;
    }
    EXPECT_EQ(pivots, a.n);
    EXPECT_EQ(fronts, analysed.fronts);
    EXPECT_EQ(entries, analysed.nnz_factor);
    EXPECT_EQ(largest, analysed.max_front);
    EXPECT_NEAR(flops.total(), analysed.flops.total(), 1e-9 * flops.total());

    solver.factor(a.view());
    const Report& factored = solver.report();
    EXPECT_NEAR(factored.flops_used.getrf, analysed.flops.getrf, 1e-12 * analysed.flops.getrf);
    EXPECT_NEAR(factored.flops_used.trsm, analysed.flops.trsm, 1e-12 * analysed.flops.trsm);
    EXPECT_NEAR(factored.flops_used.gemm, analysed.flops.gemm, 1e-12 * analysed.flops.gemm);
    EXPECT_EQ(factored.bytes_used, analysed.bytes_peak) << "predicted exactly";
    EXPECT_EQ(factored.perturbed_pivots, 0);
    EXPECT_GT(factored.time_factor, 0);
    expect_solves(solver, a);
    EXPECT_EQ(solver.report().bytes_used, analysed.bytes_peak);
    EXPECT_GT(solver.report().time_solve, 0);
    solver.refactor(a.values.data());
    EXPECT_GT(solver.report().time_refactor, 0);
  }
}

TEST(Report, IsEmptyBeforeAnalyze) {
  const Solver solver(with_threads(1));
  EXPECT_EQ(solver.report().n, 0);
  EXPECT_TRUE(solver.depths().empty());
  EXPECT_FALSE(solver.analyzed());
  EXPECT_FALSE(solver.factored());
  EXPECT_EQ(solver.options().threads, 1);
}

/// Solutions with one and with many right-hand sides, plain and transposed, after factor and after refactor.
std::vector<double> all_solutions(const NamedMatrix& named, Solver& solver) {
  const SparseMatrix& a = named.matrix;
  const SparseMatrix at = transposed(a);
  std::vector<double> all;
  for (int round = 0; round < 2; ++round) {
    if (round == 0) {
      solver.factor(a.view());
    } else {
      solver.refactor(a.view());
    }
    for (const std::int64_t nrhs : {1, 18}) {
      std::vector<double> b = right_hand_sides(a, nrhs, a.n, 5, named.solution_sizes);
      std::vector<double> x(b.size());
      solver.solve(b.data(), x.data(), nrhs);
      all.insert(all.end(), x.begin(), x.end());
      b = right_hand_sides(at, nrhs, a.n, 5, named.transposed_solution_sizes);
      solver.solve_transpose(b.data(), x.data(), nrhs);
      all.insert(all.end(), x.begin(), x.end());
    }
  }
  return all;
}

TEST(Repeatability, SameBitsFromRunToRunAndFromObjectToObject) {
  std::vector<NamedMatrix> matrices = adversarial_matrices(3);
  matrices.push_back({"large grid", grid_2d(110, 110)});
  for (const NamedMatrix& named : matrices) {
    SCOPED_TRACE(named.name);
    for (const int threads : {1, 2}) {
      Solver first(with_threads(threads)), second(with_threads(threads));
      const std::vector<double> expected = all_solutions(named, first);
      EXPECT_EQ(all_solutions(named, first), expected);
      EXPECT_EQ(all_solutions(named, second), expected);
    }
    Options serial = with_threads(1);
    serial.backend = Backend::serial;
    Solver first(with_threads(1)), second(serial);
    EXPECT_EQ(all_solutions(named, second), all_solutions(named, first)) << "serial and one thread";
  }
}

/// A number of the diagonal that is zero, with a row and a column that hold nothing else: of a singular
/// matrix.
SparseMatrix with_empty_row(SparseMatrix a, std::int64_t row) {
  for (std::int64_t i = 0; i < a.n; ++i) {
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      if (i == row || a.columns[k] == row) a.values[k] = 0;
    }
  }
  return a;
}

// Tiny systems, too, whose factors are made in two ways.
TEST(Repeatability, SameBitsWhateverTheValuesBefore) {
  for (const SparseMatrix& a : {grid_2d(5, 6), grid_2d(30, 31), random_diagonally_dominant(60, 3, 4)}) {
    SCOPED_TRACE(a.n);
    const SparseMatrix singular = with_empty_row(a, a.n / 2);
    SparseMatrix other = a;
    for (double& value : other.values) value *= value > 0 ? 1.5 : 0.25;
    const std::vector<double> b = right_hand_sides(a, 1, a.n, 5);
    const auto solution = [&](Solver& solver, const SparseMatrix& matrix) {
      std::vector<double> x(b.size());
      solver.refactor(matrix.view());
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(matrix, b, x), kPromised);
      return x;
    };
    Solver solver(with_threads(1)), first(with_threads(1));
    solver.factor(a.view());
    first.factor(a.view());
    const std::vector<double> of_a = solution(first, a), of_other = solution(first, other);
    for (int round = 0; round < 5; ++round) {
      solver.refactor(singular.view());
      std::vector<double> x(b.size());
      EXPECT_THROW(solver.solve(b.data(), x.data()), SingularMatrix);
      solver.factor(a.view());
      EXPECT_EQ(solution(solver, other), of_other);
      EXPECT_EQ(solution(solver, a), of_a);
    }
  }
}

// Panels are what goes first.
TEST(MemoryLimit, LeavesTinySystemsWhatFrontsNeed) {
  const SparseMatrix a = grid_2d(12, 13);
  Solver free(with_threads(1));
  free.factor(a.view());
  Options options = with_threads(1);
  options.memory_limit = free.report().bytes_peak;
  Solver enough(options);
  enough.factor(a.view());
  EXPECT_EQ(enough.report().bytes_used, free.report().bytes_used);
  --options.memory_limit;
  Solver limited(options);
  limited.factor(a.view());
  expect_solves(limited, a);
  EXPECT_LT(limited.report().bytes_used, free.report().bytes_used);
  EXPECT_EQ(limited.report().bytes_peak, limited.report().bytes_used);
  options.memory_limit = limited.report().bytes_peak - 1;
  EXPECT_THROW(Solver(options).factor(a.view()), OutOfMemory);
}

TEST(Version, SaysWhatBackendsAre) {
  for (const Backend backend : {Backend::serial, Backend::openmp, Backend::cuda}) {
    const BackendInfo info = backend_info(backend);  // of all, usable here or not
    EXPECT_EQ(info.memory, backend == Backend::cuda ? MemorySpace::device : MemorySpace::host);
    EXPECT_GT(info.factor_rate, 1e9);
    EXPECT_GT(info.flops_per_entry, 1);
  }
  EXPECT_GT(backend_info(Backend::openmp).factor_rate, backend_info(Backend::serial).factor_rate);
  EXPECT_THROW(backend_info(static_cast<Backend>(17)), InvalidInput);
}

TEST(Version, AgreesWithTheHeaders) {
  EXPECT_STREQ(version(), MFS_VERSION);
  const std::vector<Backend> known = backends();
  EXPECT_NE(std::find(known.begin(), known.end(), Backend::openmp), known.end());
  for (const LibraryInfo& library : libraries()) {
    EXPECT_FALSE(library.name.empty());
    EXPECT_FALSE(library.version.empty());
  }
}

}  // namespace
}  // namespace mfs::test
