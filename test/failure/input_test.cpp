// Everything that a caller can hand over and that cannot be accepted: by its own class, with its exact place,
// and without harm to the object.
#include <cmath>
#include <limits>

#include "test/failure/fresh_solver.hpp"

namespace mfs::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// analyze and factor refuse `view` alike; the object then works.
void expect_refused(const CsrView<double>& view, const std::string& argument, std::int64_t row = -1,
                    std::int64_t column = -1) {
  Solver solver(with_threads(2));
  expect_invalid([&] { solver.analyze(view); }, argument, row, column);
  EXPECT_FALSE(solver.analyzed());
  expect_invalid([&] { solver.factor(view); }, argument, row, column);
  EXPECT_FALSE(solver.factored());
  expect_usable(solver);
}

TEST(Input, ShapesThatAreNoSquare) {
  const SparseMatrix a = grid_2d(3, 3);
  CsrView<double> view = a.view();
  view.columns = 8;
  expect_refused(view, "columns");
  view = a.view();
  view.rows = view.columns = -1;
  expect_refused(view, "rows");
  view.rows = 9;
  expect_refused(view, "columns");
  const std::int64_t zero = 0;
  expect_refused({0, 0, &zero, static_cast<const std::int32_t*>(nullptr), nullptr}, "rows");
  const std::int64_t too_many = std::int64_t{1} << 31;  // nothing is read or allocated for it
  expect_refused({too_many, too_many, &zero, &zero, nullptr}, "rows");
}

TEST(Input, NullPointers) {
  const SparseMatrix a = grid_2d(3, 3);
  CsrView<double> view = a.view();
  view.row_offsets = IndexSpan();
  expect_refused(view, "row_offsets");
  view = a.view();
  view.column_indices = IndexSpan();
  expect_refused(view, "column_indices");

  Solver solver(with_threads(1));
  view = a.view();
  view.values = nullptr;
  expect_invalid([&] { solver.factor(view); }, "values");
  solver.factor(a.view());
  expect_invalid([&] { solver.refactor(static_cast<const double*>(nullptr)); }, "values");
  expect_invalid([&] { solver.refactor(view); }, "values");
  expect_solves(solver, a);  // the last factorization is still there
  double x[9] = {};
  expect_invalid([&] { solver.solve(nullptr, x); }, "b");
  expect_invalid([&] { solver.solve(x, nullptr); }, "x");
  expect_invalid([&] { solver.solve_transpose(nullptr, x); }, "b");
  expect_invalid([&] { solver.solve_transpose(x, nullptr); }, "x");
  expect_usable(solver);
}

TEST(Input, Offsets) {
  SparseMatrix a = grid_2d(4, 4);
  a.offsets[0] = 1;
  expect_refused(a.view(), "row_offsets", 0);
  a = grid_2d(4, 4);
  a.offsets[6] = a.offsets[5] - 1;
  expect_refused(a.view(), "row_offsets", 5);
  a = grid_2d(4, 4);
  a.offsets[16] = -3;
  expect_refused(a.view(), "row_offsets", 15);

  // Offsets beyond 2^31 in 32 bits: they come back negative. Nothing but the offsets may be read.
  const std::vector<std::int32_t> overflowed{0, 2000000000,
                                             std::numeric_limits<std::int32_t>::min() + 1705032704};
  const std::int32_t column = 0;
  expect_refused({2, 2, overflowed.data(), &column, nullptr}, "row_offsets", 1);
}

TEST(Input, ColumnsOutOfRange) {
  for (const std::int32_t wrong :
       {-1, 16, std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()}) {
    SparseMatrix a = grid_2d(4, 4);
    a.columns[a.offsets[9] + 1] = wrong;
    a.columns[a.offsets[12]] = wrong;  // the first one is named
    expect_refused(a.view(), "column_indices", 9, wrong);
  }
  SparseMatrix a = grid_2d(4, 4);
  std::vector<std::int64_t> wide(a.columns.begin(), a.columns.end());
  wide[a.offsets[3]] = std::int64_t{1} << 32;  // not cut to 32 bits
  expect_refused({a.n, a.n, a.offsets.data(), wide.data(), a.values.data()}, "column_indices", 3,
                 std::int64_t{1} << 32);
}

TEST(Input, ValuesThatAreNoNumbers) {
  for (const double wrong : {kNan, -kNan, kInfinity, -kInfinity}) {
    SparseMatrix a = grid_2d(30, 30);
    a.values[a.offsets[700] + 2] = wrong;
    a.values[a.offsets[800]] = wrong;
    expect_refused(a.view(), "values", 700, a.columns[a.offsets[700] + 2]);

    SparseMatrix good = grid_2d(30, 30);
    Solver solver(with_threads(2));
    solver.factor(good.view());
    expect_invalid([&] { solver.refactor(a.view()); }, "values", 700, a.columns[a.offsets[700] + 2]);
    expect_invalid([&] { solver.refactor(a.values.data()); }, "values", 700, a.columns[a.offsets[700] + 2]);
    expect_invalid([&] { solver.factor(a.view()); }, "values", 700, a.columns[a.offsets[700] + 2]);
    expect_solves(solver, good);  // by the last good factorization
  }
}

TEST(Input, SumsThatOverflow) {
  const double huge = std::numeric_limits<double>::max();
  const SparseMatrix a = from_entries(3, {{0, 0, 1}, {1, 1, huge}, {1, 1, huge}, {2, 2, 1}});
  expect_refused(a.view(), "values", 1);
}

TEST(Input, RightHandSidesThatAreNoNumbers) {
  const SparseMatrix a = grid_2d(5, 5);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  for (const double wrong : {kNan, kInfinity, -kInfinity}) {
    std::vector<double> b(3 * 30, 1.0), x(3 * 25, 4.0);
    b[2 * 30 + 24] = wrong;
    b[30 + 27] = wrong;  // in the gap between columns: not looked at
    expect_invalid([&] { solver.solve(b.data(), x.data(), 3, 30); }, "b", 24, 2);
    expect_invalid([&] { solver.solve_transpose(b.data(), x.data(), 3, 30); }, "b", 24, 2);
    EXPECT_EQ(x, std::vector<double>(3 * 25, 4.0));
  }
  expect_usable(solver);
}

TEST(Input, LeadingDimensionsAndCounts) {
  const SparseMatrix a = grid_2d(5, 5);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  std::vector<double> b(100, 1.0), x(100);
  const auto refused = [&](std::int64_t nrhs, std::int64_t ldb, std::int64_t ldx,
                           const std::string& argument) {
    expect_invalid([&] { solver.solve(b.data(), x.data(), nrhs, ldb, ldx); }, argument);
    expect_invalid([&] { solver.solve_transpose(b.data(), x.data(), nrhs, ldb, ldx); }, argument);
  };
  refused(0, 25, 25, "nrhs");
  refused(-1, 25, 25, "nrhs");
  refused(2, 24, 25, "ldb");
  refused(2, -25, 25, "ldb");
  refused(2, 25, 24, "ldx");
  refused(1, 25, -1, "ldx");
  expect_usable(solver);
}

// Solutions of the first block would be right-hand sides of the next.
TEST(Input, SolutionsOverRightHandSides) {
  const SparseMatrix a = grid_2d(5, 5);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  constexpr std::int64_t kColumns = 20;
  std::vector<double> all(2 * 25 * (kColumns + 1), 1.0);
  double* const b = all.data() + 25;
  const auto refused = [&](const double* x, std::int64_t ldb, std::int64_t ldx) {
    const std::ptrdiff_t shift = x - all.data();
    expect_invalid([&] { solver.solve(b, all.data() + shift, kColumns, ldb, ldx); }, "x");
    expect_invalid([&] { solver.solve_transpose(b, all.data() + shift, kColumns, ldb, ldx); }, "x");
  };
  refused(b, 25, 50);
  refused(b, 26, 25);
  refused(b + 25, 25, 25);
  refused(b - 25, 25, 25);
  refused(b + 24, 50, 50);
  refused(b + 26, 50, 50);
  refused(b + 19 * 25, 25, 25);
  EXPECT_EQ(all, std::vector<double>(all.size(), 1.0));
  solver.solve(b, b + 25, kColumns - 1, 50, 50);  // columns of the two taking turns
  solver.solve(b, b, 1, 25, 50);
  expect_usable(solver);
}

TEST(Input, OptionsOutOfRange) {
  const auto refused = [](const std::string& argument, auto change) {
    Options options;
    change(options);
    expect_invalid([&] { Solver solver(options); }, argument);
  };
  refused("max_block_size", [](Options& o) { o.analysis.max_block_size = 0; });
  refused("leaf_size", [](Options& o) { o.analysis.leaf_size = 0; });
  refused("separator_trials", [](Options& o) { o.analysis.separator_trials = 0; });
  refused("separator_refinement", [](Options& o) { o.analysis.separator_refinement = 0; });
  for (const double rows : {0.0, -1.0, kNan})
    refused("dense_row", [=](Options& o) { o.analysis.dense_row = rows; });
  refused("threads", [](Options& o) { o.threads = -1; });
  refused("threads", [](Options& o) { o.threads = 513; });
  refused("analysis.threads", [](Options& o) { o.analysis.threads = -1; });
  refused("analysis.threads", [](Options& o) { o.analysis.threads = 513; });
  for (const double tolerance : {-1e-9, 1.0, kNan}) {
    refused("pivot_tolerance", [=](Options& o) { o.factor.pivot_tolerance = tolerance; });
  }
  for (const double tolerance : {-1e-9, kNan}) {
    refused("tolerance", [=](Options& o) { o.solve.tolerance = tolerance; });
  }
  for (const double part : {-1e-9, 1.01, kNan}) {
    refused("row_floor", [=](Options& o) { o.solve.row_floor = part; });
  }
  refused("memory_limit", [](Options& o) { o.memory_limit = -1; });
  refused("max_refinement_steps", [](Options& o) { o.solve.max_refinement_steps = -1; });
}

// Whether it is there or not.
TEST(Input, OptionsThatABackendCannotObey) {
  Options options;
  options.backend = Backend::cuda;
  options.analysis.max_block_size = 512;
  expect_invalid([&] { Solver solver(options); }, "max_block_size");
  for (const Backend backend : {Backend::serial, Backend::openmp}) {
    options.backend = backend;
    EXPECT_NO_THROW(Solver solver(options));
  }
  options = {};
  options.backend = Backend::kokkos;
  options.memory_limit = 1000000000;
  expect_invalid([&] { Solver solver(options); }, "memory_limit");
  options = {};
  options.out_of_core_dir = "/tmp";
  for (const Backend backend : {Backend::cuda, Backend::kokkos}) {
    options.backend = backend;
    expect_invalid([&] { Solver solver(options); }, "out_of_core_dir");
  }
}

TEST(Input, BackendThatIsNotThere) {
  for (const Backend backend : backends()) {
    if (backend == Backend::cuda) GTEST_SKIP() << "this build has CUDA";
  }
  Options options;
  options.backend = Backend::cuda;
  if (const auto error = failure_of<BackendError>([&] { Solver solver(options); })) {
    EXPECT_EQ(error->library(), "CUDA");
  }
}

TEST(Input, PermutationAndTreeOfTheCaller) {
  const SparseMatrix a = grid_2d(2, 2);
  const auto refused = [&](const std::string& argument, std::int64_t row, std::int64_t column, auto change) {
    Options options = with_threads(1);
    change(options.analysis);
    Solver solver(options);
    expect_invalid([&] { solver.analyze(a.view()); }, argument, row, column);
    EXPECT_FALSE(solver.analyzed());
    expect_invalid([&] { solver.factor(a.view()); }, argument, row, column);
  };
  refused("permutation", -1, -1, [](AnalysisOptions& o) { o.permutation = {0, 1, 2}; });
  refused("permutation", 2, -1, [](AnalysisOptions& o) { o.permutation = {0, 1, 4, 2}; });
  refused("permutation", 3, -1, [](AnalysisOptions& o) { o.permutation = {0, 1, 2, -1}; });
  refused("permutation", 2, -1, [](AnalysisOptions& o) { o.permutation = {0, 1, 1, 2}; });
  const auto tree = [](AnalysisOptions& o, std::vector<std::int64_t> offsets,
                       std::vector<std::int64_t> parent) {
    o.permutation = {0, 1, 2, 3};
    o.tree = {std::move(offsets), std::move(parent)};
  };
  refused("tree", -1, -1, [&](AnalysisOptions& o) { tree(o, {0, 4}, {1, -1}); });
  refused("tree", 0, -1, [&](AnalysisOptions& o) { tree(o, {1, 2, 4}, {1, -1}); });
  refused("tree", 1, -1, [&](AnalysisOptions& o) { tree(o, {0, 3, 2, 4}, {2, 2, -1}); });
  refused("tree", 1, -1, [&](AnalysisOptions& o) { tree(o, {0, 3, 5}, {1, -1}); });
  refused("tree", -1, -1, [&](AnalysisOptions& o) { tree(o, {0, 1, 3}, {1, -1}); });
  refused("tree", 1, -1, [&](AnalysisOptions& o) { tree(o, {0, 1, 4}, {1, 0}); });
  refused("tree", 0, -1, [&](AnalysisOptions& o) { tree(o, {0, 1, 4}, {0, -1}); });
  refused("tree", 0, -1, [&](AnalysisOptions& o) { tree(o, {0, 1, 4}, {2, -1}); });
  // Points 0 and 1 of the grid are neighbours: they cannot lie in unrelated branches.
  refused("tree", 0, 1, [&](AnalysisOptions& o) { tree(o, {0, 1, 2, 4}, {2, 2, -1}); });
}

}  // namespace
}  // namespace mfs::test
