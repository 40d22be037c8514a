// The blocks of fronts as the plan lays them out, and how they are compared.
#pragma once

#include <limits>
#include <vector>

#include "test/stages/artificial_problem.hpp"

namespace mfs::test {

/// The blocks of a front in the layout of the plan.
template <class Scalar>
struct FrontBlocks {
  std::vector<Scalar> lower, upper, contribution;
};

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
