#include "ordering/diagonal_blocks.hpp"

#include <algorithm>
#include <numeric>

#include "ordering/elimination_tree.hpp"
#include "ordering/fronts.hpp"
#include "ordering/lists_by_key.hpp"

namespace mfs {

namespace {

/// One search through all unknowns. Those on the way from its root to the present one are the path; those
/// that are seen and have no block yet are open.
class ComponentSearch {
 public:
  ComponentSearch(const Pattern& pattern, const MatchedScaling& matched)
      : pattern_(pattern),
        row_order_(matched.row_order),
        pair_(matched.pair),
        block_(static_cast<std::size_t>(pattern.n), -1),
        seen_(block_.size(), -1),
        next_(block_.size()) {}

  std::vector<Vertex> search() {
    for (Vertex root = 0; root < pattern_.n; ++root) {
      if (seen_[root] < 0) search_from(root);
    }
    return std::move(block_);
  }

 private:
  struct Step {
    Vertex unknown, lowest;  // the earliest open unknown that is known to be reached from here
  };

  Vertex row_of(Vertex i) const { return row_order_.empty() ? i : row_order_[i]; }

  void enter(Vertex i) {
    seen_[i] = number_++;
    next_[i] = pattern_.offsets[row_of(i)];
    path_.push_back({i, seen_[i]});
    open_.push_back(i);
    if (!pair_.empty()) reach(pair_[i]);
  }

  void search_from(Vertex root) {
    enter(root);
    while (!path_.empty()) {
      const Vertex i = path_.back().unknown;
      if (next_[i] < pattern_.offsets[row_of(i) + 1]) {
        reach(pattern_.columns[next_[i]++]);
      } else {
        leave();
      }
    }
  }

  // From the end of the path.
  void reach(Vertex j) {
    if (seen_[j] < 0) {
      enter(j);
    } else if (block_[j] < 0) {
      path_.back().lowest = std::min(path_.back().lowest, seen_[j]);
    }
  }

  void leave() {
    const Step done = path_.back();
    path_.pop_back();
    if (!path_.empty()) path_.back().lowest = std::min(path_.back().lowest, done.lowest);
    if (done.lowest < seen_[done.unknown]) return;
    Vertex i;
    do {
      i = open_.back();
      open_.pop_back();
      block_[i] = blocks_;
    } while (i != done.unknown);
    ++blocks_;
  }

  const Pattern& pattern_;
  const std::vector<Vertex>&row_order_, &pair_;
  std::vector<Vertex> block_, seen_;  // seen_: the number under which an unknown was entered
  RawVector<Offset> next_;            // slot
  std::vector<Step> path_;
  std::vector<Vertex> open_;
  Vertex number_ = 0, blocks_ = 0;
};

/// 0 ... key.size() - 1 by keys, of which each up to the largest occurs.
Lists lists_of_all(const std::vector<Vertex>& key) {
  return lists_by_key(key, *std::max_element(key.begin(), key.end()) + 1);
}

/// By block: the number of blocks on the longest way to it. `unknowns`: by block.
std::vector<Vertex> levels_of(const Pattern& pattern, const std::vector<Vertex>& row_order,
                              const std::vector<Vertex>& block, const Lists& unknowns) {
  std::vector<Vertex> level(unknowns.begin.size() - 1, 0);
  for (const Vertex i : unknowns.item) {
    const Vertex row = row_order.empty() ? i : row_order[i], own = block[i];
    for (Offset k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k) {
      const Vertex other = block[pattern.columns[k]];
      if (other != own) level[own] = std::max(level[own], level[other] + 1);
    }
  }
  return level;
}

Vertex largest_block(const Lists& unknowns) {
  Vertex most = 0;
  for (std::size_t b = 0; b + 1 < unknowns.begin.size(); ++b)
    most = std::max(most, unknowns.begin[b + 1] - unknowns.begin[b]);
  return most;
}

/// A's entries inside the blocks.
void keep_inner_entries(const Pattern& pattern, DiagonalBlocks& blocks) {
  Pattern& inner = blocks.pattern;
  inner.n = pattern.n;
  inner.offsets.push_back(0);
  for (Vertex row = 0; row < pattern.n; ++row) {
    const Offset begin = pattern.offsets[row], end = pattern.offsets[row + 1];
    for (Offset k = begin; k < end; ++k) {
      if (blocks.of_column[pattern.columns[k]] != blocks.of_row[row]) continue;
      inner.columns.push_back(pattern.columns[k]);
      blocks.in_row.push_back(static_cast<Vertex>(k - begin));
    }
    inner.offsets.push_back(static_cast<Offset>(inner.columns.size()));
  }
  inner.num_entries = inner.nnz();
}

}  // namespace

std::vector<Vertex> strong_components(const Pattern& pattern, const MatchedScaling& matched) {
  return ComponentSearch(pattern, matched).search();
}

std::shared_ptr<const DiagonalBlocks> find_diagonal_blocks(const Pattern& pattern,
                                                           const MatchedScaling& matched,
                                                           double largest_part) {
  if (pattern.n == 0 || largest_part == 0) return nullptr;
  const std::vector<Vertex> component = strong_components(pattern, matched);
  const Lists unknowns = lists_of_all(component);
  const Vertex most = largest_block(unknowns);
  if (most == pattern.n || most > largest_part * pattern.n) return nullptr;
  const Lists blocks_of_level = lists_of_all(levels_of(pattern, matched.row_order, component, unknowns));
  if (blocks_of_level.begin.size() == 2) return nullptr;
  auto blocks = std::make_shared<DiagonalBlocks>();
  blocks->level_begin = blocks_of_level.begin;
  blocks->of_row.resize(component.size());
  blocks->of_column.resize(component.size());
  const std::vector<Vertex> place = inverse_permutation(blocks_of_level.item);
  for (Vertex i = 0; i < pattern.n; ++i) {
    blocks->of_column[i] = place[component[i]];
    blocks->of_row[matched.row_order.empty() ? i : matched.row_order[i]] = place[component[i]];
  }
  keep_inner_entries(pattern, *blocks);
  return blocks;
}

SeparatorTree in_block_order(const SeparatorTree& tree, const DiagonalBlocks& blocks) {
  const Vertex nodes = tree.num_nodes();
  std::vector<Vertex> depth(static_cast<std::size_t>(nodes), 0), sorted(depth.size());
  for (Vertex k = nodes - 1; k >= 0; --k) {
    if (tree.parent[k] >= 0) depth[k] = depth[tree.parent[k]] + 1;
  }
  const auto block_of = [&](Vertex k) { return blocks.of_column[tree.order[tree.node_begin[k]]]; };
  std::iota(sorted.begin(), sorted.end(), 0);
  std::stable_sort(sorted.begin(), sorted.end(), [&](Vertex a, Vertex b) {
    return depth[a] != depth[b] ? depth[a] > depth[b] : block_of(a) < block_of(b);
  });
  return in_order({tree.order, tree.node_begin, tree.parent}, sorted);
}

}  // namespace mfs
