// Whole factorizations through accuracy/factorization.hpp: the bytes and operations that the plan promised,
// the same bits from run to run, solutions as good as the reference's.
#include <cstring>
#include <string>

#include <mfs/analysis_options.hpp>

#include "accuracy/factorization.hpp"
#include "ordering/order_matrix.hpp"
#include "solver/option_checks.hpp"
#include "test/reference/generators.hpp"
#include "test/stages/stage_bench.hpp"

namespace mfs::test {
namespace {

/// Deep enough for several depths, with fronts that two threads share (more than 2e7 operations) in the last
/// one.
std::vector<StageProblem<double>> problems() {
  std::vector<StageProblem<double>> made{artificial_problem(mixed_tree(), {21, 0.6, 64}),
                                         artificial_problem(leaf_and_root(330, 200), {22, 1.0, 128}),
                                         artificial_problem(broom(), {23})};
  for (const SparseMatrix& matrix : {grid_2d(40, 37), random_diagonally_dominant(500, 4, 5)}) {
    made.push_back(
        matrix_problem(matrix, order_matrix(pattern_of(matrix), MatchedScaling(), AnalysisOptions(), 1), 64));
  }
  return made;
}

std::unique_ptr<Factorization<double>> factorization(const StageProblem<double>& problem, HostSpace space,
                                                     int threads, bool narrow = false) {
  auto factors = make_host_factors<double>(space, narrow, problem.plan, problem.pattern, threads);
  fill(problem, *factors);
  return make_factorization<double>(space, std::move(factors), problem.plan, problem.pattern);
}

/// Solutions with one and with five right-hand sides, plain and transposed, one after another.
std::vector<double> solutions(const StageProblem<double>& problem, Factorization<double>& numeric) {
  std::vector<double> all;
  const TransposedPattern transposed = transpose(*problem.pattern, 1);
  const Offset n = problem.plan->n;
  for (const Vertex columns : {1, 5}) {
    for (const TransposedPattern* pattern : {static_cast<const TransposedPattern*>(nullptr), &transposed}) {
      const std::vector<double> b = Random(5).vector(n * columns);
      std::copy(b.begin(), b.end(), numeric.rhs(columns));
      const SolveOutcome outcome = numeric.solve(columns, pattern, SolveControls());
      EXPECT_LT(outcome.backward_error, 1e-13);
      all.insert(all.end(), numeric.solution(), numeric.solution() + n * columns);
    }
  }
  return all;
}

struct Run {
  FactorStatus status;
  std::vector<double> solutions;
};

Run run(const StageProblem<double>& problem, HostSpace space, int threads, int repetitions = 1) {
  Run result{};
  in_engine(threads, [&] {
    const auto numeric = factorization(problem, space, threads);
    for (int k = 0; k < repetitions; ++k) {
      result.status = numeric->factor(1e-8, {});
      result.solutions = solutions(problem, *numeric);
    }
  });
  return result;
}

TEST(Factorization, SolvesAsTheReferenceDoes) {
  for (const StageProblem<double>& problem : problems()) {
    const auto fronts = factor(*problem.plan, problem.scaled(), ReferenceRule());
    const Vertex n = problem.plan->n;
    const std::vector<double> b = Random(5).vector(n);
    std::vector<double> v(n), x(n);
    for (Vertex p = 0; p < n; ++p)
      v[p] = b[problem.plan->row_of[p]] * problem.row_scale[problem.plan->row_of[p]];
    solve_forward(fronts, false, v);
    solve_backward(fronts, false, v);
    for (Vertex p = 0; p < n; ++p) {
      x[problem.plan->column_of[p]] = v[p] * problem.column_scale[problem.plan->column_of[p]];
    }
    std::vector<double> first = run(problem, HostSpace::openmp, 2).solutions;
    first.resize(n);
    EXPECT_LT(difference(first, x), 1e-10);
  }
}

/// max_i |b - A x|_i / (|A| |x| + |b| + f)_i with f_i = part * max_j |x_j / c_j| / r_i.
double floored_error(const SparseMatrix& a, const double* b, const double* x, double part,
                     const std::vector<double>& r, const std::vector<double>& c) {
  double largest = 0, worst = 0;
  for (std::int64_t j = 0; j < a.n; ++j) largest = std::max(largest, std::abs(x[j] / c[j]));
  for (std::int64_t i = 0; i < a.n; ++i) {
    long double residual = b[i], size = std::abs(b[i]) + part * largest / r[i];
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      residual -= static_cast<long double>(a.values[k]) * x[a.columns[k]];
      size += std::abs(static_cast<long double>(a.values[k]) * x[a.columns[k]]);
    }
    worst = std::max(worst, static_cast<double>(std::abs(residual) / size));
  }
  return worst;
}

// With factors of single precision and no refinement there is an error to be seen.
TEST(Factorization, MeasuresRowsByTheirFloor) {
  for (const StageProblem<double>& problem : problems()) {
    const auto& columns = problem.pattern->columns;
    const SparseMatrix a{
        problem.plan->n, problem.pattern->offsets, {columns.begin(), columns.end()}, problem.values};
    in_engine(2, [&] {
      const auto numeric = factorization(problem, HostSpace::openmp, 2, true);
      numeric->factor(1e-4, {});
      for (const bool transpose : {false, true}) {
        const TransposedPattern pattern = mfs::transpose(*problem.pattern, 1);
        std::vector<double> b = Random(5).vector(a.n);
        b[0] *= 1e6;
        std::copy(b.begin(), b.end(), numeric->rhs(1));
        const SolveOutcome outcome = numeric->solve(1, transpose ? &pattern : nullptr, {1.0, 0, 0.25});
        const std::vector<double>&r = transpose ? problem.column_scale : problem.row_scale,
              &c = transpose ? problem.row_scale : problem.column_scale;
        const double expected =
            floored_error(transpose ? transposed(a) : a, b.data(), numeric->solution(), 0.25, r, c);
        EXPECT_NEAR(outcome.backward_error, expected, 1e-6 * expected);
      }
    });
  }
}

TEST(Factorization, TakesExactlyThePredictedBytes) {
  for (const StageProblem<double>& problem : problems()) {
    in_engine(2, [&] {
      for (const HostSpace space : {HostSpace::serial, HostSpace::openmp}) {
        const auto numeric = factorization(problem, space, 2);
        const NumericBytes bytes = numeric_bytes(*problem.plan, sizeof(double), sizeof(double));
        EXPECT_EQ(numeric->bytes(), bytes.total());
        EXPECT_EQ(bytes.factor, problem.plan->factor_entries * static_cast<Offset>(sizeof(double)));
        EXPECT_GE(problem.plan->factor_entries, problem.plan->nnz_factor);
        numeric->factor(1e-8, {});
        numeric->rhs(1);
        EXPECT_EQ(numeric->bytes(), bytes.total());
        numeric->rhs(16);
        EXPECT_EQ(numeric->bytes(), numeric_bytes(*problem.plan, sizeof(double), sizeof(double), 16).total());
      }
    });
  }
}

TEST(Factorization, DoesExactlyThePredictedOperations) {
  for (const StageProblem<double>& problem : problems()) {
    for (const int threads : {1, 3}) {
      const FactorStatus status = run(problem, HostSpace::openmp, threads).status;
      const BlockFlops& plan = problem.plan->flops;
      EXPECT_NEAR(status.getrf, plan.getrf, 1e-12 * plan.getrf);
      EXPECT_NEAR(status.trsm, plan.trsm, 1e-12 * plan.trsm);
      EXPECT_NEAR(status.gemm, plan.gemm, 1e-12 * plan.gemm);
      EXPECT_EQ(status.perturbed, 0u);
      EXPECT_EQ(status.nonfinite, 0u);
    }
  }
}

TEST(Factorization, GivesTheSameBitsFromRunToRun) {
  for (const StageProblem<double>& problem : problems()) {
    const std::vector<double> serial = run(problem, HostSpace::serial, 1).solutions;
    EXPECT_EQ(run(problem, HostSpace::serial, 2).solutions, serial);
    EXPECT_EQ(run(problem, HostSpace::openmp, 1).solutions, serial);
    for (const int threads : {2, 3}) {
      const std::vector<double> first = run(problem, HostSpace::openmp, threads).solutions;
      for (int k = 0; k < 3; ++k) EXPECT_EQ(run(problem, HostSpace::openmp, threads).solutions, first);
      EXPECT_EQ(run(problem, HostSpace::openmp, threads, 3).solutions, first) << "factored again";
    }
  }
}

TEST(Factorization, TellsItsProgress) {
  const StageProblem<double> problem = artificial_problem(mixed_tree(), {21, 0.6, 64});
  std::vector<double> told;
  in_engine(2, [&] {
    factorization(problem, HostSpace::openmp, 2)->factor(1e-8, [&](double fraction) {
      told.push_back(fraction);
    });
  });
  ASSERT_EQ(told.size(), static_cast<std::size_t>(problem.plan->num_depths));
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_NEAR(told.back(), 1.0, 1e-12);
}

// Row exchanges inside a pivot block: which row of A became which pivot.
TEST(Factorization, NamesRowsAndShiftsOfPivots) {
  SparseMatrix a = from_entries_summed(3, {{0, 0, 1.0}, {0, 1, 2.0}, {1, 0, 4.0}, {1, 1, 8.0}, {2, 2, 1.0}});
  SeparatorTree tree{{0, 1, 2}, {0, 2, 3}, {-1, -1}};
  const StageProblem<double> problem = matrix_problem(a, tree, 64);
  in_engine(1, [&] {
    const auto numeric = factorization(problem, HostSpace::serial, 1);
    EXPECT_EQ(numeric->factor(1e-8, {}).perturbed, 1u);
    EXPECT_EQ(numeric->pivot_row(0), 1);
    EXPECT_EQ(numeric->pivot_row(1), 0);
    EXPECT_EQ(numeric->pivot_row(2), 2);
    EXPECT_EQ(numeric->factors().pivot_shift(0), 0.0);
    EXPECT_EQ(numeric->factors().pivot_shift(1), 8.0);  // the largest entry: its column depends on the other
    EXPECT_EQ(numeric->factors().pivot_shift(2), 0.0);
  });
}

TEST(Precision, AutomaticIsSingleWhereDoubleIsSlow) {
  EXPECT_EQ(automatic_precision(2), Precision::full);     // compute capability 8.0, 9.0
  EXPECT_EQ(automatic_precision(32), Precision::single);  // 8.6
  FactorOptions options;
  EXPECT_TRUE(mixed_precision<double>(options, Precision::single));
  EXPECT_FALSE(mixed_precision<float>(options, Precision::single));
  EXPECT_FALSE(mixed_precision<double>(options, Precision::full));
  options.precision = Precision::full;
  EXPECT_FALSE(mixed_precision<double>(options, Precision::single));
  options.precision = Precision::single;
  EXPECT_TRUE(mixed_precision<std::complex<double>>(options, Precision::full));
}

}  // namespace
}  // namespace mfs::test
