// All stages on the device against the plain reference: factors, exchanges and shifts of fronts of all kinds
// of sizes, then the solve. Needs a device; skips where there is none.
#include <numeric>
#include <string>

#include "kernels/cuda/cuda_factors.hpp"
#include "kernels/cuda/device_stages.hpp"
#include "kernels/cuda/runtime/device.hpp"
#include "test/stages/device_checks.hpp"
#include "test/stages/on_device.hpp"
#include "test/stages/weak_pivots.hpp"

namespace mfs::test {
namespace {

/// Trees in which every kernel has many fronts side by side: solved with by a warp, factored in shared
/// memory, of a few tiles.
std::vector<FrontShape> many_fronts() {
  std::vector<FrontShape> shapes;
  for (Vertex k = 0; k < 150; ++k) shapes.push_back({1 + k % 20, k % 41, 196 + k % 8});
  for (Vertex k = 0; k < 40; ++k) shapes.push_back({20 + k, (7 * k) % 90, 196 + k % 8});
  for (Vertex k = 0; k < 6; ++k) shapes.push_back({33 + 25 * k, 60 + 11 * k, 196 + k});
  for (Vertex k = 0; k < 8; ++k) shapes.push_back({100 + 20 * k, 150 - 9 * k, 204});
  shapes.push_back({310, 0, -1});
  return shapes;
}

/// So many tiny fronts at one depth that a warp takes each, groups of its lanes some columns each.
std::vector<FrontShape> many_tiny_fronts() {
  std::vector<FrontShape> shapes;
  const Vertex many = DeviceLimits().many_tiny;
  for (Vertex k = 0; k < many; ++k) shapes.push_back({1 + k % 4, k % 30, many});
  shapes[7] = {32, 64, many};
  std::size_t place = 8;
  for (const Vertex pivots : {7, 8, 9, 15, 16, 17, 31})
    for (const Vertex border : {0, 7, 8, 9, 17, 33}) shapes[place++] = {pivots, border, many};
  shapes.push_back({70, 0, -1});
  return shapes;
}

std::vector<StageProblem<double>> trees() {
  return {artificial_problem(mixed_tree(), {1, 1.0}),
          artificial_problem(mixed_tree(), {2, 0.2}),
          artificial_problem(broom(), {3, 0.5}),
          artificial_problem(chain(), {4, 0.7}),
          artificial_problem(leaf_and_root(400, 450), {5}),
          artificial_problem(many_fronts(), {6, 0.3}),
          artificial_problem(fork(), {12, 0.1, 64, kAssemblyTurns}),
          artificial_problem(crowd(), {13, 0.2}),
          artificial_problem(leaf_and_root(400, 450), {14, 1.0, 64, {}, 0.97}),
          artificial_problem(many_fronts(), {15, 0.3, 64, {}, 0.97})};
}

/// Fronts whose tiles are cut into parts by the solve, with and without a step that is left over.
std::vector<StageProblem<double>> long_borders() {
  const Vertex kPart = kSolveTile * DeviceLimits().solve_steps;
  return {artificial_problem(leaf_and_root(65, kPart), {10, 0.5}),
          artificial_problem(leaf_and_root(33, kPart + 70), {11, 0.5})};
}

template <class Scalar>
class DeviceStagesTest : public OnDeviceTest {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(DeviceStagesTest, Scalars);

TYPED_TEST(DeviceStagesTest, FactorsFrontsOfAllSizes) {
  this->on_device([&] {
    for (const Vertex p : {1, 2, 31, 32, 33, 64, 65, 127, 128, 129, 257}) {
      for (const Vertex b : {0, 1, 31, 32, 33, 65, 257}) {
        for (const double kept : {0.0, 1.0}) {
          SCOPED_TRACE(std::to_string(p) + " pivots, border " + std::to_string(b) + ", of the large ones " +
                       std::to_string(kept) + " on the diagonal");
          const std::uint64_t seed = 1000 * p + b;
          check_regular<TypeParam>(artificial_problem(leaf_and_root(p, b), {seed, 1.0, 64, {}, kept}));
          if (this->HasFailure()) return;
        }
      }
    }
  });
}

TYPED_TEST(DeviceStagesTest, FactorsTrees) {
  this->on_device([&] {
    for (const StageProblem<double>& problem : trees()) {
      SCOPED_TRACE("n = " + std::to_string(problem.plan->n));
      check_regular<TypeParam>(problem);
    }
  });
}

/// Solves against the reference, for factors that are its own but for rounding.
template <class Scalar>
void check_solves(DeviceBench<Scalar>& bench, const std::vector<ReferenceFront<Scalar>>& reference,
                  Vertex n) {
  const double growth = growth_of(reference);
  for (const Vertex columns : {1, 3, 4, 5, 16, 17}) {
    const std::vector<Scalar> v = Random(77).vector<Scalar>(static_cast<std::int64_t>(n) * columns);
    for (const bool transposed : {false, true}) {
      SCOPED_TRACE(std::to_string(columns) + " columns" + (transposed ? ", transposed" : ""));
      std::vector<Scalar> y, x;
      for (Vertex j = 0; j < columns; ++j) {
        std::vector<Scalar> column(v.begin() + static_cast<Offset>(j) * n,
                                   v.begin() + static_cast<Offset>(j + 1) * n);
        solve_forward(reference, transposed, column);
        y.insert(y.end(), column.begin(), column.end());
        solve_backward(reference, transposed, column);
        x.insert(x.end(), column.begin(), column.end());
      }
      const Substitution<Scalar> actual = bench.solve(columns, v, transposed);
      const double tolerance = growth * kDeviceTolerance<Scalar>;
      EXPECT_LT(difference(actual.y, y), tolerance) << "forward";
      EXPECT_LT(difference(actual.x, x), tolerance) << "backward";
      if (testing::Test::HasFailure()) return;
    }
  }
}

TYPED_TEST(DeviceStagesTest, SolvesAsTheReferenceDoes) {
  this->on_device([&] {
    std::vector<StageProblem<double>> problems = trees();
    problems.push_back(artificial_problem(many_tiny_fronts(), {8, 0.5}));
    for (StageProblem<double>& problem : long_borders()) problems.push_back(std::move(problem));
    for (const Vertex p : {1, 32, 33, 64, 65, 129}) {
      for (const Vertex b : {0, 1, 64, 65, 100})
        problems.push_back(artificial_problem(leaf_and_root(p, b), {7}));
    }
    const double tolerance = default_tolerance<TypeParam>();
    for (const StageProblem<double>& of_doubles : problems) {
      for (const TinyPivots tiny : {TinyPivots::noise, TinyPivots::data}) {  // by inverses, by substitution
        SCOPED_TRACE("n = " + std::to_string(of_doubles.plan->n));
        const StageProblem<TypeParam> problem = in_numbers_of<TypeParam>(of_doubles);
        DeviceBench<TypeParam> bench(problem);
        bench.factor({tolerance, tiny, kBorderThreshold});
        const auto reference = followed(problem, bench, tolerance);
        expect_reference(problem, bench, reference);
        check_solves(bench, reference, problem.plan->n);
        if (this->HasFailure()) return;
      }
    }
  });
}

TYPED_TEST(DeviceStagesTest, GivesTheSameBitsFromRunToRunAndFromTheGraph) {
  this->on_device([&] {
    std::vector<StageProblem<double>> problems = trees();
    for (StageProblem<double>& problem : long_borders()) problems.push_back(std::move(problem));
    for (const StageProblem<double>& of_doubles : problems) {
      const StageProblem<TypeParam> problem = in_numbers_of<TypeParam>(of_doubles);
      const std::vector<TypeParam> v = Random(5).vector<TypeParam>(Offset(5) * problem.plan->n);
      DeviceBench<TypeParam> bench(problem), other(problem);
      bench.factor(1e-4);
      const FactoredFronts<TypeParam> first = bench.as_left();
      const Substitution<TypeParam> solution = bench.solve(5, v, false);
      other.factor(1e-4);
      expect_same_bits(other.as_left(), first);
      EXPECT_TRUE(other.solve(5, v, false).x == solution.x);
      // Which fronts are strict depends on what was factored before.
      for (const Launches launches : {Launches::direct, Launches::recorded, Launches::recorded}) {
        bench.factor(1e-4, launches);
        other.factor(1e-4);
        expect_same_bits(bench.as_left(), other.as_left());
        const Substitution<TypeParam> again = bench.solve(5, v, false, launches),
                                      expected = other.solve(5, v, false);
        EXPECT_TRUE(again.x == expected.x);
        EXPECT_TRUE(again.y == expected.y);
      }
    }
  });
}

// A graph is recorded once and replayed for other values.
TYPED_TEST(DeviceStagesTest, FactorsOtherValues) {
  this->on_device([&] {
    StageProblem<TypeParam> problem = in_numbers_of<TypeParam>(artificial_problem(mixed_tree(), {8, 0.6}));
    DeviceBench<TypeParam> bench(problem);
    bench.factor(default_tolerance<TypeParam>());
    for (const double factor : {-3.0, 0.125}) {
      for (TypeParam& value : problem.values) value *= RealOf<TypeParam>(factor);
      bench.put_values(problem.values);
      bench.factor(default_tolerance<TypeParam>(), Launches::recorded);
      expect_reference(problem, bench, followed(problem, bench, default_tolerance<TypeParam>()));
    }
  });
}

// A zero pivot block: every pivot is replaced, whatever the border. Replaced by sqrt(eps) times the largest
// entry, they leave 1 / (sqrt(eps) corner) in the border: in single precision that would drown a corner of 1,
// and with it which of the border's pivots is the largest.
TYPED_TEST(DeviceStagesTest, ReplacesZeroPivots) {
  this->on_device([&] {
    for (const Vertex p : {1, 2, 33, 150}) {
      for (const Vertex b : {0, 1, 70}) {
        SCOPED_TRACE(std::to_string(p) + " pivots, border " + std::to_string(b));
        const auto problem = in_numbers_of<TypeParam>(zero_pivot_block(p, b, 64, 100.0));
        if (b > 0) {
          EXPECT_GE(check_weak(problem, default_tolerance<TypeParam>()).perturbed,
                    static_cast<unsigned long long>(p));
        }
      }
    }
  });
}

TYPED_TEST(DeviceStagesTest, CountsPivotsThatAreNoNumbers) {
  this->on_device([&] {
    for (const double bad : {std::numeric_limits<double>::infinity(), std::nan("")}) {
      for (const Vertex p : {3, 140, 300}) {
        StageProblem<double> of_doubles = artificial_problem(leaf_and_root(p, 40), {9});
        of_doubles.values[of_doubles.values.size() / 2] = bad;
        const auto problem = turned<TypeParam>(of_doubles);
        DeviceBench<TypeParam> bench(problem);
        EXPECT_GT(bench.factor(default_tolerance<TypeParam>()).nonfinite, 0u)
            << bad << ", " << p << " pivots";
      }
    }
  });
}

// Nothing is there (the pivot would be replaced), or so little that the multipliers would grow. Panels of
// 900 rows of complex numbers are too large for shared memory.
TYPED_TEST(DeviceStagesTest, SearchesFurtherWhereTheTileHasNoPivots) {
  this->on_device([&] {
    for (const auto& [p, own] : {std::pair<Vertex, double>{300, 0.0}, {300, 1e-3}, {900, 0.0}}) {
      SCOPED_TRACE(std::to_string(p) + " pivots, entries of size " + std::to_string(own));
      const StageProblem<TypeParam> problem = turned<TypeParam>(pivots_below_the_tile(p, 128, own));
      DeviceBench<TypeParam> bench(problem);
      const FactorStatus status = bench.factor(default_tolerance<TypeParam>());
      EXPECT_GT(bench.passes(), 1);
      EXPECT_EQ(bench.strict()[0], 1);
      EXPECT_EQ(status.perturbed, 0u);
      expect_reference(problem, bench, followed(problem, bench, default_tolerance<TypeParam>()));
      bench.factor(default_tolerance<TypeParam>(), Launches::recorded);
      EXPECT_EQ(bench.passes(), 1) << "the front stays strict";
      expect_reference(problem, bench, followed(problem, bench, default_tolerance<TypeParam>()));
    }
  });
}

/// What a column of the pivot block has on its diagonal and in one row below, and what its own row has there.
struct WeakPivot {
  Vertex column, row;
  double own, below, right = 1;
};
/// A front of p pivots, all of them large and alone in their column but that one and its partner, the row's.
StageProblem<double> pivot_beside_larger_one(Vertex p, Vertex b, const WeakPivot& weak, std::uint64_t seed,
                                             double large = 80) {
  Random random(seed);
  std::vector<Entry> entries;
  for (Vertex i = 0; i < p; ++i) {
    for (Vertex j = 0; j < p; ++j) {
      const bool of_the_pair = (i == weak.column || i == weak.row) && (j == weak.column || j == weak.row);
      const double entry = i == weak.column && j == weak.column ? weak.own
                           : i == weak.row && j == weak.column  ? weak.below
                           : i == weak.column && j == weak.row  ? weak.right
                           : of_the_pair                        ? 1.0
                           : i == j                             ? large
                                                                : 0.0;
      entries.push_back({i, j, entry});
    }
    for (Vertex j = p; j < p + b; ++j) {
      entries.push_back({i, j, random.entry()});
      entries.push_back({j, i, random.entry()});
    }
  }
  for (Vertex j = p; j < p + b; ++j) entries.push_back({j, j, 80.0});
  return two_fronts(p, b, entries, 64);
}

// A multiplier just below and just above 10, 1 / kDiagonalThreshold, in a row of the same panel or below it,
// in wide and narrow panels of small fronts and of tiles; no pivot at all; one below the bound, 1e-3 of the
// largest entry; and an entry of U's scaled inverse, if it is of the panel, just below and just above 100,
// kMostInverse.
TYPED_TEST(DeviceStagesTest, KeepsPivotsOnTheDiagonalUnlessMultipliersGrow) {
  struct Case {
    Vertex pivots, column, row;
  };
  struct Entries {
    double own, below, right;
  };
  constexpr Vertex border = 20, panel = 16;
  this->on_device([&] {
    for (const auto& [p, c, r] : {Case{2, 0, 1},
                                  {20, 17, 19},
                                  {30, 0, 29},
                                  {40, 20, 30},
                                  {70, 3, 68},
                                  {70, 66, 69},
                                  {300, 0, 1},
                                  {300, 15, 40},
                                  {300, 16, 60},
                                  {300, 33, 36},
                                  {300, 47, 50},
                                  {300, 257, 299},
                                  {300, 290, 297}}) {
      for (const auto& [own, below, right] :
           {Entries{1, 9.9, 1}, {1, 10.1, 1}, {0, 1, 1}, {0.04, 0.2, 1}, {1, 2, 99}, {1, 2, 101}}) {
        SCOPED_TRACE(std::to_string(p) + " pivots, column " + std::to_string(c) + ": " + std::to_string(own) +
                     ", row " + std::to_string(r) + ": " + std::to_string(below) + ", right " +
                     std::to_string(right));
        const auto problem =
            turned<TypeParam>(pivot_beside_larger_one(p, border, {c, r, own, below, right}, 33));
        DeviceBench<TypeParam> bench(problem);
        // The diagonal is only compared with the rows of its tile; fronts are small or not by the device's
        // memory.
        if (p + border > bench.small_rows() && c / bench.tile() != r / bench.tile()) continue;
        EXPECT_EQ(bench.factor(1e-3).perturbed, 0u);
        std::vector<Vertex> expected(p);
        for (Vertex i = 0; i < p; ++i) expected[i] = i;
        const bool kept = below == 9.9 || right == 99 || (right == 101 && c / panel != r / panel);
        if (!kept || p + border <= kOneWarpRows) std::swap(expected[c], expected[r]);
        EXPECT_EQ(bench.factored().row_at[0], expected);
        expect_reference(problem, bench, followed(problem, bench, 1e-3));
        if (this->HasFailure()) return;
      }
    }
  });
}

// Just below and just above 1000, kMostGrowth of kernels/cuda/factor/block_lu.hpp.
TYPED_TEST(DeviceStagesTest, SearchesFurtherOnlyWhereMultipliersGrowTooMuch) {
  this->on_device([&] {
    for (const auto& [growth, strict] : {std::pair<double, int>{999, 0}, {1001, 1}}) {
      SCOPED_TRACE("growth " + std::to_string(growth));
      // The last row of the pivot block is below the tile of the first.
      const auto problem = turned<TypeParam>(pivot_beside_larger_one(300, 50, {0, 299, 1.0, growth}, 32));
      DeviceBench<TypeParam> bench(problem);
      const FactorStatus status = bench.factor(default_tolerance<TypeParam>());
      EXPECT_EQ(bench.passes(), 1 + strict);
      EXPECT_EQ(bench.strict()[0], strict);
      EXPECT_EQ(status.perturbed, 0u);
      expect_reference(problem, bench, followed(problem, bench, default_tolerance<TypeParam>()));
    }
  });
}

// Beside small roots, with several of them, and with children; then solves by them, direct and recorded.
TYPED_TEST(DeviceStagesTest, TheLibraryFactorsRoots) {
  constexpr Vertex least = 200;
  this->on_device([&] {
    const std::vector<std::vector<FrontShape>> forests = {
        {{200, 0, -1}},
        {{150, 220, 1}, {257, 0, -1}},
        {{30, 25, 2}, {20, 40, 3}, {301, 0, -1}, {450, 0, -1}, {40, 0, -1}, {7, 0, -1}}};
    for (const auto& shapes : forests) {
      SCOPED_TRACE(std::to_string(shapes.size()) + " fronts");
      const auto problem = in_numbers_of<TypeParam>(artificial_problem(shapes, {18, 1.0, 64, {}, 1.0}));
      DeviceBench<TypeParam> bench(problem, least);
      const double tolerance = default_tolerance<TypeParam>();
      EXPECT_EQ(bench.factor(tolerance).perturbed, 0u);
      EXPECT_EQ(bench.passes(), 1);
      ASSERT_TRUE(bench.library_roots());
      const auto reference = followed(problem, bench, tolerance);
      expect_reference(problem, bench, reference);
      check_solves(bench, reference, problem.plan->n);
      const FactoredFronts<TypeParam> direct = bench.as_left();
      bench.factor(tolerance, Launches::recorded);
      expect_same_bits(bench.as_left(), direct);
      if (this->HasFailure()) return;
    }
  });
}

// A multiplier just below and just above 100, kMostUnpivoted of kernels/cuda/factor/unpivoted_roots.hpp, in
// the pivot's own tile and below it; a pivot of zero, one just below and just above the tolerance; no number.
// Above, tiles factor the root as they do without the library.
TYPED_TEST(DeviceStagesTest, TilesFactorRootsThatNeedPivots) {
  struct Case {
    Vertex column, row;
    double own, below;
    bool library;
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), tolerance = 1e-3;
  this->on_device([&] {
    for (const auto& [c, r, own, below, library] : {Case{5, 9, 1, 99, true},
                                                    {5, 9, 1, 101, false},
                                                    {5, 290, 1, 99, true},
                                                    {5, 290, 1, 101, false},
                                                    {140, 299, 0.5, 49, true},
                                                    {140, 299, 0.5, 51, false},
                                                    {290, 299, 1, 101, false},
                                                    {7, 20, 0, 1, false},
                                                    {7, 20, 0.102, 0.2, true},
                                                    {7, 20, 0.098, 0.2, false},
                                                    {260, 270, nan, 1, false}}) {
      SCOPED_TRACE("column " + std::to_string(c) + ": " + std::to_string(own) + ", row " + std::to_string(r) +
                   ": " + std::to_string(below));
      const auto problem = turned<TypeParam>(pivot_beside_larger_one(300, 0, {c, r, own, below}, 34, 100));
      DeviceBench<TypeParam> bench(problem, 300);
      const FactorStatus status = bench.factor(tolerance);
      EXPECT_EQ(bench.library_roots(), library);
      if (std::isnan(own)) {
        EXPECT_GT(status.nonfinite, 0u);
        continue;
      }
      EXPECT_EQ(bench.passes(), library ? 1 : 2);
      EXPECT_EQ(status.perturbed, 0u);
      expect_reference(problem, bench, followed(problem, bench, tolerance));
      if (library) continue;
      DeviceBench<TypeParam> tiles(problem);
      tiles.factor(tolerance);
      expect_same_bits(bench.as_left(), tiles.as_left());
    }
  });
}

/// In single precision, what rounding leaves of a weak pivot is not far enough from what is replaced.
template <class Scalar>
class DevicePivotsTest : public DeviceStagesTest<Scalar> {};
using DoubleScalars = testing::Types<double, std::complex<double>>;
TYPED_TEST_SUITE(DevicePivotsTest, DoubleScalars);

TYPED_TEST(DevicePivotsTest, ReplacesWhatIsBeyondTheRank) {
  this->on_device([&] {
    for (const Vertex p : {20, 90, 140, 300}) {
      for (const std::uint64_t seed : {1, 2}) {
        SCOPED_TRACE(std::to_string(p) + " pivots, seed " + std::to_string(seed));
        const Vertex rank = p * 7 / 8;
        const auto problem = turned<TypeParam>(low_rank_pivot_block(seed, p, rank, 30, 64, 50.0));
        DeviceBench<TypeParam> bench(problem);
        bench.factor(1e-8);
        const FactoredFronts<TypeParam> result = bench.factored();
        for (Vertex i = 0; i < p; ++i)
          EXPECT_EQ(result.shift[0][i] != TypeParam(0), i >= rank) << "pivot " << i;
        followed(problem, bench, 1e-8);
        expect_exact_factors(problem, result, Measure::row);
      }
    }
  });
}

// With a tolerance above the root of epsilon, what lies between is compared with its border.
TYPED_TEST(DevicePivotsTest, JudgesSuspectPivotsByTheirBorder) {
  this->on_device([&] {
    for (const std::uint64_t seed : {11, 12, 13, 14}) {
      for (const double tolerance : {1.5e-8, 1e-4}) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", tolerance " + std::to_string(tolerance));
        StageProblem<double> of_doubles = seed == 14 ? artificial_problem(leaf_and_root(300, 70), {seed})
                                                     : artificial_problem(mixed_tree(), {seed, 0.5, 32});
        weaken_rows(of_doubles, seed);
        EXPECT_GT(check_weak(in_numbers_of<TypeParam>(of_doubles), tolerance).perturbed, 0u);
      }
    }
  });
}

// Too large for the plain reference: the solution tells.
void check_large_front(Vertex pivots, Vertex border) {
  if (!cuda::device_found()) GTEST_SKIP() << "no CUDA device";
  in_engine(1, [&] {
    Engine::use_cuda();
    const StageProblem<double> problem =
        artificial_problem({{150, 170, 1}, {pivots, border, 2}, {border + 100, 0, -1}}, {41, 0.02});
    const Vertex n = problem.plan->n;
    DeviceBench<double> bench(problem);
    bench.factor(1.5e-8);
    for (const bool transposed : {false, true}) {
      const std::vector<double> v = Random(3).vector(n);
      const std::vector<double> x = bench.solve(1, v, transposed).x;
      const std::vector<Vertex> row = inverse(problem.plan->row_of),
                                column = inverse(problem.plan->column_of);
      std::vector<double> left = v, size(n, 0.0);
      for (Vertex i = 0; i < n; ++i) {
        for (Offset k = problem.pattern->offsets[i]; k < problem.pattern->offsets[i + 1]; ++k) {
          const Vertex j = problem.pattern->columns[k], to = transposed ? column[j] : row[i];
          const double term = problem.values[k] * problem.row_scale[i] * problem.column_scale[j] *
                              x[transposed ? row[i] : column[j]];
          left[to] -= term;
          size[to] += std::abs(term);
        }
      }
      double worst = 0;
      for (Vertex i = 0; i < n; ++i) {
        if (!(std::abs(left[i]) <= worst * (size[i] + std::abs(v[i]))))
          worst = std::isfinite(left[i]) ? std::abs(left[i]) / (size[i] + std::abs(v[i])) : HUGE_VAL;
      }
      EXPECT_LT(worst, 1e-12) << (transposed ? "transposed" : "plain");
    }
  });
}

const DeviceLimits kSizes;

TEST(DeviceStages, FactorsFrontsInSlabs) {
  check_large_front(kSizes.slab + 130, kSizes.panelled_rows - kSizes.slab);
}

TEST(DeviceStages, FactorsLargeStepsBesideTheNextTile) {
  check_large_front(kSizes.slab + 130, 400);
}

// Pieces of any size, some beyond the end of a half and of both; each changes as soon as it is taken.
TEST(DeviceUpload, BringsMoreThanItsMemoryHolds) {
  if (!cuda::device_found()) GTEST_SKIP() << "no CUDA device";
  in_engine(2, [&] {
    Engine::use_cuda();
    constexpr Offset kMegabyte = 1 << 20;
    for (const auto& pieces : std::vector<std::vector<Offset>>{
             {3}, {1, 0, 100}, {8 * kMegabyte - 50, 7, 100, 20 * kMegabyte + 1, 0, 12 * kMegabyte, 5}}) {
      const Offset bytes = std::accumulate(pieces.begin(), pieces.end(), Offset(0));
      std::vector<char> expected(bytes), piece, brought(bytes);
      for (Offset k = 0; k < bytes; ++k) expected[k] = static_cast<char>(k % 251);
      const cuda::Stream stream;
      const cuda::DeviceArena place(bytes);
      {
        cuda::Upload upload(stream, bytes);
        Offset begin = 0;
        for (const Offset length : pieces) {
          piece.assign(expected.begin() + begin, expected.begin() + begin + length);
          upload.to_device(place.at<char>(begin), piece.data(), length);
          std::fill(piece.begin(), piece.end(), char(0));
          begin += length;
        }
      }
      stream.to_host(brought.data(), place.at<char>(0), bytes);
      stream.synchronize();
      EXPECT_TRUE(brought == expected) << bytes << " bytes";
    }
  });
}

}  // namespace
}  // namespace mfs::test
