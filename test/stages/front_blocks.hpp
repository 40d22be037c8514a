// The blocks of fronts as the plan lays them out, and how they are compared.
#pragma once

#include <limits>
#include <vector>

#include "test/stages/artificial_problem.hpp"

namespace mfs::test {

/// The blocks of a front, column-major, one column after the other.
template <class Scalar>
struct FrontBlocks {
  std::vector<Scalar> lower, upper, contribution;
};

/// The columns of a block without what lies between them.
template <class Scalar>
std::vector<Scalar> packed(const Scalar* block, Offset rows, Offset columns, Offset ld) {
  std::vector<Scalar> columns_only;
  for (Offset j = 0; j < columns; ++j)
    columns_only.insert(columns_only.end(), block + j * ld, block + j * ld + rows);
  return columns_only;
}
/// The blocks of front f, which lies in the region `storage` of the plan.
template <class Scalar>
FrontBlocks<Scalar> blocks_in(const SymbolicPlan& plan, const Scalar* storage, Vertex f) {
  const Offset p = plan.pivots(f), b = plan.border_rows(f);
  return {packed(storage + plan.lower_begin[f], p + b, p, plan.lower_ld(f)),
          packed(storage + plan.upper_begin[f], p, b, p),
          packed(storage + plan.contribution_begin[f], b, b, plan.contribution_ld(f))};
}

template <class Scalar>
FrontBlocks<Scalar> blocks_of(const ReferenceFront<Scalar>& front) {
  FrontBlocks<Scalar> blocks;
  for (Vertex j = 0; j < front.rows(); ++j) {
    for (Vertex i = 0; i < front.rows(); ++i) {
      if (j < front.pivots) {
        blocks.lower.push_back(front.at(i, j));
      } else {
        (i < front.pivots ? blocks.upper : blocks.contribution).push_back(front.at(i, j));
      }
    }
  }
  return blocks;
}

/// Largest difference relative to the largest entry of `expected`; infinity where lengths differ or one is
/// NaN.
template <class Scalar>
double difference(const std::vector<Scalar>& actual, const std::vector<Scalar>& expected) {
  double most = 0, size = 0;
  if (actual.size() != expected.size()) return std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < actual.size(); ++k) {
    const double off = std::abs(actual[k] - expected[k]);
    if (!(off <= most)) most = std::isnan(off) ? std::numeric_limits<double>::infinity() : off;
    size = std::max<double>(size, std::abs(expected[k]));
  }
  return most == 0 ? 0 : most / size;
}

}  // namespace mfs::test
