#include "ordering/matching.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string>

#include <mfs/error.hpp>

#include "ordering/pairing.hpp"
#include "ordering/product_matching.hpp"
#include "ordering/raw_vector.hpp"
#include "ordering/row_shares.hpp"
#include "ordering/scaling.hpp"

namespace mfs {
namespace {

constexpr double kNearlySymmetric =
    0.9;                           // share of off-diagonal entries whose mirror image is in the pattern
constexpr int kLargestEntry = 2;   // exponent that a scaled entry may have under symmetrised scales
constexpr int kFarBelowOne = -20;  // exponent of a matched entry only where scales had to be clamped

/// True where some diagonal entry is missing, zero, or small beside the largest of its row and of its column.
bool diagonal_is_weak(const Pattern& pattern, const RawVector<Exponent>& exponents,
                      const PowerScaling& scaling, const LargestEntries& largest, int threads) {
  bool weak = false;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(|| : weak)
  for (Vertex i = 0; i < pattern.n; ++i) {
    if (weak) continue;
    const std::int32_t diagonal = scaled_exponent(pattern, exponents, scaling, i, i);
    weak = diagonal == kZeroEntry || diagonal < std::min(largest.row[i], largest.column[i]) + kWeakExponent;
  }
  return weak;
}

/// One cursor per row walks through its entries as the rows before it ask for theirs: linear time. Each share
/// of the asking rows has cursors of its own.
bool pattern_is_nearly_symmetric(const Pattern& pattern, int threads) {
  const RowShares shares(pattern.n, threads);
  std::vector<RawVector<Offset>> cursors(shares.count());
  for (RawVector<Offset>& cursor : cursors) cursor.resize(static_cast<std::size_t>(pattern.n));
  Offset mirrored = 0, diagonal = 0;
#pragma omp parallel for num_threads(shares.threads()) schedule(static, 1) reduction(+ : mirrored, diagonal)
  for (int share = 0; share < shares.count(); ++share) {
    RawVector<Offset>& cursor = cursors[share];
    const auto columns = pattern.columns.begin();
    for (Vertex j = 0; j < pattern.n; ++j) {
      cursor[j] = std::lower_bound(columns + pattern.offsets[j], columns + pattern.offsets[j + 1],
                                   shares.first_row(share)) -
                  columns;
    }
    for (Vertex i = shares.first_row(share); i < shares.first_row(share + 1); ++i) {
      for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
        const Vertex j = pattern.columns[k];
        diagonal += i == j;
        Offset& c = cursor[j];
        while (c < pattern.offsets[j + 1] && pattern.columns[c] < i) ++c;
        mirrored += i != j && c < pattern.offsets[j + 1] && pattern.columns[c] == i;
      }
    }
  }
  return static_cast<double>(mirrored) >= kNearlySymmetric * static_cast<double>(pattern.nnz() - diagonal);
}

/// Of a scale, so that it is a normal number and so is its reciprocal.
constexpr double kMostExponent = 1020.0;

/// Adds the scales that duals stand for to those that the matching started from. Where a sum is beyond what a
/// double can hold, all rows get a factor that all columns lose, if that helps.
void add_duals(const ProductMatching& matching, int threads, PowerScaling& scaling) {
  const auto n = static_cast<Vertex>(scaling.row.size());
  const auto sum = [](std::int32_t exponent, std::int64_t dual) {
    return exponent + static_cast<double>(dual) / kCostOfTwo;
  };
  double low = std::numeric_limits<double>::lowest(), high = std::numeric_limits<double>::max();
#pragma omp parallel for num_threads(threads) schedule(static) reduction(max : low) reduction(min : high)
  for (Vertex i = 0; i < n; ++i) {
    const double row = sum(scaling.row[i], matching.row_dual[i]),
                 column = sum(scaling.column[i], matching.column_dual[i]);
    low = std::max({low, -kMostExponent - row, column - kMostExponent});
    high = std::min({high, kMostExponent - row, column + kMostExponent});
  }
  const double shift = std::round(low <= high ? std::clamp(0.0, low, high) : 0.5 * (low + high));
  const auto rounded = [](double exponent) {
    return static_cast<std::int32_t>(std::lround(std::clamp(exponent, -kMostExponent, kMostExponent)));
  };
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < n; ++i) {
    scaling.row[i] = rounded(sum(scaling.row[i], matching.row_dual[i]) + shift);
    scaling.column[i] = rounded(sum(scaling.column[i], matching.column_dual[i]) - shift);
  }
}

/// The geometric mean of row and column scale for both, where no entry grows above 2^kLargestEntry by it: a
/// symmetric matrix stays symmetric.
void symmetrise(const Pattern& pattern, const RawVector<Exponent>& exponents, int threads,
                PowerScaling& scaling) {
  PowerScaling mean(pattern.n);
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < pattern.n; ++i) {
    mean.row[i] = mean.column[i] =
        static_cast<std::int32_t>(std::floor(0.5 * (scaling.row[i] + scaling.column[i])));
  }
  const LargestEntries largest = largest_entries(pattern, exponents, mean, threads);
  const std::int32_t worst = *std::max_element(largest.row.begin(), largest.row.end());
  if (worst <= kLargestEntry) scaling = std::move(mean);
}

[[noreturn]] void throw_structurally_singular(const ProductMatching& matching) {
  const auto unmatched = [](const std::vector<Vertex>& partner) {
    return std::find(partner.begin(), partner.end(), -1) - partner.begin();
  };
  throw SingularMatrix(SingularMatrix::Kind::structural, unmatched(matching.column_of_row),
                       unmatched(matching.row_of_column), matching.unmatched,
                       "no permutation gives a diagonal without zeros; " +
                           std::to_string(matching.unmatched) + " dependent rows, one of them");
}

/// The matched rows by column, with `scaling` improved where values are given.
template <class Scalar>
std::vector<Vertex> matched_rows(const Pattern& pattern, const Scalar* values,
                                 const RawVector<Exponent>& exponents, int threads, PowerScaling& scaling) {
  ProductMatching matching = maximum_product_matching(
      pattern, matching_costs(pattern, values, exponents, scaling, threads), threads);
  if (matching.unmatched > 0) throw_structurally_singular(matching);
  if (values != nullptr) {
    add_duals(matching, threads, scaling);
    equilibrate(pattern, exponents, threads, scaling);  // changes something only where scales were clamped
  }
  return std::move(matching.row_of_column);
}

/// True where clamped scales leave a matched entry far below 1.
bool clamped_far(const Pattern& pattern, const RawVector<Exponent>& exponents, const PowerScaling& scaling,
                 const std::vector<Vertex>& row_of_column, int threads) {
  bool far = false;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(|| : far)
  for (Vertex j = 0; j < pattern.n; ++j)
    far = far || scaled_exponent(pattern, exponents, scaling, row_of_column[j], j) < kFarBelowOne;
  return far;
}

bool is_identity(const std::vector<Vertex>& permutation) {
  for (std::size_t i = 0; i < permutation.size(); ++i) {
    if (permutation[i] != static_cast<Vertex>(i)) return false;
  }
  return true;
}

}  // namespace

template <class Scalar>
MatchedScaling match_and_scale(const Pattern& pattern, const Scalar* slot_values,
                               const AnalysisOptions& options, int threads) {
  const bool has_values = slot_values != nullptr;
  const auto exponents = has_values ? exponents_of(slot_values, pattern.nnz(), threads)
                                    : RawVector<Exponent>(static_cast<std::size_t>(pattern.nnz()), 0);
  PowerScaling scaling(pattern.n);
  const LargestEntries largest = has_values ? equilibrate(pattern, exponents, threads, scaling)
                                            : largest_entries(pattern, exponents, scaling, threads);

  MatchedScaling result;
  const bool wanted = options.matching == Matching::always ||
                      (options.matching == Matching::automatic &&
                       diagonal_is_weak(pattern, exponents, scaling, largest, threads));
  if (wanted) {
    result.matched = true;
    std::vector<Vertex> rows = matched_rows(pattern, slot_values, exponents, threads, scaling);
    result.beyond_range = has_values && clamped_far(pattern, exponents, scaling, rows, threads);
    if (pattern_is_nearly_symmetric(pattern, threads)) {
      Pairs pairs = pair_unknowns(pattern, exponents, scaling, rows, threads);
      result.pair = std::move(pairs.pair);
      result.weak = std::move(pairs.weak);
    }
    if (!result.pair.empty()) {
      if (is_identity(result.pair)) result.pair.clear();
      symmetrise(pattern, exponents, threads, scaling);
    } else if (!is_identity(rows)) {
      result.row_order = std::move(rows);
    }
  }
  const bool scaled = has_values && options.scaling;
  result.row_scale = scaled ? powers_of_two(scaling.row, threads) : std::vector<double>(pattern.n, 1.0);
  result.column_scale = scaled ? powers_of_two(scaling.column, threads) : std::vector<double>(pattern.n, 1.0);
  return result;
}

template MatchedScaling match_and_scale(const Pattern&, const float*, const AnalysisOptions&, int);
template MatchedScaling match_and_scale(const Pattern&, const double*, const AnalysisOptions&, int);
template MatchedScaling match_and_scale(const Pattern&, const std::complex<float>*, const AnalysisOptions&,
                                        int);
template MatchedScaling match_and_scale(const Pattern&, const std::complex<double>*, const AnalysisOptions&,
                                        int);

}  // namespace mfs
