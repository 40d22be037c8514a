#include "accuracy/solution_support.hpp"

#include <algorithm>
#include <utility>

namespace mfs {

SolutionSupport::SolutionSupport(const Pattern& pattern, RawVector<Cost> costs)
    : pattern_(pattern), costs_(std::move(costs)), matching_(maximum_product_matching(pattern_, costs_, 1)) {
  matching_.row_dual = {};
  matching_.column_dual = {};
}

std::vector<char> SolutionSupport::of(const std::vector<char>& right_side, bool transposed) {
  if (matching_.unmatched > 0) return {};
  if (!transposed && !columns_) columns_ = transpose(pattern_, 1);
  // The equations that an unknown stands in, and the unknown that each of them gives.
  const std::vector<Offset>& offsets = transposed ? pattern_.offsets : columns_->offsets;
  const RawVector<Vertex>& equations = transposed ? pattern_.columns : columns_->columns;
  const std::vector<Vertex>& unknown_of = transposed ? matching_.row_of_column : matching_.column_of_row;
  std::vector<char> reached(right_side.size(), false);
  std::vector<Vertex> open;
  const auto reach = [&](Vertex equation) {
    const Vertex unknown = unknown_of[equation];
    if (!std::exchange(reached[unknown], true)) open.push_back(unknown);
  };
  for (Vertex i = 0; i < pattern_.n; ++i) {
    if (right_side[i]) reach(i);
  }
  while (!open.empty()) {
    const Vertex unknown = open.back();
    open.pop_back();
    for (Offset k = offsets[unknown]; k < offsets[unknown + 1]; ++k) {
      if (costs_[transposed ? k : columns_->slots[k]] != kNoEdge) reach(equations[k]);
    }
  }
  if (std::find(reached.begin(), reached.end(), false) == reached.end()) return {};
  return reached;
}

std::size_t SolutionSupport::bytes() const {
  const std::size_t n = static_cast<std::size_t>(pattern_.n), entries = costs_.size();
  const std::size_t columns =
      columns_ ? (n + 1) * sizeof(Offset) + entries * (sizeof(Vertex) + sizeof(Offset)) : 0;
  return entries * sizeof(Cost) + 2 * n * sizeof(Vertex) + columns;
}

}  // namespace mfs
