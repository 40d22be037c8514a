// Runs single stages or whole factorizations of the portable executor in one execution space, and shows what
// they left. Memory that a stage is not given holds NaN. Fronts go in and come out as a reference has them,
// also where the executor's own dense operations leave the triangles of diagonal blocks inverted.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "kernels/portable/stages.hpp"
#include "test/stages/factored_fronts.hpp"
#include "test/stages/inverted_blocks.hpp"

namespace mfs::test {

template <class Exec, class Scalar, class Dense>
class PortableBench {
 public:
  using S = DeviceScalar<Scalar>;
  using Stages = portable::PortableStages<Exec, S, S, Dense>;

  PortableBench(const StageProblem<Scalar>& problem, const portable::Sizes& sizes)
      : plan_(problem.plan),
        pattern_(problem.pattern),
        stages_(*plan_, *pattern_, portable::make_lists(*plan_, sizes)) {
    stages_.allocate();
    put_values(problem.values);
    const auto& at = stages_.store().fronts;
    put(at.row_scale, problem.row_scale);
    put(at.column_scale, problem.column_scale);
    forget();
  }
  void put_values(const std::vector<Scalar>& values) { put(stages_.store().fronts.matrix_values, values); }

  /// Everything that a factorization makes becomes NaN.
  void forget() {
    const auto& at = stages_.store().fronts;
    const auto& queue = stages_.queue();
    queue.fill(at.storage, kNan, plan_->storage_entries * size_of<S>());
    queue.fill(at.local_row, kNan, plan_->n * size_of<Vertex>());
    queue.fill(at.interchange, kNan, plan_->n * size_of<Vertex>());
    queue.fill(at.shift, kNan, plan_->n * size_of<S>());
    queue.fill(at.work, kNan, plan_->n * size_of<S>());
    queue.wait();
  }

  // Single stages.
  void begin() { stages_.begin(policy_); }
  /// U is substituted with from now on.
  void substitute() {
    policy_ = {0, TinyPivots::data, 0};
    begin();
  }
  void factor_depth(Vertex step, const portable::Stages& stages) {
    stages_.factor_depth(step, stages);
    stages_.queue().wait();
  }
  /// Pivots are searched in all rows of all fronts.
  void make_all_strict() {
    put(stages_.store().strict,
        std::vector<int>(static_cast<std::size_t>(plan_->num_fronts), kStrict | kNeedsStrict));
  }
  void put_front(Vertex f, const FrontBlocks<Scalar>& blocks) {
    std::vector<Scalar> storage = get<Scalar>(stages_.store().fronts.storage, plan_->storage_entries);
    const Offset p = plan_->pivots(f), b = plan_->border_rows(f);
    const auto put_block = [&](const std::vector<Scalar>& from, Offset rows, Offset begin, Offset ld) {
      for (std::size_t i = 0; i < from.size(); ++i)
        storage[static_cast<std::size_t>(begin + static_cast<Offset>(i) % rows +
                                         static_cast<Offset>(i) / rows * ld)] = from[i];
    };
    put_block(blocks.lower, p + b, plan_->lower_begin[f], plan_->lower_ld(f));
    put_block(blocks.upper, p, plan_->upper_begin[f], p);
    put_block(blocks.contribution, b, plan_->contribution_begin[f], plan_->contribution_ld(f));
    put(stages_.store().fronts.storage, storage);
  }
  void put_factored(Vertex f, const ReferenceFront<Scalar>& front) {
    put_front(f, as_kept(blocks_of(front), f));
    std::vector<Vertex> rows = get<Vertex>(stages_.store().fronts.local_row, plan_->n);
    std::copy(front.row_at.begin(), front.row_at.end(), rows.begin() + plan_->pivot_begin[f]);
    put(stages_.store().fronts.local_row, rows);
  }
  /// As it lies there: factored ones have inverted blocks.
  FrontBlocks<Scalar> front(Vertex f) const {
    const std::vector<Scalar> storage = get<Scalar>(stages_.store().fronts.storage, plan_->storage_entries);
    return blocks_in(*plan_, storage.data(), f);
  }
  /// Factored blocks as the executor keeps them, and back.
  FrontBlocks<Scalar> as_kept(FrontBlocks<Scalar> blocks, Vertex f) const {
    if (!Dense::kSearchesAll)
      invert_diagonal(blocks.lower, plan_->pivots(f), plan_->rows(f), portable::kInvertedBlock,
                      policy_.substitutes());
    return blocks;
  }
  std::vector<Vertex> row_at(Vertex f) const {
    return part(get<Vertex>(stages_.store().fronts.local_row, plan_->n), f);
  }
  std::vector<Scalar> shift(Vertex f) const {
    return part(get<Scalar>(stages_.store().fronts.shift, plan_->n), f);
  }
  portable::Status status() const { return get<portable::Status>(stages_.store().status, 1)[0]; }
  /// By front: whether it is.
  std::vector<int> strict() const {
    std::vector<int> states = get<int>(stages_.store().strict, plan_->num_fronts);
    for (int& state : states) state &= kStrict;
    return states;
  }

  /// Factors until no front becomes strict, as often as passes() then says.
  FactoredFronts<Scalar> factor(double tolerance) {
    for (passes_ = 1;; ++passes_) {
      forget();
      stages_.factor(tolerance, [](Vertex) {});
      if (passes_ > plan_->num_fronts + 1 || status().found_strict == 0) break;
    }
    FactoredFronts<Scalar> result;
    const std::vector<Scalar> storage = get<Scalar>(stages_.store().fronts.storage, plan_->storage_entries);
    for (Vertex f = 0; f < plan_->num_fronts; ++f) {
      result.fronts.push_back(as_kept(blocks_in(*plan_, storage.data(), f), f));
      result.row_at.push_back(row_at(f));
      result.shift.push_back(shift(f));
    }
    result.status = status().pivots;
    return result;
  }
  int passes() const { return passes_; }

  /// Of a solve, n x columns by position: y between forward and backward, and x.
  struct Solution {
    std::vector<Scalar> y, x;
  };
  Solution solve(Vertex columns, const std::vector<Scalar>& v, bool transposed) {
    const Offset entries = static_cast<Offset>(plan_->n) * columns;
    ArenaLayout layout;
    const Offset v_at = layout.add(entries * size_of<S>()), y_at = layout.add(entries * size_of<S>()),
                 border_at = layout.add(stages_.border_places() * columns * size_of<S>());
    const typename Space<Exec>::Arena arena(layout.total());
    const portable::Vectors<S> vectors{columns, arena.template at<S>(v_at), arena.template at<S>(y_at),
                                       arena.template at<S>(border_at)};
    stages_.queue().fill(arena.template at<char>(0), kNan, layout.total());
    put(vectors.v, v);
    for (Vertex step = 0; step < plan_->num_depths; ++step)
      stages_.solve_depth(step, vectors, true, transposed);
    Solution solution;
    solution.y = get<Scalar>(vectors.y, entries);
    stages_.queue().fill(vectors.v, kNan, entries * size_of<S>());
    for (Vertex step = plan_->num_depths - 1; step >= 0; --step)
      stages_.solve_depth(step, vectors, false, transposed);
    solution.x = get<Scalar>(vectors.v, entries);
    return solution;
  }

 private:
  static constexpr int kNan = 0xff;
  template <class T>
  static constexpr Offset size_of() {
    return static_cast<Offset>(sizeof(T));
  }
  template <class T>
  std::vector<T> part(const std::vector<T>& all, Vertex f) const {
    return {all.begin() + plan_->pivot_begin[f], all.begin() + plan_->pivot_begin[f + 1]};
  }
  template <class T, class From>
  void put(T* to, const std::vector<From>& from) const {
    static_assert(sizeof(T) == sizeof(From));
    stages_.queue().to_space(to, from.data(), static_cast<Offset>(from.size()) * size_of<T>());
    stages_.queue().wait();
  }
  template <class To, class T>
  std::vector<To> get(const T* from, Offset count) const {
    static_assert(sizeof(T) == sizeof(To));
    std::vector<To> to(static_cast<std::size_t>(count));
    stages_.queue().to_host(to.data(), from, count * size_of<T>());
    stages_.queue().wait();
    return to;
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  Stages stages_;
  PivotPolicy policy_{0};  // of single stages
  int passes_ = 0;
};

}  // namespace mfs::test
