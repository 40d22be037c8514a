#include "ordering/size_scaling.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "ordering/product_matching.hpp"
#include "ordering/transpose.hpp"

namespace mfs {
namespace {

constexpr std::int32_t kLimit = 1020;  // no scale leaves 2^-1020 ... 2^1020

using Distance = std::int64_t;  // -log2 of a size, in steps of Cost
constexpr Distance kNothing = std::numeric_limits<Distance>::max();

/// The equations of A, or of A^T: in which of them an unknown is, and the unknown that each is matched to.
struct Equations {
  const Offset* offsets;     // by unknown
  const Vertex* equations;   // that it is in
  const Offset* slots;       // of these entries; null: they are where they stand
  const Vertex* unknown_of;  // equation
  const Distance *dual, *unknown_dual;
};

/// The size of each equation beside its dual, from that of its right-hand side alone (kNothing: zero).
std::vector<Distance> spread(const Equations& in, const RawVector<Cost>& costs,
                             const std::vector<Distance>& right_hand_side) {
  using Reached = std::pair<Distance, Vertex>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;  // the largest size on top
  std::vector<Distance> nearest(right_hand_side.size(), kNothing);
  const auto reach = [&](Vertex equation, Distance distance) {
    if (distance >= nearest[equation]) return;
    nearest[equation] = distance;
    queue.emplace(distance, equation);
  };
  for (std::size_t i = 0; i < nearest.size(); ++i) reach(static_cast<Vertex>(i), right_hand_side[i]);
  while (!queue.empty()) {
    const auto [distance, from] = queue.top();
    queue.pop();
    if (distance > nearest[from]) continue;
    const Vertex unknown = in.unknown_of[from];
    for (Offset k = in.offsets[unknown]; k < in.offsets[unknown + 1]; ++k) {
      const Cost cost = costs[in.slots ? in.slots[k] : k];
      const Vertex to = in.equations[k];
      if (cost != kNoEdge) reach(to, distance + cost - in.dual[to] - in.unknown_dual[unknown]);
    }
  }
  return nearest;
}

/// Exponents that bring the sizes of equations to about 1; kZeroEntry where the size is zero, or unknown for
/// want of a matching.
template <class Scalar>
std::vector<std::int32_t> by_size_of_equations(const Pattern& pattern, const Scalar* values,
                                               const RawVector<Exponent>& exponents, const Scalar* b,
                                               bool transposed, int threads) {
  const RawVector<Cost> costs = matching_costs(pattern, values, exponents, PowerScaling(pattern.n), threads);
  const ProductMatching matching = maximum_product_matching(pattern, costs, threads);
  std::vector<std::int32_t> result(static_cast<std::size_t>(pattern.n), kZeroEntry);
  if (matching.unmatched > 0) return result;
  const RawVector<Distance>& dual = transposed ? matching.column_dual : matching.row_dual;
  std::vector<Distance> size(result.size(), kNothing);
  for (Vertex i = 0; i < pattern.n; ++i) {
    const double entry = std::abs(b[i]);
    if (entry > 0) size[i] = std::llround(-std::log2(entry) * kCostOfTwo) - dual[i];
  }
  if (transposed) {
    size = spread({pattern.offsets.data(), pattern.columns.data(), nullptr, matching.row_of_column.data(),
                   dual.data(), matching.row_dual.data()},
                  costs, size);
  } else {
    const TransposedPattern columns = transpose(pattern, threads);
    size = spread({columns.offsets.data(), columns.columns.data(), columns.slots.data(),
                   matching.column_of_row.data(), dual.data(), matching.column_dual.data()},
                  costs, size);
  }
  for (Vertex i = 0; i < pattern.n; ++i) {
    if (size[i] == kNothing) continue;
    const double exponent = std::floor(static_cast<double>(size[i] + dual[i]) / kCostOfTwo);
    result[i] = static_cast<std::int32_t>(std::clamp<double>(exponent, -kLimit, kLimit));
  }
  return result;
}

std::int32_t bringing_to_one(std::int32_t exponent) {
  return exponent == kZeroEntry ? 0 : std::clamp(-exponent, -kLimit, kLimit);
}

}  // namespace

template <class Scalar>
PowerScaling scaling_by_size(const Pattern& pattern, const Scalar* values, const Scalar* b, bool transposed,
                             int threads) {
  const RawVector<Exponent> exponents = exponents_of(values, pattern.nnz(), threads);
  const std::vector<std::int32_t> known =
      by_size_of_equations(pattern, values, exponents, b, transposed, threads);
  PowerScaling scaling(pattern.n);
  std::vector<std::int32_t>&by_size = transposed ? scaling.column : scaling.row,
  &by_entry = transposed ? scaling.row : scaling.column;
  for (Vertex i = 0; i < pattern.n; ++i)
    by_size[i] = known[i] == kZeroEntry ? -kLimit : known[i];  // as good as absent
  const LargestEntries beside = largest_entries(pattern, exponents, scaling, threads);
  for (Vertex i = 0; i < pattern.n; ++i)
    by_entry[i] = bringing_to_one((transposed ? beside.row : beside.column)[i]);
  const LargestEntries reached = largest_entries(pattern, exponents, scaling, threads);
  for (Vertex i = 0; i < pattern.n; ++i) {
    if (known[i] != kZeroEntry) continue;
    const std::int32_t largest = (transposed ? reached.column : reached.row)[i];
    if (largest != kZeroEntry) by_size[i] = std::clamp(by_size[i] - largest, -kLimit, kLimit);
  }
  return scaling;
}

#define MFS_INSTANTIATE(Scalar) \
  template PowerScaling scaling_by_size(const Pattern&, const Scalar*, const Scalar*, bool, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
