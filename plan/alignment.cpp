#include "plan/alignment.hpp"

#include <algorithm>
#include <cstddef>

namespace mfs {

namespace {

// Of the last node of `tree`: how many unknowns at its end have to leave it, 0 if none can.
Vertex unknowns_to_move(const SeparatorTree& tree, const std::vector<Vertex>& pair) {
  const auto end = static_cast<Vertex>(tree.order.size()), begin = tree.node_begin.back();
  const auto closed = [&](Vertex moved) {
    const auto last = tree.order.end(), first = last - moved;
    return pair.empty() || std::all_of(first, last, [&](Vertex i) {
             return pair[i] == i || std::find(first, last, pair[i]) != last;
           });
  };
  for (Vertex moved = (end - begin) % kAlignment; moved <= kMostMoved; moved += kAlignment) {
    if (closed(moved)) return moved;
  }
  return 0;
}

}  // namespace

SeparatorTree align_nodes(const SeparatorTree& tree, const std::vector<Vertex>& pair) {
  const Vertex count = tree.num_nodes();
  SeparatorTree aligned;
  aligned.order.reserve(tree.order.size());
  aligned.node_begin.push_back(0);
  aligned.parent = tree.parent;
  std::vector<std::vector<Vertex>> from_children(static_cast<std::size_t>(count));
  for (Vertex f = 0; f < count; ++f) {
    std::vector<Vertex>& order = aligned.order;
    order.insert(order.end(), from_children[f].begin(), from_children[f].end());
    order.insert(order.end(), tree.order.begin() + tree.node_begin[f],
                 tree.order.begin() + tree.node_begin[f + 1]);
    const auto size = static_cast<Vertex>(order.size()) - aligned.node_begin.back();
    if (tree.parent[f] >= 0 && size >= kAlignedUnknowns) {
      const auto rest = order.end() - unknowns_to_move(aligned, pair);
      std::vector<Vertex>& parent = from_children[tree.parent[f]];
      parent.insert(parent.end(), rest, order.end());
      order.erase(rest, order.end());
    }
    aligned.node_begin.push_back(static_cast<Vertex>(order.size()));
  }
  return aligned;
}

}  // namespace mfs
