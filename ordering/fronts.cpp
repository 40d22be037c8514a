#include "ordering/fronts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

#include "ordering/elimination_tree.hpp"
#include "ordering/lists_by_key.hpp"

namespace mfs {
namespace {

/// Merge always up to kAlwaysMerge pivots, and up to the others where the share of explicit zeros in the
/// front's columns stays below the limit beside it. CHOLMOD's rule with its second limit lower (there 16 and
/// 0.8): that would add 41 % to the factor of a five-point grid, these 21 % (2026-11, 500 x 500, 37 000
/// fronts instead of 20 000).
struct Relaxation {
  Offset pivots;
  double zeros;
};
constexpr Offset kAlwaysMerge = 4;
constexpr Relaxation kRelaxed[] = {{8, 0.7}, {48, 0.1}, {INT64_MAX, 0.05}};

/// A merge saves the contribution block of the child, which is written, read and added to its parent's front,
/// and that takes as long as many products. It makes p (R^2 - b^2) more of them for a child of p pivots and b
/// border rows, where the parent's front has R rows. So below large borders it may cost so many for each
/// entry of the block, whatever the share of zeros: random graphs have chains of fronts with some 50 pivots
/// and a border of 10 000 rows.
constexpr Offset kLargeBorder = 512;
constexpr double kProductsForAnEntry = 32;

/// Children of at least so many pivots stay fronts of their own beside a sibling of half their size or more:
/// both are then factored and solved with at the same time, and what a child does to its parent is one
/// product of full depth.
constexpr Offset kLargeChild = 2048;

/// Bundles are looked for only below nodes with at least this many tiny leaves, so that no other tree pays
/// for it.
constexpr Vertex kCrowd = 8;
constexpr Offset kTinyPivots = 8;
constexpr Offset kBundlePivots = 16;

/// Groups of positions of the elimination tree that become fronts.
struct FrontTree {
  std::vector<Vertex> group_of;  // position -> front
  std::vector<Vertex> parent;    // front -> front, -1 for a root
  std::vector<Offset> pivots;    // unknowns
  std::vector<Offset> border;
  Vertex size() const { return static_cast<Vertex>(parent.size()); }
};

/// Chains j, j + 1 = parent(j) in which j is the only child and the columns differ by j alone.
FrontTree fundamental_supernodes(const Graph& graph, const EliminationTree& tree) {
  const auto n = static_cast<Vertex>(tree.order.size());
  std::vector<Vertex> children(n, 0);
  for (const Vertex parent : tree.parent) {
    if (parent >= 0) ++children[parent];
  }
  FrontTree fronts;
  fronts.group_of.resize(n);
  std::vector<Vertex> last;  // of each front
  for (Vertex j = 0; j < n; ++j) {
    const Vertex weight = graph.weight[tree.order[j]];
    const bool joins = j > 0 && tree.parent[j - 1] == j && children[j] == 1 &&
                       tree.count[j - 1] - graph.weight[tree.order[j - 1]] == tree.count[j];
    if (joins) {
      last.back() = j;
      fronts.pivots.back() += weight;
    } else {
      last.push_back(j);
      fronts.pivots.push_back(weight);
    }
    fronts.group_of[j] = static_cast<Vertex>(last.size()) - 1;
  }
  for (const Vertex j : last) {
    fronts.parent.push_back(tree.parent[j] < 0 ? -1 : fronts.group_of[tree.parent[j]]);
    fronts.border.push_back(tree.count[j] - graph.weight[tree.order[j]]);
  }
  return fronts;
}

/// Replaces fronts by what they were merged into: target[f] == f for those that stay.
void apply_merges(std::vector<Vertex>& target, FrontTree& fronts) {
  for (Vertex f = fronts.size() - 1; f >= 0; --f)
    target[f] = target[target[f]];  // targets come later: done already
  std::vector<Vertex> number(fronts.size());
  Vertex count = 0;
  for (Vertex f = 0; f < fronts.size(); ++f) {
    if (target[f] != f) continue;
    number[f] = count;
    fronts.pivots[count] = fronts.pivots[f];
    fronts.border[count] = fronts.border[f];
    fronts.parent[count] = fronts.parent[f];  // old number, renamed below
    ++count;
  }
  fronts.pivots.resize(count);
  fronts.border.resize(count);
  fronts.parent.resize(count);
  for (Vertex& parent : fronts.parent) parent = parent < 0 ? -1 : number[target[parent]];
  for (Vertex& group : fronts.group_of) group = number[target[group]];
}

/// May a front of `pivots` with `entries` in its columns, of which `zeros` are explicit, be made?
bool acceptable(Offset pivots, double entries, double zeros) {
  if (pivots <= kAlwaysMerge) return true;
  for (const Relaxation& limit : kRelaxed) {
    if (pivots <= limit.pivots && zeros < limit.zeros * entries) return true;
  }
  return false;
}

/// Merges children into their parents, leaves first, at each parent the cheapest child first and of equals
/// the last: of a separator's vertices that is the chain before the parent, and a separator should be one
/// front. A child's border lies within its parent's front, so the zeros that a merge adds are known from the
/// sizes alone:
///
///            child  parent  border of parent        the child's columns grow by the rows that its own
///      child   x      .x       .xxx.                border does not have
///     parent          x        xxxxx
void amalgamate(FrontTree& fronts) {
  const Lists children = lists_by_key(fronts.parent, fronts.size());
  std::vector<Vertex> target(fronts.size());
  std::iota(target.begin(), target.end(), 0);
  std::vector<double> zeros(fronts.size(), 0.0);
  const auto new_zeros = [&](Vertex child, Vertex parent) {
    return static_cast<double>(fronts.pivots[child]) *
           static_cast<double>(fronts.pivots[parent] + fronts.border[parent] - fronts.border[child]);
  };
  const auto saves_time = [&](Vertex child, Vertex parent) {
    const double rows = static_cast<double>(fronts.pivots[parent] + fronts.border[parent]),
                 border = static_cast<double>(fronts.border[child]), block = border * border;
    return fronts.border[child] >= kLargeBorder &&
           static_cast<double>(fronts.pivots[child]) * (rows * rows - block) <= kProductsForAnEntry * block;
  };
  std::vector<std::pair<double, Vertex>> candidates;  // cost, minus the child
  for (Vertex parent = 0; parent < fronts.size(); ++parent) {
    candidates.clear();
    for (Vertex c = children.begin[parent]; c < children.begin[parent + 1]; ++c) {
      candidates.emplace_back(new_zeros(children.item[c], parent), -children.item[c]);
    }
    std::sort(candidates.begin(), candidates.end());
    Offset largest = 0, second = 0;  // of the children
    for (const auto& [cost, minus_child] : candidates) {
      second = std::max(second, std::min(largest, fronts.pivots[-minus_child]));
      largest = std::max(largest, fronts.pivots[-minus_child]);
    }
    for (const auto& [cost, minus_child] : candidates) {
      const Vertex child = -minus_child;
      if (fronts.pivots[child] >= kLargeChild && 2 * second >= fronts.pivots[child]) continue;
      const Offset pivots = fronts.pivots[child] + fronts.pivots[parent];
      const double width = static_cast<double>(pivots);
      const double entries = width * (width + 1) / 2 + width * static_cast<double>(fronts.border[parent]);
      const double merged_zeros = zeros[child] + zeros[parent] + new_zeros(child, parent);
      if (!saves_time(child, parent) && !acceptable(pivots, entries, merged_zeros)) continue;
      target[child] = parent;
      fronts.pivots[parent] = pivots;
      zeros[parent] = merged_zeros;
    }
  }
  apply_merges(target, fronts);
}

/// A front that is made for a low tree has at most so many rows, so that its zeros cost less than a depth.
constexpr Offset kLowRows = 160;

/// Fronts on the longest path in a low tree, as a part of those in a tree in which each front has two
/// children. Below 1, fronts of a few pivots are merged in even trees as well.
constexpr double kLowPart = 0.9;

std::vector<Vertex> depths_of(const FrontTree& fronts) {
  std::vector<Vertex> depth(static_cast<std::size_t>(fronts.size()), 0);
  for (Vertex f = fronts.size() - 1; f >= 0; --f) {
    if (fronts.parent[f] >= 0) depth[f] = depth[fronts.parent[f]] + 1;
  }
  return depth;
}

/// Merges the highest children of fronts on paths of more than `limit` fronts into them, from the leaves up,
/// each front once. False where there are none that may be.
bool shorten_paths(Vertex limit, FrontTree& fronts) {
  const Lists children = lists_by_key(fronts.parent, fronts.size());
  const std::vector<Vertex> depth = depths_of(fronts);
  std::vector<Vertex> target(static_cast<std::size_t>(fronts.size())), height(target.size());
  std::iota(target.begin(), target.end(), 0);
  std::vector<char> merged(target.size(), 0);
  std::vector<Vertex> highest;
  bool any = false;
  for (Vertex parent = 0; parent < fronts.size(); ++parent) {
    Vertex most = 0;
    for (Vertex c = children.begin[parent]; c < children.begin[parent + 1]; ++c) {
      const Vertex child = children.item[c];
      if (height[child] > most) highest.clear();
      most = std::max(most, height[child]);
      if (height[child] == most) highest.push_back(child);
    }
    height[parent] = most + 1;
    if (most == 0 || depth[parent] + height[parent] <= limit) continue;
    Offset pivots = fronts.pivots[parent];
    bool may = true;
    for (const Vertex child : highest) {
      pivots += fronts.pivots[child];
      may = may && !merged[child];
    }
    if (!may || pivots > kLowPivots || pivots + fronts.border[parent] > kLowRows) continue;
    for (const Vertex child : highest) target[child] = parent;
    fronts.pivots[parent] = pivots;
    height[parent] = most;
    merged[parent] = 1;
    any = true;
  }
  apply_merges(target, fronts);
  return any;
}

/// Pairs before threes, so that fronts grow evenly along a path.
void lower_tree(FrontTree& fronts) {
  const double even = std::log2(fronts.size() + 1.0);
  const auto limit = static_cast<Vertex>(kLowPart * even) + 1;
  while (shorten_paths(limit, fronts)) {
  }
}

/// A hash of the border of a front without children: of the set of vertices in other fronts that its own
/// touch.
std::uint64_t border_hash(const Graph& graph, const EliminationTree& tree,
                          const std::vector<Vertex>& position, const FrontTree& fronts, const Vertex* first,
                          const Vertex* last) {
  std::vector<Vertex> border;
  for (const Vertex* p = first; p != last; ++p) {
    const Vertex vertex = tree.order[*p];
    for (Offset k = graph.offsets[vertex]; k < graph.offsets[vertex + 1]; ++k) {
      const Vertex other = position[graph.neighbors[k]];
      if (fronts.group_of[other] != fronts.group_of[*p]) border.push_back(other);
    }
  }
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  std::uint64_t hash = 0;
  for (const Vertex v : border)
    hash = (hash ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15u + (hash >> 29);
  return hash;
}

/// Tiny fronts without children below the same parent (or below none), where they come in crowds.
std::vector<Vertex> crowded_leaves(const FrontTree& fronts, Parts parts) {
  std::vector<bool> has_children(fronts.size(), false);
  for (const Vertex parent : fronts.parent) {
    if (parent >= 0) has_children[parent] = true;
  }
  const auto tiny = [&](Vertex f) {
    const bool may = parts == Parts::bundled || fronts.parent[f] >= 0;
    return may && !has_children[f] && fronts.pivots[f] <= kTinyPivots;
  };
  std::vector<Vertex> crowd(static_cast<std::size_t>(fronts.size()) + 1, 0);  // by parent + 1
  for (Vertex f = 0; f < fronts.size(); ++f) crowd[fronts.parent[f] + 1] += tiny(f);
  std::vector<Vertex> leaves;
  for (Vertex f = 0; f < fronts.size(); ++f) {
    if (tiny(f) && crowd[fronts.parent[f] + 1] >= kCrowd) leaves.push_back(f);
  }
  return leaves;
}

/// Crowds of tiny siblings with equal borders share fronts of up to kBundlePivots: a diagonal matrix, or the
/// spokes of an arrow, would otherwise be as many fronts as unknowns. The zeros between them cost less than
/// the fronts.
void bundle_crowds(const Graph& graph, const EliminationTree& tree, Parts parts, FrontTree& fronts) {
  const std::vector<Vertex> leaves = crowded_leaves(fronts, parts);
  if (leaves.empty()) return;
  const std::vector<Vertex> position = inverse_permutation(tree.order);
  const Lists members = lists_by_key(fronts.group_of, fronts.size());
  std::vector<std::tuple<Vertex, std::uint64_t, Vertex>> siblings;  // parent, border, front
  for (const Vertex f : leaves) {
    const Vertex* item = members.item.data();
    siblings.emplace_back(
        fronts.parent[f],
        border_hash(graph, tree, position, fronts, item + members.begin[f], item + members.begin[f + 1]), f);
  }
  std::sort(siblings.begin(), siblings.end(), std::greater<>());  // a bundle is named after its last front
  std::vector<Vertex> target(fronts.size());
  std::iota(target.begin(), target.end(), 0);
  for (std::size_t s = 1; s < siblings.size(); ++s) {
    const auto& [parent, border, f] = siblings[s];
    const auto& [last_parent, last_border, last_f] = siblings[s - 1];
    const Vertex bundle = target[last_f];
    if (parent != last_parent || border != last_border) continue;
    if (fronts.pivots[bundle] + fronts.pivots[f] > kBundlePivots) continue;
    target[f] = bundle;
    fronts.pivots[bundle] += fronts.pivots[f];
  }
  apply_merges(target, fronts);
}

/// The unknowns of each front, in elimination order.
NodeList unknowns_of(const FrontTree& fronts, const EliminationTree& tree, const Partition& partition) {
  const Lists positions = lists_by_key(fronts.group_of, fronts.size());
  NodeList nodes;
  nodes.order.reserve(partition.members.size());
  nodes.node_begin.reserve(static_cast<std::size_t>(fronts.size()) + 1);
  nodes.node_begin.push_back(0);
  nodes.parent = fronts.parent;
  for (Vertex f = 0; f < fronts.size(); ++f) {
    for (Vertex p = positions.begin[f]; p < positions.begin[f + 1]; ++p) {
      const Vertex v = tree.order[positions.item[p]];
      nodes.order.insert(nodes.order.end(), partition.members.begin() + partition.begin[v],
                         partition.members.begin() + partition.begin[v + 1]);
    }
    nodes.node_begin.push_back(static_cast<Vertex>(nodes.order.size()));
  }
  return nodes;
}

}  // namespace

SeparatorTree in_order(const NodeList& nodes, const std::vector<Vertex>& visit) {
  const std::vector<Vertex> number = inverse_permutation(visit);
  SeparatorTree tree;
  tree.order.reserve(nodes.order.size());
  tree.node_begin.push_back(0);
  for (const Vertex f : visit) {
    tree.order.insert(tree.order.end(), nodes.order.begin() + nodes.node_begin[f],
                      nodes.order.begin() + nodes.node_begin[f + 1]);
    tree.node_begin.push_back(static_cast<Vertex>(tree.order.size()));
    tree.parent.push_back(nodes.parent[f] < 0 ? -1 : number[nodes.parent[f]]);
  }
  return tree;
}

SeparatorTree breadth_first(const NodeList& nodes) {
  const auto count = static_cast<Vertex>(nodes.parent.size());
  const Lists children = lists_by_key(nodes.parent, count);
  std::vector<Vertex> visit;  // from the roots down; the result is numbered from its end
  visit.reserve(count);
  for (Vertex f = count - 1; f >= 0; --f) {
    if (nodes.parent[f] < 0) visit.push_back(f);
  }
  for (std::size_t done = 0; done < visit.size(); ++done) {
    for (Vertex c = children.begin[visit[done] + 1]; c-- > children.begin[visit[done]];) {
      visit.push_back(children.item[c]);
    }
  }
  std::reverse(visit.begin(), visit.end());
  return in_order(nodes, visit);
}

NodeList fronts_of_order(const Graph& graph, const Partition& partition, const std::vector<Vertex>& order,
                         int threads, TreeHeight height, Parts parts) {
  const EliminationTree tree = elimination_tree(graph, order, threads);
  FrontTree fronts = fundamental_supernodes(graph, tree);
  amalgamate(fronts);
  if (height == TreeHeight::low) lower_tree(fronts);
  bundle_crowds(graph, tree, parts, fronts);
  return unknowns_of(fronts, tree, partition);
}

}  // namespace mfs
