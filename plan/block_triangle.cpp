#include "plan/block_triangle.hpp"

#include <algorithm>
#include <numeric>

#include "ordering/diagonal_blocks.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

namespace {

/// Makes one triangle and is thrown away.
class TriangleMaker {
 public:
  TriangleMaker(const SymbolicPlan& plan, const Pattern& pattern, const DiagonalBlocks& blocks)
      : plan_(plan), pattern_(pattern), blocks_(blocks), position_of_column_(plan.position_of_columns()) {}

  BlockTriangle make() {
    list_by_row();
    list_by_column();
    list_fronts();
    return std::move(made_);
  }

 private:
  void list_by_row() {
    BlockTriangle::Couplings& by_row = made_.by_row;
    by_row.begin.push_back(0);
    for (Vertex p = 0; p < plan_.n; ++p) {
      const Vertex row = plan_.row_of[p];
      for (Offset k = pattern_.offsets[row]; k < pattern_.offsets[row + 1]; ++k) {
        if (blocks_.of_column[pattern_.columns[k]] == blocks_.of_row[row]) continue;
        by_row.others.push_back(position_of_column_[pattern_.columns[k]]);
        by_row.number.push_back(made_.couplings());
        made_.slot.push_back(k);
      }
      by_row.begin.push_back(made_.couplings());
    }
  }

  void list_by_column() {
    const BlockTriangle::Couplings& by_row = made_.by_row;
    BlockTriangle::Couplings& by_column = made_.by_column;
    by_column.begin.assign(static_cast<std::size_t>(plan_.n) + 1, 0);
    for (const Vertex column : by_row.others) ++by_column.begin[column + 1];
    std::partial_sum(by_column.begin.begin(), by_column.begin.end(), by_column.begin.begin());
    by_column.others.resize(by_row.others.size());
    by_column.number.resize(by_row.others.size());
    std::vector<Offset> next(by_column.begin.begin(), by_column.begin.end() - 1);
    for (Vertex p = 0; p < plan_.n; ++p) {
      for (Offset k = by_row.begin[p]; k < by_row.begin[p + 1]; ++k) {
        const Offset place = next[by_row.others[k]]++;
        by_column.others[place] = p;
        by_column.number[place] = by_row.number[k];
      }
    }
  }

  // In postorder, so that a front finds what its children left in the cache.
  void list_fronts() {
    made_.level_begin = blocks_.level_begin;
    std::vector<Vertex> roots;
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      if (plan_.parent[f] < 0) roots.push_back(f);
    }
    std::stable_sort(roots.begin(), roots.end(),
                     [&](Vertex a, Vertex b) { return block_of(a) < block_of(b); });
    made_.front.reserve(static_cast<std::size_t>(plan_.num_fronts));
    made_.block_begin.push_back(0);
    for (const Vertex root : roots) {
      for (Vertex b = made_.blocks(); b < block_of(root); ++b) end_block();
      list_tree(root);
    }
    end_block();
  }
  void end_block() { made_.block_begin.push_back(static_cast<Vertex>(made_.front.size())); }
  // Parents first and the last child next, from the end.
  void list_tree(Vertex root) {
    const auto begin = static_cast<std::ptrdiff_t>(made_.front.size());
    waiting_.assign(1, root);
    while (!waiting_.empty()) {
      const Vertex f = waiting_.back();
      waiting_.pop_back();
      made_.front.push_back(f);
      waiting_.insert(waiting_.end(), plan_.children.begin() + plan_.child_begin[f],
                      plan_.children.begin() + plan_.child_begin[f + 1]);
    }
    std::reverse(made_.front.begin() + begin, made_.front.end());
  }

  Vertex block_of(Vertex f) const { return blocks_.of_column[plan_.column_of[plan_.pivot_begin[f]]]; }

  const SymbolicPlan& plan_;
  const Pattern& pattern_;
  const DiagonalBlocks& blocks_;
  const std::vector<Vertex> position_of_column_;
  std::vector<Vertex> waiting_;
  BlockTriangle made_;
};

}  // namespace

BlockTriangle make_block_triangle(const SymbolicPlan& plan, const Pattern& pattern,
                                  const DiagonalBlocks& blocks) {
  return TriangleMaker(plan, pattern, blocks).make();
}

}  // namespace mfs
