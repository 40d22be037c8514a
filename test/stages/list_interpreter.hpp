// Does on the host, by plain loops, what the lists of a DevicePlan tell the device: block after block of
// every launch, each from what was there before the launch, as blocks of one launch run at the same time.
// Without pivoting. All memory is NaN before.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "plan/device_plan.hpp"
#include "test/stages/front_blocks.hpp"

namespace mfs::test {

inline std::set<Vertex> fronts_of(const DevicePlan& lists, const SolveLaunch& launch) {
  std::set<Vertex> fronts;
  for (Offset i = launch.tiny.begin; i < launch.tiny.end; ++i) fronts.insert(lists.tiny_fronts[i]);
  for (Offset i = launch.tiles.begin; i < launch.tiles.end; ++i) fronts.insert(lists.solve[i].front);
  return fronts;
}

class ListInterpreter {
 public:
  /// When what may run beside other launches runs.
  enum class Concurrent { at_once, late };

  ListInterpreter(const StageProblem<double>& problem, const DevicePlan& lists, Concurrent concurrent,
                  Vertex waiting_tiles)
      : problem_(problem),
        plan_(*problem.plan),
        lists_(lists),
        concurrent_(concurrent),
        waiting_tiles_(static_cast<std::size_t>(waiting_tiles)) {
    storage_.assign(static_cast<std::size_t>(plan_.storage_entries), kNothing);
  }

  /// Calls after_depth(step) when all fronts of a depth (or segment) are done, and before(step) ahead of
  /// them.
  template <class After>
  void factor(const After& after_depth) {
    factor([](Vertex) {}, after_depth);
  }
  template <class Before, class After>
  void factor(const Before& before, const After& after_depth) {
    for (std::size_t step = 0; step < lists_.depths.size(); ++step) {
      const DepthLaunches& depth = lists_.depths[step];
      assemble_early(static_cast<Vertex>(step), before);
      before(static_cast<Vertex>(step));
      const bool is_assembled = early_ && lists_.segments.is_assembled_early(static_cast<Vertex>(step));
      const auto assemble_from = [&](std::size_t turn) {
        if (is_assembled) return;
        for (; turn < depth.assemble_contribution.size(); ++turn) assemble(depth.assemble_contribution[turn]);
      };
      if (concurrent_ == Concurrent::at_once) {
        factor_small(depth);
        if (!is_assembled) assemble(depth.assemble_contribution.front());
      }
      if (!is_assembled) assemble(depth.assemble);
      if (concurrent_ == Concurrent::at_once) assemble_from(1);
      std::vector<Launch> late;
      const auto join = [&] {
        for (const Launch& launch : late) run(launch);
        late.clear();
      };
      for (const Launch& launch : depth.factor) {
        if (launch.order == Order::join) join();
        if (launch.order == Order::concurrent && concurrent_ == Concurrent::late) {
          late.push_back(launch);
        } else {
          run(launch);
        }
      }
      join();
      if (concurrent_ == Concurrent::late) assemble_from(0);
      for (const Launch& launch : depth.update) run(launch);
      if (concurrent_ == Concurrent::late) factor_small(depth);
      after_depth(static_cast<Vertex>(step));
    }
  }

  /// Segments are assembled as soon as that may be, not when it is their turn.
  void assemble_early() { early_ = true; }

  /// Additions, multiplications and divisions so far: of diagonal tiles, strips and products; in small
  /// fronts, of the pivot block, of the contribution block, and of all else.
  const BlockFlops& flops() const { return flops_; }

  FrontBlocks<double> front(Vertex f) const { return blocks_in(plan_, storage_.data(), f); }
  std::vector<double>& storage() { return storage_; }
  const std::vector<double>& storage() const { return storage_; }
  /// Fronts lie in one piece, also those whose columns have segments of their own.
  void take_whole_fronts() { whole_fronts_ = true; }
  /// Contribution blocks of children are read where block_at(child) says, unless that is null.
  void read_blocks_at(std::function<const double*(Vertex)> block_at) { block_at_ = std::move(block_at); }

  /// v := A^-1 v by position. Forward, a tile that needs what comes later in its list makes NaN of it;
  /// backward it waits, as at most DeviceLimits::waiting_tiles may.
  void solve(std::vector<double>& v) const {
    solve(v, [](bool, std::size_t) {});
  }
  /// Calls before(forward, number of the launch in its direction) ahead of each launch.
  template <class Before>
  void solve(std::vector<double>& v, const Before& before) const {
    std::vector<double> y(v.size(), kNothing);
    std::vector<double> border(static_cast<std::size_t>(lists_.border_places), kNothing);
    for (const SolveLaunch& launch : lists_.forward) {
      before(true, static_cast<std::size_t>(&launch - lists_.forward.data()));
      expect_one_depth(launch);
      for (Offset i = launch.tiny.begin; i < launch.tiny.end; ++i) {
        const Vertex f = lists_.tiny_fronts[i];
        forward(f, 0, plan_.pivots(f), v, y, border);
        forward(f, plan_.pivots(f), rows(f), v, y, border);
      }
      for (Offset i = launch.tiles.begin; i < launch.tiles.end; ++i) {
        const SolvePart& part = lists_.solve[i];
        EXPECT_TRUE(part.finishes && part.first_step == 0 && part.parts == 0) << "parts are for backward";
        expect_where(part);
        forward(part.front, part.begin, tile_end(part), v, y, border);
      }
      if (lists_.segments.empty()) forget_others(launch.border, border);
    }
    v.assign(v.size(), kNothing);
    std::vector<double> partial = no_sums();
    for (const SolveLaunch& launch : lists_.backward) {
      before(false, static_cast<std::size_t>(&launch - lists_.backward.data()));
      expect_one_depth(launch);
      for (Offset i = launch.tiny.begin; i < launch.tiny.end; ++i)
        backward(whole(lists_.tiny_fronts[i], 0), plan_.pivots(lists_.tiny_fronts[i]), y, v, partial);
      std::vector<SolvePart> waiting;
      for (Offset i = launch.tiles.begin; i < launch.tiles.end; ++i) {
        expect_where(lists_.solve[i]);
        waiting.push_back(lists_.solve[i]);
        for (std::size_t k = 0; k < waiting.size();) {
          if (!is_ready(waiting[k], v, partial)) {
            ++k;
            continue;
          }
          backward(waiting[k], tile_end(waiting[k]), y, v, partial);
          waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(k));
          k = 0;
        }
        EXPECT_LE(waiting.size(), waiting_tiles_) << "they may fill the device";
      }
      EXPECT_TRUE(waiting.empty());
    }
  }

 private:
  static constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  // When `done` segments are.
  template <class Before>
  void assemble_early(Vertex done, const Before& before) {
    if (!early_) return;
    for (Vertex t = 0; t < static_cast<Vertex>(lists_.segments.segments.size()); ++t) {
      if (!lists_.segments.is_assembled_early(t) || lists_.segments.segments[t].assembled_after != done)
        continue;
      before(t);
      assemble(lists_.depths[t].assemble);
      for (const Range& turn : lists_.depths[t].assemble_contribution) assemble(turn);
    }
  }
  Vertex rows(Vertex f) const { return plan_.pivots(f) + plan_.border_rows(f); }
  // Everything from row `begin` of a front on, in one part of no steps.
  static SolvePart whole(Vertex f, Vertex begin) { return {f, begin, 0, 0, true, 0, 0, {}, 0}; }
  // What warps solve with is waited for by launches, not by tiles.
  void expect_one_depth(const SolveLaunch& launch) const {
    const auto& begin = plan_.depth_begin;
    std::set<Vertex> depths;
    for (const Vertex f : fronts_of(lists_, launch))
      depths.insert(static_cast<Vertex>(std::upper_bound(begin.begin(), begin.end(), f) - begin.begin()));
    EXPECT_TRUE(launch.tiny.count() == 0 || depths.size() == 1);
  }
  // Whether what a tile waits for is there: its parts and the tile before it. What comes from higher depths
  // is, or it makes NaN.
  bool is_ready(const SolvePart& part, const std::vector<double>& v,
                const std::vector<double>& partial) const {
    const Vertex end = tile_end(part);
    if (part.finishes && end < plan_.pivots(part.front) && std::isnan(v[plan_.pivot_begin[part.front] + end]))
      return false;
    for (Vertex k = 0; k < part.parts; ++k) {
      if (std::isnan(partial[(part.place + k) * kSolveTile])) return false;
    }
    return true;
  }
  std::vector<double> no_sums() const {
    return std::vector<double>(static_cast<std::size_t>(lists_.solve_places) * kSolveTile, kNothing);
  }
  void expect_where(const SolvePart& part) const {
    const Vertex f = part.front;
    const SolveFront& at = part.where;
    EXPECT_EQ(
        std::tie(at.lower, at.upper, at.border_at, at.rows_at),
        std::tie(plan_.lower_begin[f], plan_.upper_begin[f], plan_.border_begin[f], lists_.row_begin[f]));
    EXPECT_EQ(
        std::make_tuple(at.pivots_at, at.pivots, at.border, at.ld),
        std::make_tuple(plan_.pivot_begin[f], plan_.pivots(f), plan_.border_rows(f), plan_.lower_ld(f)));
  }
  Vertex tile_end(const SolvePart& part) const {
    const Vertex p = plan_.pivots(part.front), left = (part.begin < p ? p : rows(part.front)) - part.begin;
    const bool tall = part.begin >= p && part.last_step == 1 && part.rows > kSolveTile;
    EXPECT_EQ(part.rows, std::min(left, tall ? kTallTile : kSolveTile));
    return part.begin + part.rows;
  }

  // Entry (i, j) of front f, wherever it lies.
  template <class Self>
  static auto& entry_of(Self& self, Vertex f, Vertex i, Vertex j) {
    const SymbolicPlan& plan = self.plan_;
    const Offset p = plan.pivots(f);
    if (j < p) return self.storage_[plan.lower_begin[f] + i + static_cast<Offset>(j) * plan.lower_ld(f)];
    Offset upper = plan.upper_begin[f], contribution = plan.contribution_begin[f];
    if (self.lists_.segments.has_divided() && !self.whole_fronts_) {
      auto [columns, end] = self.lists_.segments.columns_of(f);
      for (; columns != end; ++columns) {
        if (j < columns->begin || j >= columns->end) continue;
        upper = columns->upper;
        contribution = columns->contribution;
      }
    }
    if (i < p) return self.storage_[upper + i + (j - p) * p];
    return self.storage_[contribution + i - p + (j - p) * plan.contribution_ld(f)];
  }
  double& at(Vertex f, Vertex i, Vertex j) { return entry_of(*this, f, i, j); }
  double at(Vertex f, Vertex i, Vertex j) const { return entry_of(*this, f, i, j); }

  // Where original entry e of front f goes.
  double& target(Vertex f, Offset e) {
    const Offset p = plan_.pivots(f), ld = plan_.lower_ld(f),
                 upper = plan_.entry_target[e] - plan_.upper_begin[f],
                 lower = plan_.entry_target[e] - plan_.lower_begin[f];
    if (lower >= 0 && lower < p * ld)
      return at(f, static_cast<Vertex>(lower % ld), static_cast<Vertex>(lower / ld));
    return at(f, static_cast<Vertex>(upper % p), static_cast<Vertex>(p + upper / p));
  }
  // `to(place)`: the entry that a place means.
  template <class To>
  void add_entries(Vertex f, Offset begin, Offset end, const To& to) {
    for (Offset e = begin; e < end; ++e) {
      double& entry = to(lists_.entry_place[e]);
      EXPECT_EQ(&entry, &target(f, e));
      const Vertex row = plan_.entry_row[e];
      const Offset slot = problem_.pattern->offsets[row] + plan_.entry_in_row[e];
      const double scale = problem_.row_scale[row] * problem_.column_scale[problem_.pattern->columns[slot]];
      entry += problem_.values[slot] * scale;
    }
  }
  double child_entry(Vertex child, Vertex i, Vertex j) const {
    const double* const elsewhere = block_at_ ? block_at_(child) : nullptr;
    const double* const block = elsewhere ? elsewhere : &storage_[plan_.contribution_begin[child]];
    return block[i + static_cast<Offset>(j) * plan_.contribution_ld(child)];
  }

  // Eliminates pivots [k, next) of a front from rows and columns up to `end`.
  void eliminate(Vertex f, Vertex k, Vertex next, Vertex end) {
    const Vertex p = plan_.pivots(f);
    for (; k < next; ++k) {
      for (Vertex i = k + 1; i < end; ++i) {
        at(f, i, k) /= at(f, k, k);
        ++(i < p ? flops_.getrf : flops_.trsm);
      }
      for (Vertex j = k + 1; j < end; ++j) {
        for (Vertex i = k + 1; i < end; ++i) {
          at(f, i, j) -= at(f, i, k) * at(f, k, j);
          (i < p && j < p ? flops_.getrf : i < p || j < p ? flops_.trsm : flops_.gemm) += 2;
        }
      }
    }
  }

  // Small fronts need the plan alone.
  void factor_small(const DepthLaunches& depth) {
    EXPECT_LE(depth.small.size(), static_cast<std::size_t>(kMostSmallLaunches));
    for (const SmallLaunch& launch : depth.small) {
      for (Offset k = launch.fronts.begin; k < launch.fronts.end; ++k) {
        const Vertex f = lists_.small_fronts[k];
        EXPECT_LE(rows(f), launch.rows);
        for (Vertex j = 0; j < rows(f); ++j) {
          for (Vertex i = 0; i < rows(f); ++i) at(f, i, j) = 0;
        }
        const Vertex lower = plan_.pivots(f) * rows(f);
        add_entries(f, plan_.entry_begin[f], plan_.entry_begin[f + 1], [&](Vertex place) -> double& {
          return storage_[place < lower ? plan_.lower_begin[f] + place
                                        : plan_.upper_begin[f] + place - lower];
        });
        for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
          const Vertex child = plan_.children[c], *map = &plan_.border_in_parent[plan_.border_begin[child]];
          for (Vertex j = 0; j < plan_.border_rows(child); ++j) {
            for (Vertex i = 0; i < plan_.border_rows(child); ++i)
              at(f, map[i], map[j]) += child_entry(child, i, j);
          }
        }
        eliminate(f, 0, plan_.pivots(f), rows(f));
      }
    }
  }

  void assemble(const AssemblyPart& part) {
    const Vertex f = part.front, p = plan_.pivots(f);
    EXPECT_TRUE(part.end <= p || (part.begin >= p && (part.last_row <= p || part.first_row >= p)));
    const Offset ld = part.begin < p ? plan_.lower_ld(f) : part.first_row < p ? p : plan_.contribution_ld(f);
    for (Vertex j = part.begin; j < part.end; ++j) {
      EXPECT_TRUE(assembled_.emplace(f, j, part.first_row).second) << "assembled twice";
      EXPECT_EQ(&storage_[part.place + part.first_row + j * ld], &at(f, part.first_row, j));
      double* const column = &storage_[part.place + j * ld];
      for (Vertex i = part.first_row; i < part.last_row; ++i) {
        column[i] = 0;
        for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
          const Vertex* const map = &lists_.child_row[lists_.child_row_begin[c]];
          if (map[i] >= 0 && map[j] >= 0) column[i] += child_entry(plan_.children[c], map[i], map[j]);
        }
      }
    }
    double* const first = &storage_[part.place + part.begin * ld];
    add_entries(f, part.first_entry, part.last_entry, [&](Vertex place) -> double& { return first[place]; });
  }
  void assemble(const Range& parts) {
    for (Offset i = parts.begin; i < parts.end; ++i) assemble(lists_.assemble[i]);
  }

  // The task that a block belongs to, as the device finds it.
  template <class Task>
  static const Task& task_of(const std::vector<Task>& tasks, const Range& range, Vertex Task::*first,
                             Vertex block) {
    Offset found = range.begin;
    for (Offset i = range.begin; i < range.end; ++i) {
      if (tasks[i].*first <= block) found = i;
    }
    return tasks[found];
  }

  void run(const Launch& launch) {
    using Kind = Launch::Kind;
    if (launch.kind == Kind::diagonal) {
      EXPECT_EQ(launch.blocks, launch.tasks.count());
      for (Offset i = launch.tasks.begin; i < launch.tasks.end; ++i) {
        const StepTask& task = lists_.steps[i];
        const Vertex next = std::min(task.k + lists_.tile, plan_.pivots(task.front));
        EXPECT_LE(next - task.k, launch.width);
        eliminate(task.front, task.k, next, next);
        if (next == plan_.pivots(task.front)) border_seen_[task.front] = border_below(task);
      }
    } else if (launch.kind == Kind::strips) {
      for (Vertex block = 0; block < launch.blocks; ++block) {
        const StepTask& task = task_of(lists_.steps, launch.tasks, &StepTask::first_strip, block);
        const auto seen = border_seen_.find(task.front);
        if (block == task.first_strip && seen != border_seen_.end()) {
          EXPECT_EQ(seen->second, border_below(task)) << "the last tile looks at what is not made yet";
          border_seen_.erase(seen);
        }
        solve_strip(task, block - task.first_strip);
      }
    } else {
      const std::vector<double> before = storage_;
      const Vertex height = launch.kind == Kind::wide_products ? 128 : 64;
      for (Vertex block = 0; block < launch.blocks; ++block) {
        const ProductTask& task = task_of(lists_.products, launch.tasks, &ProductTask::first_tile, block);
        if (launch.kind == Kind::vendor_gemm) {
          EXPECT_EQ(launch.tasks.count(), 1);
          subtract_product(task, {0, task.m}, {0, task.n}, before);
        } else {
          const Vertex tile = block - task.first_tile, down = (task.m + height - 1) / height;
          const Vertex row = tile % down * height, column = tile / down * 64;
          EXPECT_LT(column, task.n) << "a block without work";
          subtract_product(task, {row, std::min(row + height, task.m)},
                           {column, std::min(column + 64, task.n)}, before);
        }
      }
    }
  }

  // The border rows of the columns of a tile.
  std::vector<double> border_below(const StepTask& task) const {
    const Vertex f = task.front, p = plan_.pivots(f);
    std::vector<double> border;
    for (Vertex j = task.k; j < std::min(task.k + lists_.tile, p); ++j) {
      for (Vertex i = p; i < rows(f); ++i) border.push_back(at(f, i, j));
    }
    return border;
  }

  void solve_strip(const StepTask& task, Vertex strip) {
    const Vertex f = task.front, k = task.k, next = std::min(k + lists_.tile, plan_.pivots(f));
    const Vertex length = rows(f) - next, strips = task.left ? (length + lists_.strip - 1) / lists_.strip : 0;
    if (strip < strips) {
      for (Vertex i = next + strip * lists_.strip; i < std::min(next + (strip + 1) * lists_.strip, rows(f));
           ++i) {
        for (Vertex j = k; j < next; ++j) {
          for (Vertex t = k; t < j; ++t, flops_.trsm += 2) at(f, i, j) -= at(f, i, t) * at(f, t, j);
          at(f, i, j) /= at(f, j, j);
          ++flops_.trsm;
        }
      }
      return;
    }
    const Vertex begin = task.begin + (strip - strips) * lists_.strip;
    EXPECT_LT(begin, task.end) << "a block without work";
    for (Vertex j = next + begin; j < next + std::min(begin + lists_.strip, task.end); ++j) {
      const Offset p = plan_.pivots(f);
      if (j >= p) {
        EXPECT_EQ(&storage_[task.upper + k + (j - p) * p], &at(f, k, j));
      }
      for (Vertex i = k; i < next; ++i) {
        for (Vertex t = k; t < i; ++t, flops_.trsm += 2) at(f, i, j) -= at(f, i, t) * at(f, t, j);
      }
    }
  }

  void subtract_product(const ProductTask& task, std::pair<Vertex, Vertex> down,
                        std::pair<Vertex, Vertex> right, const std::vector<double>& before) {
    for (Offset j = right.first; j < right.second; ++j) {
      for (Offset i = down.first; i < down.second; ++i) {
        double sum = before[task.c + i + j * task.ldc];
        for (Offset k = 0; k < task.k; ++k, flops_.gemm += 2)
          sum -= before[task.a + i + k * task.lda] * before[task.b + k + j * task.ldb];
        storage_[task.c + i + j * task.ldc] = sum;
      }
    }
  }

  double from_children(Vertex f, Vertex row, const std::vector<double>& border) const {
    double sum = 0;
    const Offset place = lists_.row_begin[f] + row;
    for (Offset s = lists_.source_begin[place]; s < lists_.source_begin[place + 1]; ++s) sum += border[s];
    return sum;
  }

  // What a launch has read may be written again, and what it leaves stays.
  static void forget_others(const Range& left, std::vector<double>& border) {
    std::fill(border.begin(), border.begin() + left.begin, kNothing);
    std::fill(border.begin() + left.end, border.end(), kNothing);
  }

  // The sum of factor times vector for row i of a tile over columns [begin, end) of the front: what a part
  // has to leave in its place, or to take from those of the parts before.
  template <class Value>
  void sum_columns(Vertex f, Vertex i, Vertex begin, Vertex end, const Value& value, double& sum) const {
    for (Vertex j = begin; j < end; ++j) sum += at(f, i, j) * value(j);
  }
  double sums_before(const SolvePart& part, Vertex i, const std::vector<double>& partial) const {
    double sum = 0;
    for (Vertex k = 0; k < part.parts; ++k) sum += partial[(part.place + k) * kSolveTile + i - part.begin];
    return sum;
  }
  static void leave(const SolvePart& part, Vertex i, double sum, std::vector<double>& partial) {
    double& to = partial[part.place * kSolveTile + i - part.begin];
    EXPECT_TRUE(std::isnan(to)) << "done twice";
    to = sum;
  }

  void forward(Vertex f, Vertex begin, Vertex end, const std::vector<double>& v, std::vector<double>& y,
               std::vector<double>& border) const {
    const Vertex p = plan_.pivots(f), first = plan_.pivot_begin[f];
    for (Vertex i = begin; i < end; ++i) {
      double sum = 0;
      sum_columns(
          f, i, 0, std::min(i, p), [&](Vertex k) { return y[first + k]; }, sum);
      double& to = i < p ? y[first + i] : border[lists_.destination[plan_.border_begin[f] + i - p]];
      EXPECT_TRUE(std::isnan(to)) << "done twice";
      to = from_children(f, i, border) + (i < p ? v[first + i] : 0) - sum;
    }
  }

  // Steps take what is right of the tile, last columns first: the border, then the pivot block.
  void backward(const SolvePart& part, Vertex end, const std::vector<double>& y, std::vector<double>& v,
                std::vector<double>& partial) const {
    constexpr Vertex kStep = kSolveTile;
    const Vertex f = part.front, p = plan_.pivots(f), first = plan_.pivot_begin[f];
    const Vertex of_border = (plan_.border_rows(f) + kStep - 1) / kStep;
    const Vertex steps = of_border + (p - end + kStep - 1) / kStep;
    const auto value = [&](Vertex j) {
      return v[j < p ? first + j : plan_.border[plan_.border_begin[f] + j - p]];
    };
    for (Vertex i = end - 1; i >= part.begin; --i) {
      double sum = 0;
      for (Vertex step = part.first_step; step < (part.finishes ? steps : part.last_step); ++step) {
        const Vertex begin =
            step < of_border ? p + (of_border - 1 - step) * kStep : end + (steps - 1 - step) * kStep;
        sum_columns(f, i, begin, std::min(begin + kStep, step < of_border ? rows(f) : p), value, sum);
      }
      if (!part.finishes) {
        leave(part, i, sum, partial);
        continue;
      }
      sum_columns(f, i, i + 1, end, value, sum);
      EXPECT_TRUE(std::isnan(v[first + i])) << "done twice";
      v[first + i] = (y[first + i] - sums_before(part, i, partial) - sum) / at(f, i, i);
    }
  }

  const StageProblem<double>& problem_;
  const SymbolicPlan& plan_;
  const DevicePlan& lists_;
  std::vector<double> storage_;
  std::function<const double*(Vertex)> block_at_;
  BlockFlops flops_{0, 0, 0};
  Concurrent concurrent_;
  std::map<Vertex, std::vector<double>> border_seen_;  // by the last tile of a front
  std::size_t waiting_tiles_;
  bool whole_fronts_ = false, early_ = false;
  std::set<std::tuple<Vertex, Vertex, Vertex>> assembled_;  // fronts, their columns and first rows
};

}  // namespace mfs::test
