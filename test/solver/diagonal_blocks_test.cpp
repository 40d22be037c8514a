// Matrices that have a block triangular form: only the blocks on its diagonal are factored.
#include <cmath>
#include <filesystem>
#include <string>

#include "test/reference/generators.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

std::vector<std::int64_t> several(std::size_t count, std::int64_t size) {
  return std::vector<std::int64_t>(count, size);
}

/// These on the diagonal, and below it entries that couple each row to one of the blocks before.
SparseMatrix coupled(const std::vector<SparseMatrix>& blocks, double size, Random& random) {
  std::vector<Entry> entries;
  std::int64_t begin = 0;
  for (const SparseMatrix& block : blocks) {
    for (const Entry& e : entries_of(block)) entries.push_back({begin + e.row, begin + e.column, e.value});
    for (std::int64_t i = 0; i < block.n && begin > 0; ++i)
      entries.push_back({begin + i, random.integer(0, begin), size * random.entry()});
    begin += block.n;
  }
  return from_entries_summed(begin, std::move(entries));
}

template <class Scalar>
class DiagonalBlocksOf : public testing::Test {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(DiagonalBlocksOf, Scalars);

TYPED_TEST(DiagonalBlocksOf, AreFactoredAlone) {
  for (const std::vector<std::int64_t>& sizes :
       {several(2, 1), several(300, 20), several(5000, 1), std::vector<std::int64_t>{700, 3, 700, 90}}) {
    const auto a = in_scalar<TypeParam>(permuted_blocks(sizes, 11));
    for (const int threads : {1, 2, 4}) {
      SCOPED_TRACE(std::to_string(sizes.size()) + " blocks, " + std::to_string(threads) + " threads");
      BasicSolver<TypeParam> solver(with_threads(threads));
      solver.factor(a.view());
      EXPECT_EQ(solver.report().diagonal_blocks, static_cast<std::int64_t>(sizes.size()));
      EXPECT_EQ(solver.report().rung, Rung::factors);
      expect_solves(solver, a);
      EXPECT_EQ(solver.report().rung, Rung::factors);
      EXPECT_EQ(solver.report().bytes_used, solver.report().bytes_peak);
      expect_solves(solver, a, 16);
      BasicSparseMatrix<TypeParam> other = a;
      Random random(4);
      for (TypeParam& value : other.values) value *= static_cast<TypeParam>(1 + 0.1 * random.entry());
      solver.refactor(other.values.data());
      expect_solves(solver, other, 3);
    }
  }
}

TEST(DiagonalBlocks, TakeAPartOfTheOperationsOfTheWhole) {
  const SparseMatrix a = permuted_blocks(several(300, 20), 11);
  Options as_one = with_threads(1);
  as_one.out_of_core_dir = std::filesystem::temp_directory_path();  // factors in a file come once a solve
  Solver solver(with_threads(1)), whole(as_one);
  solver.factor(a.view());
  whole.factor(a.view());
  EXPECT_EQ(whole.report().diagonal_blocks, 1);
  expect_solves(whole, a, 3);
  EXPECT_LT(20 * solver.report().flops.total(), whole.report().flops.total());
}

TEST(DiagonalBlocks, AreLeftToOrdersOfTheCaller) {
  const SparseMatrix a = permuted_blocks(several(30, 5), 12);
  Options options = with_threads(1);
  options.analysis.permutation = Random(3).permutation(a.n);
  Solver ordered(options);
  ordered.factor(a.view());
  EXPECT_EQ(ordered.report().diagonal_blocks, 1);
  expect_solves(ordered, a);
}

// As what fixes values at the edge of a grid does.
TEST(DiagonalBlocks, AreLeftToOneThreadWhereOneHasMost) {
  const SparseMatrix one = permuted_blocks({50, 3, 4, 40}, 13);
  for (const int threads : {1, 2}) {
    Solver solver(with_threads(threads));
    solver.factor(one.view());
    EXPECT_EQ(solver.report().diagonal_blocks, threads == 1 ? 4 : 1);
    expect_solves(solver, one);
    expect_solves(solver, one, 3);
    const SparseMatrix grid = grid_2d(9, 9);
    solver.analyze(grid.view());
    solver.factor(grid.view());
    EXPECT_EQ(solver.report().diagonal_blocks, 1);
    expect_solves(solver, grid);
  }
}

// Pivots that fail move to the roots of their own blocks.
TEST(DiagonalBlocks, WithPivotsThatMove) {
  Random random(5);
  std::vector<SparseMatrix> blocks;
  for (std::uint64_t k = 0; k < 12; ++k)
    blocks.push_back(adversarial_matrix("saddle point renumbered", 1 + k));
  const SparseMatrix a = coupled(blocks, 0.1, random);
  Options options = with_threads(1);
  options.analysis.matching = Matching::never;
  Solver solver(options);
  solver.factor(a.view());
  EXPECT_GE(solver.report().diagonal_blocks, 12);
  EXPECT_GT(solver.report().reanalyses, 0) << "no pivot moved";
  expect_solves(solver, a, 2);
}

TEST(DiagonalBlocks, OneThatIsSingularIsSaidToBe) {
  Random random(6);
  std::vector<SparseMatrix> blocks(5, grid_2d(6, 5));
  std::vector<Entry> entries = entries_of(blocks[3]);
  for (Entry& e : entries) e.value = e.row == 7 ? 0 : e.value;
  for (const Entry& e : entries_of(blocks[3])) {  // row 7 twice row 8
    if (e.row == 8) entries.push_back({7, e.column, 2 * e.value});
  }
  blocks[3] = from_entries_summed(30, entries);
  const SparseMatrix a = coupled(blocks, 0.1, random);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  EXPECT_EQ(solver.report().diagonal_blocks, 5);
  const std::vector<double> b = Random(7).vector(a.n);
  std::vector<double> x(b.size());
  EXPECT_THROW(solver.solve(b.data(), x.data()), SingularMatrix);
  const SparseMatrix regular = coupled(std::vector<SparseMatrix>(5, grid_2d(6, 5)), 0.1, random);
  solver.analyze(regular.view());
  solver.factor(regular.view());
  expect_solves(solver, regular);
}

// By rows and columns that are exchanged and pivots of several blocks: (-1)^k 2 3 5 7 11 13 ...
TEST(DiagonalBlocks, DeterminantAndCondition) {
  const std::int64_t n = 12;
  const double primes[] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
  for (std::uint64_t seed = 1; seed < 9; ++seed) {
    Random random(seed);
    const std::vector<std::int64_t> row = random.permutation(n), column = random.permutation(n);
    std::vector<Entry> entries;
    double log_abs = 0, sign = 1;
    for (std::int64_t i = 0; i < n; ++i) {
      entries.push_back({row[i], column[i], primes[i]});
      log_abs += std::log(primes[i]);
      for (std::int64_t j = 0; j < i; ++j) {
        if (random.chance(0.3)) entries.push_back({row[i], column[j], random.entry()});
        if ((row[j] > row[i]) != (column[j] > column[i])) sign = -sign;
      }
    }
    const SparseMatrix a = from_entries_summed(n, std::move(entries));
    Solver solver(with_threads(1));
    solver.factor(a.view());
    if (solver.report().diagonal_blocks == 1) continue;  // nothing below the diagonal
    EXPECT_EQ(solver.report().diagonal_blocks, n);
    EXPECT_NEAR(solver.determinant().log_abs, log_abs, 1e-12);
    EXPECT_EQ(solver.determinant().phase, sign) << "seed " << seed;
    // |A|_1 |A^-1|_1 by solving for each column of the identity.
    double norm = 0, inverse_norm = 0;
    for (std::int64_t j = 0; j < n; ++j) {
      std::vector<double> unit(static_cast<std::size_t>(n), 0.0), x(unit);
      unit[static_cast<std::size_t>(j)] = 1;
      double sum = 0;
      for (const double value : multiply(a, unit)) sum += std::abs(value);
      norm = std::max(norm, sum);
      solver.solve(unit.data(), x.data());
      sum = 0;
      for (const double value : x) sum += std::abs(value);
      inverse_norm = std::max(inverse_norm, sum);
    }
    EXPECT_LE(solver.condition_estimate(), 1.001 * norm * inverse_norm);
    EXPECT_GE(solver.condition_estimate(), 0.3 * norm * inverse_norm);
  }
}

}  // namespace
}  // namespace mfs::test
