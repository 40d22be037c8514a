// The caller's own elimination order and tree, and the options of the ordering.
#include <filesystem>
#include <iterator>
#include <numeric>
#include <string>

#include "test/reference/generators.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

TEST(Order, PermutationOfTheCaller) {
  for (const SparseMatrix& a : {grid_2d(12, 11), random_diagonally_dominant(120, 3, 1), arrow(60, 2)}) {
    for (const std::uint64_t seed : {1, 2}) {
      Options options = with_threads(1);
      options.analysis.permutation = Random(seed).permutation(a.n);
      Solver solver(options);
      solver.factor(a.view());
      expect_solves(solver, a);
    }
  }
}

TEST(Order, NaturalOrderOfATridiagonalMatrixHasNoFill) {
  const SparseMatrix a = tridiagonal(300);
  Options options = with_threads(1);
  options.analysis.permutation.resize(a.n);
  std::iota(options.analysis.permutation.begin(), options.analysis.permutation.end(), 0);
  Solver solver(options);
  solver.factor(a.view());
  expect_solves(solver, a);
  EXPECT_LE(solver.report().nnz_factor, 4 * a.entries());  // merged fronts store some zeros
}

// A 9 x 9 grid cut by its middle column, and each half by a row:
//   nodes 0..3: quarters, 4 and 5: rows between them, 6: the middle column
TEST(Order, TreeOfTheCaller) {
  const std::int64_t m = 9;
  const SparseMatrix a = grid_2d(m, m);
  std::vector<std::vector<std::int64_t>> nodes(7);
  for (std::int64_t i = 0; i < m; ++i) {
    for (std::int64_t j = 0; j < m; ++j) {
      const std::int64_t half = j > 4;
      const std::int64_t node = j == 4 ? 6 : i == 4 ? 4 + half : 2 * half + (i > 4);
      nodes[node].push_back(i * m + j);
    }
  }
  Options options = with_threads(2);
  options.analysis.tree.offsets.push_back(0);
  for (const auto& node : nodes) {
    options.analysis.permutation.insert(options.analysis.permutation.end(), node.begin(), node.end());
    options.analysis.tree.offsets.push_back(static_cast<std::int64_t>(options.analysis.permutation.size()));
  }
  options.analysis.tree.parent = {4, 4, 5, 5, 6, 6, -1};
  Solver solver(options);
  solver.factor(a.view());
  expect_solves(solver, a, 2);
  EXPECT_EQ(solver.report().fronts, 7);
  EXPECT_EQ(solver.report().depths, 3);
  const std::vector<DepthSummary> depths = solver.depths();
  ASSERT_EQ(depths.size(), 3u);
  EXPECT_EQ(depths[0].pivots, 9);
  EXPECT_EQ(depths[0].max_front, 9);
  EXPECT_EQ(depths[1].fronts, 2);
  EXPECT_EQ(depths[1].pivots, 8);
  EXPECT_EQ(depths[1].max_front, 4 + 9);
  EXPECT_EQ(depths[2].fronts, 4);
  EXPECT_EQ(depths[2].pivots, 64);
  EXPECT_EQ(depths[2].max_front, 16 + 4 + 4);  // a quarter touches four points of the row and of the column
}

TEST(Order, EveryOptionStillSolves) {
  const SparseMatrix a = grid_2d(30, 31);
  const auto solves = [&](auto change) {
    Options options = with_threads(2);
    change(options);
    Solver solver(options);
    solver.factor(a.view());
    expect_solves(solver, a);
  };
  for (const std::int32_t size : {1, 7, 64, 1 << 30})
    solves([&](Options& o) { o.analysis.max_block_size = size; });
  for (const std::int32_t size : {1, 30, 1 << 30}) solves([&](Options& o) { o.analysis.leaf_size = size; });
  for (const double rows : {1e-3, 1e9}) solves([&](Options& o) { o.analysis.dense_row = rows; });
  for (const Matching matching : {Matching::always, Matching::never}) {
    for (const bool scaling : {false, true}) {
      solves([&](Options& o) {
        o.analysis.matching = matching;
        o.analysis.scaling = scaling;
      });
    }
  }
  solves([](Options& o) { o.analysis.separator_trials = 1; });
  solves([](Options& o) { o.analysis.seed = -1; });
  solves([](Options& o) { o.backend = Backend::serial; });
  solves([](Options& o) { o.factor.pivot_tolerance = 1e-3; });
}

TEST(Order, SingleUnknownsBesideDenseRows) {
  const std::int64_t n = 20000;  // a quadratic ordering would not come back
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i)
    entries.push_back({i, i, 4.0 + (i + 1 == n ? 4.0 * static_cast<double>(n) : 0)});
  for (std::int64_t i = 0; i + 1 < n; ++i) {
    entries.push_back({n - 1, i, 1.0});
    entries.push_back({i, n - 1, 1.0});
  }
  const SparseMatrix a = from_entries_summed(n, entries);
  Solver solver(with_threads(2));
  solver.factor(a.view());
  expect_solves(solver, a);
  EXPECT_LT(solver.report().nnz_factor, 40 * n);
}

/// Of this process, those included that wait for the next parallel region.
std::ptrdiff_t threads_of_process() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return std::distance(begin(tasks), end(tasks));
}

TEST(Order, TheAnalysisMayHaveThreadsOfItsOwn) {
  const SparseMatrix a = grid_2d(80, 80);
  Solver few(with_threads(2));
  few.factor(a.view());
  const std::ptrdiff_t before = threads_of_process();
  Options options = with_threads(2);
  options.analysis.threads = 7;
  Solver solver(options);
  solver.analyze(a.view());
  EXPECT_EQ(threads_of_process(), before + 5);
  solver.factor(a.view());
  expect_solves(solver, a, 2);
  EXPECT_EQ(solver.report().threads, 2);
}

}  // namespace
}  // namespace mfs::test
