// Matching, pairing, and the decision between them.
#include "ordering/matching.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <random>

#include <mfs/error.hpp>

#include "ordering/pairing.hpp"
#include "ordering/product_matching.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

MatchedScaling match(Vertex n, const Entries& entries, const AnalysisOptions& options = {}) {
  const Matrix<double> a = matrix_of(n, entries);
  return match_and_scale(check_pattern(a.view(), 1), a.values.data(), options, 1);
}

/// The scaled entry; the scales are multiplied first, as the header asks for.
double scaled(const MatchedScaling& m, const std::pair<Vertex, Vertex>& place, double value) {
  return std::abs(m.row_scale[place.first] * m.column_scale[place.second] * value);
}

/// Largest sum of log2 |a| over all permutations; -infinity where there is none without a zero.
double best_product_by_trying(Vertex n, const Entries& entries) {
  std::vector<Vertex> row_of(n);
  std::iota(row_of.begin(), row_of.end(), 0);
  double best = -std::numeric_limits<double>::infinity();
  do {
    double sum = 0;
    for (Vertex j = 0; j < n; ++j) {
      const auto entry = entries.find({row_of[j], j});
      sum += std::log2(entry == entries.end() ? 0.0 : std::abs(entry->second));
    }
    best = std::max(best, sum);
  } while (std::next_permutation(row_of.begin(), row_of.end()));
  return best;
}

/// Size of a largest matching, one augmenting path after the other (Kuhn).
Vertex structural_rank_by_trying(Vertex n, const Entries& entries) {
  std::vector<Vertex> row_of(n, -1);
  std::vector<bool> tried;
  const std::function<bool(Vertex)> place = [&](Vertex row) {
    for (const auto& [where, value] : entries) {
      const Vertex column = where.second;
      if (where.first != row || value == 0.0 || tried[column]) continue;
      tried[column] = true;
      if (row_of[column] >= 0 && !place(row_of[column])) continue;
      row_of[column] = row;
      return true;
    }
    return false;
  };
  Vertex rank = 0;
  for (Vertex row = 0; row < n; ++row) {
    tried.assign(n, false);
    rank += place(row);
  }
  return rank;
}

TEST(Matching, AStrongDiagonalIsLeftAlone) {
  const MatchedScaling m = match(5, path(5));
  EXPECT_FALSE(m.matched);
  EXPECT_THAT(m.row_order, IsEmpty());
  EXPECT_THAT(m.pair, IsEmpty());
}

TEST(Matching, RowsAreExchangedWhereThePatternIsUnsymmetric) {
  // Row i of the matched matrix is row i + 1 of this one: a cyclic shift of an upper triangle.
  const Vertex n = 6;
  Entries entries;
  for (Vertex i = 0; i < n; ++i) {
    entries[{(i + 1) % n, i}] = 2.0;
    if (i + 1 < n) entries[{(i + 1) % n, i + 1}] = 1e-3;
  }
  const MatchedScaling m = match(n, entries);
  EXPECT_TRUE(m.matched);
  EXPECT_THAT(m.row_order, ElementsAre(1, 2, 3, 4, 5, 0));
  EXPECT_THAT(m.pair, IsEmpty());
}

TEST(Matching, SaddlePointsArePairedAndKeepTheirRows) {
  // Two unknowns, each bound by a multiplier (2 and 3) with a zero diagonal, in the pattern or not.
  for (const bool explicit_zeros : {false, true}) {
    Entries entries = symmetric(4, {{0, 1}, {0, 2}, {1, 3}}, 0.0);
    entries[{0, 0}] = entries[{1, 1}] = 4.0;
    if (explicit_zeros) entries[{2, 2}] = entries[{3, 3}] = 0.0;
    const MatchedScaling m = match(4, entries);
    EXPECT_TRUE(m.matched);
    EXPECT_THAT(m.row_order, IsEmpty());
    EXPECT_THAT(m.pair, ElementsAre(2, 3, 0, 1));
    EXPECT_EQ(m.row_scale, m.column_scale);
  }
}

TEST(Matching, OnlyWeakUnknownsArePaired) {
  // Unknowns 0 to 5 are a strong path; multiplier 6 is tied to unknown 2.
  Entries entries = path(6);
  entries[{2, 6}] = entries[{6, 2}] = 1.0;
  EXPECT_THAT(match(7, entries).pair, ElementsAre(0, 1, 6, 3, 4, 5, 2));
}

TEST(Matching, AWeakUnknownHasItsPartnersListedTheMateFirst) {
  // Multiplier 6 is tied to 1, 2 and, too weakly to serve, 4; 5 is strong and no partner.
  Entries entries = path(6);
  for (const auto& [unknown, value] : {std::pair(1, 0.5), std::pair(2, 1.0), std::pair(4, 1e-6)})
    entries[{unknown, 6}] = entries[{6, unknown}] = value;
  const WeakUnknowns weak = match(7, entries).weak;
  EXPECT_THAT(weak.unknown, ElementsAre(6));
  EXPECT_THAT(weak.begin, ElementsAre(0, 2));
  EXPECT_THAT(weak.partner, ElementsAre(2, 1));
  EXPECT_THAT(match(3, symmetric(3, {{0, 1}, {1, 2}, {0, 2}}, 0.0)).weak.unknown, IsEmpty());
}

TEST(Matching, AnOddCycleWithoutDiagonalStaysTogether) {
  const MatchedScaling m = match(3, symmetric(3, {{0, 1}, {1, 2}, {0, 2}}, 0.0));
  ASSERT_EQ(m.pair.size(), 3u);
  EXPECT_NE(m.pair[0], 0);
  EXPECT_EQ(m.pair[m.pair[m.pair[0]]], 0);
}

TEST(Matching, AnOddCycleLeavesTheStrongUnknownAlone) {
  Entries entries = symmetric(3, {{0, 1}, {1, 2}, {0, 2}}, 0.0);
  entries[{1, 1}] = 1.0;
  EXPECT_THAT(match(3, entries).pair, ElementsAre(2, 1, 0));
}

/// Pairs of a ring 0 -> 1 -> ... -> 0, given as a matching; edge t lies between t and t + 1 and has this
/// exponent in both directions, the diagonal entries have theirs (kZeroEntry: none).
std::vector<Vertex> pairs_of_ring(const std::vector<int>& edges, const std::vector<int>& diagonal) {
  const auto n = static_cast<Vertex>(edges.size());
  Entries entries;
  std::vector<Vertex> row_of_column(n);
  for (Vertex t = 0; t < n; ++t) {
    const Vertex next = (t + 1) % n;
    row_of_column[t] = next;
    entries[{t, next}] = entries[{next, t}] = std::ldexp(1.0, edges[t]);
    if (diagonal[t] != kZeroEntry) entries[{t, t}] = std::ldexp(1.0, diagonal[t]);
  }
  const Matrix<double> a = matrix_of(n, entries);
  const Pattern p = check_pattern(a.view(), 1);
  return pair_unknowns(p, exponents_of(a.values.data(), p.nnz(), 1), PowerScaling(n), row_of_column, 1).pair;
}

TEST(Pairing, AnEvenCycleIsCutIntoItsBetterPairs) {
  const std::vector<int> none(4, kZeroEntry);
  EXPECT_THAT(pairs_of_ring({0, -3, 0, -3}, none), ElementsAre(1, 0, 3, 2));
  EXPECT_THAT(pairs_of_ring({-3, 0, -3, 0}, none), ElementsAre(3, 2, 1, 0));
}

TEST(Pairing, AnOddCycleLeavesOutWhatLeavesTheBestPairs) {
  for (Vertex single = 0; single < 5; ++single) {
    // Good edges are those of the pairs behind the single; diagonal entries are all alike, and fine or not.
    std::vector<int> edges(5, -4);
    edges[(single + 1) % 5] = edges[(single + 3) % 5] = 0;
    std::vector<Vertex> pairs(5);
    pairs[single] = single;
    for (const Vertex a : {(single + 1) % 5, (single + 3) % 5}) {
      pairs[a] = (a + 1) % 5;
      pairs[(a + 1) % 5] = a;
    }
    // One more weak diagonal in each pair, so that no pair is superfluous.
    std::vector<int> diagonal(5, -20);
    diagonal[single] = 0;
    EXPECT_EQ(pairs_of_ring(edges, diagonal), pairs) << "single " << single;
    diagonal[single] = -20;
    pairs[single] = (single + 1) % 5;
    pairs[(single + 1) % 5] = (single + 2) % 5;
    pairs[(single + 2) % 5] = single;
    EXPECT_EQ(pairs_of_ring(edges, diagonal), pairs) << "weak single " << single;
  }
}

TEST(Pairing, AWeakSingleJoinsAStrongNeighbour) {
  // The ring 0 - 1 - 2: 1 and 2 are strong, so 0 needs only one of them.
  EXPECT_THAT(pairs_of_ring({0, 0, 0}, {-20, 0, 0}),
              ::testing::AnyOf(ElementsAre(1, 0, 2), ElementsAre(2, 1, 0)));
}

TEST(Pairing, StrongCyclesAreLeftAlone) {
  EXPECT_THAT(pairs_of_ring({0, 0, 0, 0}, {0, 0, -1, 0}), ElementsAre(0, 1, 2, 3));
}

TEST(Matching, SymmetricMatricesKeepEqualScales) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> grade(-6, 6);
    const Vertex n = 24;
    Entries entries;
    for (Vertex i = 0; i < n; i += 2) entries[{i, i + 1}] = std::pow(10.0, grade(generator));
    for (int k = 0; k < 40; ++k) {
      const auto i = static_cast<Vertex>(generator() % n), j = static_cast<Vertex>(generator() % n);
      entries[{std::min(i, j), std::max(i, j)}] = i == j ? 1e-9 : std::pow(10.0, grade(generator));
    }
    const Entries upper = entries;
    for (const auto& [place, value] : upper) entries[{place.second, place.first}] = value;
    const MatchedScaling m = match(n, entries);
    ASSERT_FALSE(m.pair.empty());
    EXPECT_EQ(m.row_scale, m.column_scale);
  }
}

TEST(Matching, PoorPairsGiveWayToARowPermutation) {
  // A symmetric pattern in which only one direction of each edge is large: a pair would be as weak as the
  // diagonal.
  const Vertex n = 8;
  Entries entries;
  for (Vertex i = 0; i < n; ++i) {
    entries[{(i + 1) % n, i}] = 1.0;
    entries[{i, (i + 1) % n}] = 1e-9;
  }
  const MatchedScaling m = match(n, entries);
  EXPECT_THAT(m.pair, IsEmpty());
  EXPECT_THAT(m.row_order, ElementsAre(1, 2, 3, 4, 5, 6, 7, 0));
}

TEST(Matching, NeverMeansNever) {
  AnalysisOptions options;
  options.matching = Matching::never;
  const MatchedScaling m = match(2, symmetric(2, {{0, 1}}, 0.0), options);
  EXPECT_FALSE(m.matched);
  EXPECT_THAT(m.row_order, IsEmpty());
  EXPECT_THAT(m.pair, IsEmpty());
}

TEST(Matching, AlwaysMatchesAStrongDiagonalToItself) {
  AnalysisOptions options;
  options.matching = Matching::always;
  const MatchedScaling m = match(5, path(5), options);
  EXPECT_TRUE(m.matched);
  EXPECT_THAT(m.row_order, IsEmpty());
  EXPECT_THAT(m.pair, IsEmpty());
}

TEST(Matching, ScalingCanBeSwitchedOff) {
  AnalysisOptions options;
  options.scaling = false;
  Entries entries = path(5);
  for (auto& [place, value] : entries) value *= 1e10;
  const MatchedScaling m = match(5, entries, options);
  EXPECT_THAT(m.row_scale, Each(1.0));
  EXPECT_THAT(m.column_scale, Each(1.0));
}

TEST(Matching, WithoutValuesOnlyMissingDiagonalEntriesCount) {
  const AnalysisOptions options;
  const MatchedScaling strong = match_and_scale<double>(pattern_of(5, path(5)), nullptr, options, 1);
  EXPECT_FALSE(strong.matched);
  EXPECT_THAT(strong.row_scale, Each(1.0));
  Entries saddle = path(6);
  saddle[{2, 6}] = saddle[{6, 2}] = 1.0;
  const MatchedScaling paired = match_and_scale<double>(pattern_of(7, saddle), nullptr, options, 1);
  EXPECT_TRUE(paired.matched);
  EXPECT_THAT(paired.pair, ElementsAre(0, 1, 6, 3, 4, 5, 2));
  Entries shifted;
  for (Vertex i = 0; i < 6; ++i) shifted[{(i + 1) % 6, i}] = 0.0;  // zeros count as entries here
  EXPECT_THAT(match_and_scale<double>(pattern_of(6, shifted), nullptr, options, 1).row_order,
              ElementsAre(1, 2, 3, 4, 5, 0));
}

void expect_structurally_singular(Vertex n, const Entries& entries, Vertex rank) {
  try {
    match(n, entries);
    FAIL() << "accepted";
  } catch (const SingularMatrix& error) {
    EXPECT_EQ(error.kind(), SingularMatrix::Kind::structural);
    EXPECT_EQ(error.dependent_rows(), n - rank);
    // Some largest matching leaves out this row, and some this column: without them the rank is no smaller.
    Entries rest;
    for (const auto& [place, value] : entries) {
      if (place.first != error.row()) rest[place] = value;
    }
    EXPECT_EQ(structural_rank_by_trying(n, rest), rank) << "row " << error.row();
    rest.clear();
    for (const auto& [place, value] : entries) {
      if (place.second != error.column()) rest[place] = value;
    }
    EXPECT_EQ(structural_rank_by_trying(n, rest), rank) << "column " << error.column();
  }
}

TEST(Matching, StructurallySingularNamesRowAndColumn) {
  expect_structurally_singular(3, {{{0, 0}, 1.0}, {{2, 2}, 1.0}}, 2);  // an empty row
  expect_structurally_singular(2, {{{0, 0}, 1.0}, {{0, 1}, 1.0}, {{1, 1}, 0.0}},
                               1);  // explicit zeros do not count
  expect_structurally_singular(3, {{{0, 1}, 1.0}, {{1, 1}, 1.0}, {{2, 1}, 1.0}}, 1);
}

TEST(Matching, StructuralRankAgainstTrying) {
  int singular = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 9);
    const Entries entries =
        random_entries(generator, n, 0.5 + 0.25 * static_cast<double>(seed % 8), 0.3, seed % 2 == 0);
    const Vertex rank = structural_rank_by_trying(n, entries);
    if (rank == n) {
      EXPECT_NO_THROW(match(n, entries));
    } else {
      ++singular;
      expect_structurally_singular(n, entries, rank);
    }
  }
  EXPECT_GT(singular, 50);
}

RawVector<Cost> costs_of(const Matrix<double>& a) {
  RawVector<Cost> costs;
  for (const double value : a.values)
    costs.push_back(static_cast<Cost>(-std::lround(std::log2(value) * kCostOfTwo)));
  return costs;
}

/// By its duals: no entry lies below them, and matched ones on them.
void expect_optimal(const Pattern& p, const RawVector<Cost>& costs, const ProductMatching& matching) {
  for (Vertex i = 0; i < p.n; ++i) {
    EXPECT_EQ(matching.row_of_column[matching.column_of_row[i]], i);
    for (Offset k = p.offsets[i]; k < p.offsets[i + 1]; ++k) {
      const Vertex j = p.columns[k];
      const std::int64_t slack = costs[k] - matching.row_dual[i] - matching.column_dual[j];
      EXPECT_GE(slack, 0);
      if (matching.column_of_row[i] == j) {
        EXPECT_EQ(slack, 0);
      }
    }
  }
}

TEST(Matching, LargestProductAgainstTrying) {
  int permuted = 0;
  for (unsigned seed = 0; seed < 600; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> grade(-4, 4);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 6);
    Entries entries = random_entries(generator, n, 3.0, 0.6, false);
    for (auto& [place, value] : entries) value = std::exp2(grade(generator));
    const double best = best_product_by_trying(n, entries);
    if (std::isinf(best)) continue;
    const Matrix<double> a = matrix_of(n, entries);
    const Pattern p = check_pattern(a.view(), 1);
    const RawVector<Cost> costs = costs_of(a);
    const ProductMatching matching = maximum_product_matching(p, costs, 1);
    const ProductMatching shared = maximum_product_matching(p, costs, 3);
    EXPECT_EQ(shared.row_of_column, matching.row_of_column);
    EXPECT_EQ(shared.row_dual, matching.row_dual);
    EXPECT_EQ(shared.column_dual, matching.column_dual);
    ASSERT_EQ(matching.unmatched, 0);
    expect_permutation(matching.row_of_column, n);
    double product = 0;
    for (Vertex j = 0; j < n; ++j) {
      product += std::log2(entries.at({matching.row_of_column[j], j}));
      permuted += matching.row_of_column[j] != j;
    }
    EXPECT_NEAR(product, best, 1e-4);
    expect_optimal(p, costs, matching);
  }
  EXPECT_GT(permuted, 300);
}

// Entries of a few sizes, as matrices of elements have them, tie at every step; of many sizes, rows outbid
// each other.
TEST(Matching, LargestProductOfLargeMatrices) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const double sizes = seed % 3 == 0 ? 2 : seed % 3 == 1 ? 40 : 1e6;
    std::uniform_real_distribution<double> grade(0, sizes);
    const Vertex n = 100 + static_cast<Vertex>(generator() % 400);
    Entries entries = random_entries(generator, n, 4.0, 0.6, false);
    std::vector<Vertex> hidden(n);  // some permutation without zeros
    std::iota(hidden.begin(), hidden.end(), 0);
    std::shuffle(hidden.begin(), hidden.end(), generator);
    for (Vertex j = 0; j < n; ++j) entries[{hidden[j], j}] = 1.0;
    for (auto& [place, value] : entries) value = std::exp2(std::floor(grade(generator)) / sizes * 20);
    const Matrix<double> a = matrix_of(n, entries);
    const Pattern p = check_pattern(a.view(), 1);
    const RawVector<Cost> costs = costs_of(a);
    const ProductMatching matching = maximum_product_matching(p, costs, 1);
    ASSERT_EQ(matching.unmatched, 0);
    expect_permutation(matching.row_of_column, n);
    expect_optimal(p, costs, matching);
  }
}

TEST(Matching, LargeMatricesMatchToTheEnd) {
  // A hidden permutation of large entries under many small ones: every unknown must find its own.
  std::mt19937 generator(11);
  const Vertex n = 3000;
  Entries entries = random_entries(generator, n, 6.0, 0.0, false);
  for (auto& [place, value] : entries) value *= 1e-3;
  std::vector<Vertex> hidden(n);
  std::iota(hidden.begin(), hidden.end(), 0);
  std::shuffle(hidden.begin(), hidden.end(), generator);
  for (Vertex j = 0; j < n; ++j) entries[{hidden[j], j}] = 1.0;
  EXPECT_EQ(match(n, entries).row_order, hidden);
}

/// Matched entries about 1, others at most about 1, all scales finite powers of two.
void expect_good_scaling(Vertex n, const Entries& entries, const MatchedScaling& m) {
  for (Vertex i = 0; i < n; ++i) {
    for (const double scale : {m.row_scale[i], m.column_scale[i]}) {
      int exponent = 0;
      ASSERT_TRUE(std::isnormal(scale));
      ASSERT_EQ(std::frexp(scale, &exponent), 0.5) << "no power of two";
    }
  }
  for (const auto& [place, value] : entries) EXPECT_LE(scaled(m, place, value), 16.0);
  if (!m.pair.empty()) return;
  for (Vertex i = 0; i < n; ++i) {
    const Vertex row = m.row_order.empty() ? i : m.row_order[i];
    EXPECT_GE(scaled(m, {row, i}, entries.at({row, i})), 1.0 / 16) << "unknown " << i;
  }
}

TEST(Matching, ScalingOfMatricesGradedOverTheWholeRange) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> grade(-150, 150);
    const Vertex n = 20;
    Entries entries = random_entries(generator, n, 3.0, 0.5, false);
    std::vector<Vertex> hidden(n);
    std::iota(hidden.begin(), hidden.end(), 0);
    std::shuffle(hidden.begin(), hidden.end(), generator);
    std::vector<double> left(n), right(n);
    for (Vertex i = 0; i < n; ++i) {
      entries[{hidden[i], i}] = 1.0;
      left[i] = std::pow(10.0, grade(generator));
      right[i] = std::pow(10.0, grade(generator));
    }
    for (auto& [place, value] : entries) value *= left[place.first] * right[place.second];
    AnalysisOptions options;
    options.matching = Matching::always;
    expect_good_scaling(n, entries, match(n, entries, options));
  }
}

TEST(Matching, EntriesAtTheEndsOfTheRange) {
  AnalysisOptions options;
  options.matching = Matching::always;
  const double tiny = std::numeric_limits<double>::denorm_min(), huge = std::numeric_limits<double>::max();
  for (const Entries& entries :
       {Entries{{{0, 0}, tiny}, {{1, 1}, huge}}, Entries{{{0, 1}, tiny}, {{1, 0}, huge}},
        Entries{{{0, 0}, tiny}, {{0, 1}, huge}, {{1, 0}, huge}, {{1, 1}, tiny}},
        Entries{{{0, 0}, huge}, {{0, 1}, tiny}, {{1, 0}, tiny}, {{1, 1}, tiny}}}) {
    const MatchedScaling m = match(2, entries, options);
    for (const auto& [place, value] : entries) EXPECT_LE(scaled(m, place, value), 16.0);
    for (const auto& scales : {m.row_scale, m.column_scale}) {
      for (const double scale : scales) EXPECT_TRUE(std::isnormal(scale));
    }
  }
}

/// 1 on the diagonal, 1e30 next to it: exact scales lie 30 (n - 1) decades apart.
Entries graded_chain(Vertex n) {
  Entries entries;
  for (Vertex i = 0; i < n; ++i) {
    entries[{i, i}] = 1.0;
    if (i + 1 < n) entries[{i, i + 1}] = 1e30;
  }
  return entries;
}

TEST(Matching, DualsBeyondTheRangeAreClamped) {
  const Vertex n = 100;
  const Entries entries = graded_chain(n);
  AnalysisOptions options;
  options.matching = Matching::always;
  const MatchedScaling m = match(n, entries, options);
  for (const auto& scales : {m.row_scale, m.column_scale}) {
    for (const double scale : scales) EXPECT_TRUE(std::isnormal(scale));
  }
  for (const auto& [place, value] : entries) EXPECT_LE(scaled(m, place, value), 16.0);
}

TEST(Matching, ScalesAreCentredBeforeTheyAreClamped) {
  // Scales over 510 decades are within the range if 1 is in their middle.
  const Vertex n = 18;
  const Entries entries = graded_chain(n);
  AnalysisOptions options;
  options.matching = Matching::always;
  const MatchedScaling m = match(n, entries, options);
  EXPECT_FALSE(m.beyond_range);
  expect_good_scaling(n, entries, m);
}

TEST(Matching, ComplexAndSinglePrecisionAgreeWithDouble) {
  std::mt19937 generator(5);
  const Vertex n = 50;
  const Entries entries = random_entries(generator, n, 4.0, 0.8, false);
  const Matrix<double> a = matrix_of(n, entries);
  const Pattern p = check_pattern(a.view(), 1);
  const MatchedScaling reference = match_and_scale(p, a.values.data(), {}, 1);
  std::vector<std::complex<double>> turned(a.values.begin(), a.values.end());
  for (auto& value : turned) value *= std::complex<double>(0.0, 1.0);
  const MatchedScaling complex = match_and_scale(p, turned.data(), {}, 1);
  const std::vector<float> narrow(a.values.begin(), a.values.end());
  const MatchedScaling single = match_and_scale(p, narrow.data(), {}, 1);
  for (const MatchedScaling* m : {&complex, &single}) {
    EXPECT_EQ(m->row_order, reference.row_order);
    EXPECT_EQ(m->row_scale, reference.row_scale);
    EXPECT_EQ(m->column_scale, reference.column_scale);
  }
}

TEST(Matching, TheSameForAnyNumberOfThreads) {
  std::mt19937 generator(6);
  const Vertex n = 500;
  for (const bool symmetric : {false, true}) {
    SCOPED_TRACE(symmetric ? "rows are paired" : "rows are permuted");
    Entries entries = random_entries(generator, n, 6.0, 0.0, symmetric);
    for (Vertex i = 0; i < n; ++i) {
      entries[{(i + 7) % n, i}] = 0.1;
      if (symmetric) entries[{i, (i + 7) % n}] = 0.1;
    }
    const Matrix<double> a = matrix_of(n, entries);
    const Pattern p = check_pattern(a.view(), 1);
    const MatchedScaling one = match_and_scale(p, a.values.data(), {}, 1);
    EXPECT_NE(one.pair.empty(), symmetric);
    for (const int threads : {2, 4, 13}) {
      const MatchedScaling many = match_and_scale(p, a.values.data(), {}, threads);
      EXPECT_EQ(many.row_order, one.row_order);
      EXPECT_EQ(many.pair, one.pair);
      EXPECT_EQ(many.row_scale, one.row_scale);
      EXPECT_EQ(many.column_scale, one.column_scale);
    }
  }
}

TEST(Matching, CostsOfNumbersOfAnySize) {
  const std::vector<double> values{1.0,    -3.0,   0.7,      1.7e308, -8.9e307, 2.3e-308,
                                   1e-310, 5e-324, 4.5e-308, 1e-5,    0.0,      12345.678};
  const auto n = static_cast<Vertex>(values.size());
  Entries entries;
  for (Vertex i = 0; i < n; ++i) entries[{i, i}] = values[i];
  const Matrix<double> a = matrix_of(n, entries);
  const Pattern p = check_pattern(a.view(), 1);
  const RawVector<Exponent> exponents = exponents_of(a.values.data(), p.nnz(), 1);
  PowerScaling scaling(n);
  for (Vertex i = 0; i < n; ++i) scaling.column[i] = 3 * i - 10;
  const RawVector<Cost> costs = matching_costs(p, a.values.data(), exponents, scaling, 2);
  for (Vertex i = 0; i < n; ++i) {
    SCOPED_TRACE(values[i]);
    if (values[i] == 0.0) {
      EXPECT_EQ(costs[i], kNoEdge);
      continue;
    }
    // A quarter of the smallest power counts where the number is still smaller.
    const double size = std::max(std::log2(std::abs(values[i])), -1021.0);
    EXPECT_NEAR(costs[i], -(size + scaling.column[i]) * kCostOfTwo, 1.0);
  }
}

}  // namespace
}  // namespace mfs::test
