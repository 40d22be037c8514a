#include "plan/symbolic_plan.hpp"

#include <omp.h>

#include <algorithm>
#include <string>
#include <utility>

#include <mfs/error.hpp>
#include "ordering/diagonal_blocks.hpp"
#include "ordering/elimination_tree.hpp"
#include "ordering/first_error.hpp"
#include "ordering/transpose.hpp"
#include "plan/contribution_places.hpp"

namespace mfs {

BlockFlops block_flops(double s, double rest) {
  return {s * (s - 1) * (4 * s + 1) / 6, 2.0 * (s * s * rest) - s * rest, 2.0 * s * rest * rest};
}

Vertex SymbolicPlan::block_width(Vertex pivots) const {
  const Vertex blocks = (pivots + max_block_size - 1) / max_block_size;
  return (pivots + blocks - 1) / blocks;
}

bool SymbolicPlan::has_turns() const {
  return std::any_of(assembly_turn.begin(), assembly_turn.end(), [](Vertex turn) { return turn > 0; });
}

std::vector<Vertex> SymbolicPlan::position_of_rows() const {
  return inverse_permutation(row_of);
}

std::vector<Vertex> SymbolicPlan::position_of_columns() const {
  return inverse_permutation(column_of);
}

BlockFlops SymbolicPlan::flops_of(Vertex f) const {
  BlockFlops sum{0, 0, 0};
  const Vertex p = pivots(f), width = block_width(p);
  for (Vertex begin = 0; begin < p; begin += width) {
    const Vertex s = std::min(width, p - begin);
    const BlockFlops block = block_flops(s, p - begin - s + border_rows(f));
    sum.getrf += block.getrf;
    sum.trsm += block.trsm;
    sum.gemm += block.gemm;
  }
  return sum;
}

namespace {

// Builds one plan in the order of its public steps and is thrown away.
class PlanBuilder {
 public:
  PlanBuilder(const Pattern& pattern, const std::vector<Vertex>& row_order, const SeparatorTree& tree,
              int threads, const AssemblyTurns& turns)
      : pattern_(pattern),
        tree_(tree),
        row_order_(row_order),
        threads_(threads),
        turns_(turns),
        by_position_(threads) {}

  SymbolicPlan build(Vertex max_block_size) {
    plan_.max_block_size = max_block_size;
    number_unknowns();
    link_fronts();
    distribute_entries();
    find_borders();
    place_fronts();
    map_children_and_entries();
    count_flops();
    return std::move(plan_);
  }

 private:
  void number_unknowns() {
    plan_.n = pattern_.n;
    plan_.nnz = pattern_.nnz();
    plan_.column_of = tree_.order;
    plan_.row_of.resize(plan_.n);
    position_of_row_.resize(plan_.n);
    position_of_column_.resize(plan_.n);
#pragma omp parallel for num_threads(threads_) schedule(static)
    for (Vertex p = 0; p < plan_.n; ++p) {
      const Vertex unknown = tree_.order[p];
      plan_.row_of[p] = row_order_.empty() ? unknown : row_order_[unknown];
      position_of_row_[plan_.row_of[p]] = p;
      position_of_column_[unknown] = p;
    }
  }

  void link_fronts() {
    const Vertex fronts = tree_.num_nodes();
    plan_.num_fronts = fronts;
    plan_.pivot_begin = tree_.node_begin;
    plan_.parent = tree_.parent;
    std::vector<Vertex> depth(fronts, 0);
    for (Vertex f = fronts - 1; f >= 0; --f) {
      if (plan_.parent[f] >= 0) depth[f] = depth[plan_.parent[f]] + 1;
    }
    plan_.num_depths = fronts ? *std::max_element(depth.begin(), depth.end()) + 1 : 0;
    plan_.depth_begin.assign(plan_.num_depths + 1, 0);
    for (Vertex f = 0; f < fronts; ++f) ++plan_.depth_begin[plan_.num_depths - depth[f]];
    for (Vertex k = 0; k < plan_.num_depths; ++k) plan_.depth_begin[k + 1] += plan_.depth_begin[k];

    plan_.child_begin.assign(fronts + 1, 0);
    for (Vertex f = 0; f < fronts; ++f) {
      if (plan_.parent[f] >= 0) ++plan_.child_begin[plan_.parent[f] + 1];
    }
    for (Vertex f = 0; f < fronts; ++f) plan_.child_begin[f + 1] += plan_.child_begin[f];
    plan_.children.resize(plan_.child_begin[fronts]);
    std::vector<Vertex> next(plan_.child_begin.begin(), plan_.child_begin.end() - 1);
    for (Vertex f = 0; f < fronts; ++f) {
      if (plan_.parent[f] >= 0) plan_.children[next[plan_.parent[f]]++] = f;
    }
  }

  // Each entry goes to the front that eliminates the earlier of its row and column: those in its pivot
  // columns at or below the pivot block, column by column, then those in its pivot rows to the right of it,
  // likewise.
  void distribute_entries() {
    by_column_ = transpose(pattern_, threads_);
    plan_.entry_begin.assign(plan_.num_fronts + 1, 0);
    for_all_fronts([&](Vertex f) {
      Offset count = 0;
      visit_pivot_columns(f, [&](Vertex, Vertex, Offset) { ++count; });
      for (Vertex p = plan_.pivot_begin[f]; p < plan_.pivot_begin[f + 1]; ++p)
        visit_beyond_pivots(f, plan_.row_of[p], [&](Vertex, Offset) { ++count; });
      plan_.entry_begin[f + 1] = count;
    });
    for (Vertex f = 0; f < plan_.num_fronts; ++f) plan_.entry_begin[f + 1] += plan_.entry_begin[f];
    plan_.entry_row.resize(plan_.nnz);
    plan_.entry_in_row.resize(plan_.nnz);
    entry_column_.resize(plan_.nnz);
    plan_.entry_target.resize(plan_.nnz);
    std::vector<BeyondPivots> beyond(threads_);
    for_all_fronts([&](Vertex f) {
      Offset next = plan_.entry_begin[f];
      visit_pivot_columns(f, [&](Vertex p, Vertex row, Offset slot) { put(next++, p, row, slot); });
      put_beyond_pivots(f, next, beyond[omp_get_thread_num()]);
    });
  }

  void put(Offset entry, Vertex column_position, Vertex row, Offset slot) {
    plan_.entry_row[entry] = row;
    plan_.entry_in_row[entry] = static_cast<Vertex>(slot - pattern_.offsets[row]);
    entry_column_[entry] = column_position;
  }

  /// What one front has beyond its pivots.
  struct BeyondPivots {
    struct Entry {
      Vertex row, column_position;
      Offset slot;
    };
    std::vector<Vertex> rows, columns;  // of the pivots, ascending; positions, ascending
    std::vector<Offset> places;         // by column as it was met: its entries, then where the next one goes
    std::vector<Entry> entries;
  };

  // Rows come in ascending order, so that each column has its entries so.
  void put_beyond_pivots(Vertex f, Offset first, BeyondPivots& beyond) {
    RawVector<Vertex>& met = by_position_[omp_get_thread_num()];  // position -> number of the column, or -1
    if (met.empty()) met.assign(static_cast<std::size_t>(plan_.n), -1);
    const auto row_of = plan_.row_of.begin();
    beyond.rows.assign(row_of + plan_.pivot_begin[f], row_of + plan_.pivot_begin[f + 1]);
    std::sort(beyond.rows.begin(), beyond.rows.end());
    beyond.columns.clear();
    beyond.places.clear();
    beyond.entries.clear();
    for (const Vertex r : beyond.rows)
      visit_beyond_pivots(f, r, [&](Vertex position, Offset slot) {
        if (met[position] < 0) {
          met[position] = static_cast<Vertex>(beyond.columns.size());
          beyond.columns.push_back(position);
          beyond.places.push_back(0);
        }
        ++beyond.places[met[position]];
        beyond.entries.push_back({r, position, slot});
      });
    std::sort(beyond.columns.begin(), beyond.columns.end());
    for (const Vertex position : beyond.columns) first += std::exchange(beyond.places[met[position]], first);
    for (const auto& [row, position, slot] : beyond.entries)
      put(beyond.places[met[position]]++, position, row, slot);
    for (const Vertex position : beyond.columns) met[position] = -1;  // as find_borders() expects it
  }

  template <class Visit>
  void visit_pivot_columns(Vertex f, const Visit& visit) const {
    const Vertex begin = plan_.pivot_begin[f];
    for (Vertex p = begin; p < plan_.pivot_begin[f + 1]; ++p) {
      const Vertex column = plan_.column_of[p];
      for (Offset k = by_column_.offsets[column]; k < by_column_.offsets[column + 1]; ++k) {
        const Vertex row = by_column_.columns[k];
        if (position_of_row_[row] >= begin) visit(p, row, by_column_.slots[k]);
      }
    }
  }
  // Entries of one of the front's pivot rows.
  template <class Visit>
  void visit_beyond_pivots(Vertex f, Vertex row, const Visit& visit) const {
    const Vertex end = plan_.pivot_begin[f + 1];
    for (Offset k = pattern_.offsets[row]; k < pattern_.offsets[row + 1]; ++k) {
      const Vertex position = position_of_column_[pattern_.columns[k]];
      if (position >= end) visit(position, k);
    }
  }

  // The borders that one thread found, in pieces that stay where they are.
  class BorderStore {
   public:
    /// Keeps a copy.
    const Vertex* keep(const std::vector<Vertex>& border) {
      constexpr std::size_t kPiece = 1 << 14;
      if (left_ < border.size()) {
        left_ = std::max(kPiece, border.size());
        pieces_.emplace_back(left_);
        next_ = pieces_.back().data();
      }
      const Vertex* const kept = next_;
      next_ = std::copy(border.begin(), border.end(), next_);
      left_ -= border.size();
      return kept;
    }

   private:
    std::vector<RawVector<Vertex>> pieces_;
    Vertex* next_ = nullptr;
    std::size_t left_ = 0;
  };
  struct Border {
    const Vertex* begin = nullptr;
    std::size_t count = 0;
    const Vertex* end() const { return begin + count; }
  };

  // border(f) = rows and columns beyond f's pivots that its own entries or its children's borders reach.
  void find_borders() {
    std::vector<BorderStore> stores(threads_);
    std::vector<std::vector<Vertex>> reached(threads_);
    std::vector<Border> borders(plan_.num_fronts);
    for (Vertex k = 0; k < plan_.num_depths; ++k) {
      for_fronts(plan_.depth_begin[k], plan_.depth_begin[k + 1], [&](Vertex f) {
        const int thread = omp_get_thread_num();
        RawVector<Vertex>& seen_by = by_position_[thread];
        if (seen_by.empty()) seen_by.assign(static_cast<std::size_t>(plan_.n), -1);
        find_border(f, borders, seen_by, reached[thread]);
        borders[f] = {stores[thread].keep(reached[thread]), reached[thread].size()};
      });
    }
    plan_.border_begin.assign(plan_.num_fronts + 1, 0);
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      check_branch(f, borders[f].begin, borders[f].end());
      plan_.border_begin[f + 1] = plan_.border_begin[f] + static_cast<Offset>(borders[f].count);
    }
    plan_.border.resize(plan_.border_begin[plan_.num_fronts]);
    for_all_fronts([&](Vertex f) {
      std::copy(borders[f].begin, borders[f].end(), plan_.border.begin() + plan_.border_begin[f]);
    });
  }

  // `seen_by`: position -> front that reached it last.
  void find_border(Vertex f, const std::vector<Border>& borders, RawVector<Vertex>& seen_by,
                   std::vector<Vertex>& reached) const {
    const Vertex pivots_end = plan_.pivot_begin[f + 1];
    reached.clear();
    const auto reach = [&](Vertex position) {
      if (position >= pivots_end && seen_by[position] != f) {
        seen_by[position] = f;
        reached.push_back(position);
      }
    };
    for (Offset e = plan_.entry_begin[f]; e < plan_.entry_begin[f + 1]; ++e) {
      reach(std::max(position_of_row_[plan_.entry_row[e]], entry_column_[e]));
    }
    for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
      const Border& of_child = borders[plan_.children[c]];
      for (const Vertex* b = of_child.begin; b != of_child.end(); ++b) reach(*b);
    }
    std::sort(reached.begin(), reached.end());
  }

  // The border of a front begins in its parent at the earliest, and a root has none.
  void check_branch(Vertex f, const Vertex* begin, const Vertex* end) const {
    const Vertex parent = plan_.parent[f];
    if (begin == end || (parent >= 0 && *begin >= plan_.pivot_begin[parent])) return;
    throw InvalidInput("tree", "an entry joins two branches of the tree", plan_.row_of[*begin],
                       plan_.column_of[plan_.pivot_begin[f]]);
  }

  void place_fronts() {
    const Vertex fronts = plan_.num_fronts;
    plan_.lower_begin.resize(fronts);
    plan_.upper_begin.resize(fronts);
    Offset next = 0;
    std::vector<Offset> factors_end;  // by step
    for (Vertex k = 0; k < plan_.num_depths; ++k) {
      for (Vertex f = plan_.depth_begin[k]; f < plan_.depth_begin[k + 1]; ++f) {
        const Offset p = plan_.pivots(f), b = plan_.border_rows(f);
        plan_.lower_begin[f] = next;
        next += aligned(p * plan_.lower_ld(f));
        plan_.upper_begin[f] = next;
        next += aligned(p * b);
        plan_.nnz_factor += p * p + 2 * p * b;
        plan_.max_front = std::max(plan_.max_front, static_cast<Vertex>(p + b));
      }
      factors_end.push_back(next);
    }
    plan_.factor_entries = next;
    place_contributions(plan_, factors_end, turns_);
  }

  void map_children_and_entries() {
    plan_.border_in_parent.resize(plan_.border.size());
    for_all_fronts([&](Vertex f) {
      RawVector<Vertex>& local = by_position_[omp_get_thread_num()];  // position -> row of the front
      if (local.empty()) local.resize(static_cast<std::size_t>(plan_.n));
      const Vertex p = plan_.pivots(f), front_rows = p + plan_.border_rows(f), ld = plan_.lower_ld(f);
      for (Vertex i = 0; i < p; ++i) local[plan_.pivot_begin[f] + i] = i;
      for (Vertex i = p; i < front_rows; ++i) local[plan_.border[plan_.border_begin[f] + i - p]] = i;
      for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
        const Vertex child = plan_.children[c];
        for (Offset b = plan_.border_begin[child]; b < plan_.border_begin[child + 1]; ++b) {
          plan_.border_in_parent[b] = local[plan_.border[b]];
        }
      }
      for (Offset e = plan_.entry_begin[f]; e < plan_.entry_begin[f + 1]; ++e) {
        const Offset i = local[position_of_row_[plan_.entry_row[e]]];
        const Offset j = local[entry_column_[e]];
        plan_.entry_target[e] =
            j < p ? plan_.lower_begin[f] + i + j * ld : plan_.upper_begin[f] + i + (j - p) * p;
      }
    });
  }

  void count_flops() {
    plan_.front_flops.resize(plan_.num_fronts);
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      const BlockFlops flops = plan_.flops_of(f);
      plan_.front_flops[f] = flops.total();
      plan_.flops.getrf += flops.getrf;
      plan_.flops.trsm += flops.trsm;
      plan_.flops.gemm += flops.gemm;
    }
  }

  // `work(f)` for independent fronts; omp_get_thread_num() tells the thread. The last ones, which mostly are
  // the largest, come first and one by one.
  template <class Work>
  void for_fronts(Vertex first, Vertex last, const Work& work) const {
    constexpr Vertex kChunk = 16, kOneByOne = 32 * kChunk, kWorthThreads = 1024;  // pivots
    const Vertex middle = std::max(first, last - kOneByOne);
    const bool shared =
        last - first > kChunk || plan_.pivot_begin[last] - plan_.pivot_begin[first] > kWorthThreads;
    FirstError error;
#pragma omp parallel num_threads(threads_) if (shared)
    {
#pragma omp for schedule(dynamic, 1) nowait
      for (Vertex f = last - 1; f >= middle; --f) error.attempt([&] { work(f); });
#pragma omp for schedule(dynamic, kChunk)
      for (Vertex f = first; f < middle; ++f) error.attempt([&] { work(f); });
    }
    error.rethrow();
  }
  template <class Work>
  void for_all_fronts(const Work& work) const {
    for_fronts(0, plan_.num_fronts, work);
  }

  const Pattern& pattern_;
  const SeparatorTree& tree_;
  const std::vector<Vertex>& row_order_;
  const int threads_;
  const AssemblyTurns turns_;
  RawVector<Vertex> position_of_row_, position_of_column_;
  TransposedPattern by_column_;
  std::vector<RawVector<Vertex>> by_position_;  // n, once a thread needs it; by thread
  RawVector<Vertex> entry_column_;              // position of the column of each entry of the plan
  SymbolicPlan plan_;
};

}  // namespace

SymbolicPlan make_symbolic_plan(const Pattern& pattern, const std::vector<Vertex>& row_order,
                                const SeparatorTree& tree, Vertex max_block_size, int threads,
                                const AssemblyTurns& turns) {
  return PlanBuilder(pattern, row_order, tree, threads, turns).build(max_block_size);
}

SymbolicPlan make_symbolic_plan(const Pattern& pattern, const DiagonalBlocks* blocks,
                                const std::vector<Vertex>& row_order, const SeparatorTree& tree,
                                Vertex max_block_size, int threads, const AssemblyTurns& turns) {
  if (!blocks) return make_symbolic_plan(pattern, row_order, tree, max_block_size, threads, turns);
  const Pattern& inner = blocks->pattern;
  SymbolicPlan plan = make_symbolic_plan(inner, row_order, tree, max_block_size, threads, turns);
  const auto entries = static_cast<Offset>(plan.entry_row.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Offset e = 0; e < entries; ++e)
    plan.entry_in_row[e] = blocks->in_row[inner.offsets[plan.entry_row[e]] + plan.entry_in_row[e]];
  plan.nnz = pattern.nnz();
  plan.triangle = make_block_triangle(plan, pattern, *blocks);
  return plan;
}

}  // namespace mfs
