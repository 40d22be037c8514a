// Runs single stages of an execution space on chosen input, and shows what they left. All memory that a stage
// is not given holds NaN, so that what it reads or leaves out by mistake is seen.
//
// StageBench<Exec, Scalar> is written for execution spaces that work in the memory of the host; one with a
// memory of its own joins by a specialization with the same members and a line in `Kinds`.
#pragma once

#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "kernels/dense/blas.hpp"
#include "kernels/stages/host_factors.hpp"
#include "test/stages/front_blocks.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {

/// What a stage is run with.
template <class Exec_, class Scalar_>
struct Kind {
  using Exec = Exec_;
  using Scalar = Scalar_;
  /// All sizes and thread counts are run in double precision; the other kinds of number share its code.
  static constexpr bool kThorough = std::is_same_v<Scalar, double>;
};
using Kinds =
    testing::Types<Kind<Kokkos::Serial, double>, Kind<Kokkos::OpenMP, double>, Kind<Kokkos::Serial, float>,
                   Kind<Kokkos::OpenMP, std::complex<double>>, Kind<Kokkos::OpenMP, std::complex<float>>>;

/// Thread counts worth running a space with.
template <class Tested>
std::vector<int> thread_counts() {
  if (!std::is_same_v<typename Tested::Exec, Kokkos::OpenMP>) return {1};
  return Tested::kThorough ? std::vector<int>{1, 2, 3} : std::vector<int>{2};
}

/// Which fronts of a depth take the path of the large ones.
enum class Path { small, large, mixed };

/// Groups of up to two small fronts; tiles for few threads and for many, by turns.
inline DepthSchedule forced_schedule(const SymbolicPlan& plan, Vertex step, Path path) {
  DepthSchedule schedule;
  for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
    const bool large = path == Path::large || (path == Path::mixed && f % 2 == 0);
    (large ? schedule.large : schedule.small).push_back(f);
  }
  const auto small = static_cast<Vertex>(schedule.small.size());
  for (Vertex k = 0; k < small; k += 2) schedule.group_begin.push_back(k);
  schedule.group_begin.push_back(small);
  schedule.share.assign(schedule.large.size(), step % 2 == 0 ? 1 : 16);
  return schedule;
}

template <class Exec, class Scalar>
class StageBench {
 public:
  explicit StageBench(const StageProblem<Scalar>& problem)
      : plan_(problem.plan),
        pattern_(problem.pattern),
        layout_(*plan_, sizeof(Scalar), sizeof(Scalar)),
        arena_(layout_.arena.total()),
        store_(make_front_store<Scalar, Scalar>(*plan_, *pattern_, layout_, arena_)) {
    std::fill_n(arena_.template at<double>(0), layout_.arena.total() / sizeof(double),
                std::numeric_limits<double>::quiet_NaN());  // as float: NaN and 0 by turns
    std::copy(problem.values.begin(), problem.values.end(), store_.matrix_values);
    std::copy(problem.row_scale.begin(), problem.row_scale.end(), store_.row_scale);
    std::copy(problem.column_scale.begin(), problem.column_scale.end(), store_.column_scale);
    *store_.status = FactorStatus();
  }

  void put_front(Vertex f, const FrontBlocks<Scalar>& blocks) {
    const Front<Scalar> front = store_.front(f);
    const Offset p = front.pivots, b = front.border;
    const auto put = [](const std::vector<Scalar>& from, Offset rows, Scalar* to, Offset ld) {
      for (std::size_t i = 0; i < from.size(); ++i)
        to[static_cast<Offset>(i) % rows + static_cast<Offset>(i) / rows * ld] = from[i];
    };
    put(blocks.lower, p + b, front.lower, front.lower_ld);
    put(blocks.upper, p, front.upper, p);
    put(blocks.contribution, b, front.contribution, front.contribution_ld);
  }
  /// A factored front, for the stage "solve".
  void put_factored(Vertex f, const ReferenceFront<Scalar>& front) {
    put_front(f, blocks_of(front));
    std::copy(front.row_at.begin(), front.row_at.end(), store_.local_row + plan_->pivot_begin[f]);
  }
  FrontBlocks<Scalar> front(Vertex f) const {
    return blocks_in(*plan_, static_cast<const Scalar*>(store_.storage), f);
  }
  std::vector<Vertex> row_at(Vertex f) const {
    return {store_.local_row + plan_->pivot_begin[f], store_.local_row + plan_->pivot_begin[f + 1]};
  }
  std::vector<Scalar> shift(Vertex f) const {
    return {store_.shift + plan_->pivot_begin[f], store_.shift + plan_->pivot_begin[f + 1]};
  }
  FactorStatus status() const { return *store_.status; }

  void factor_depth(const DepthSchedule& schedule, const PivotRule& rule, Stages stages) {
    StackPool none(0);
    factor_tree(exec_, workers_, none, store_, TreeSchedule{nullptr, &schedule, 1}, rule, stages,
                [](std::size_t) {});
    exec_.fence();
  }

  /// All depths, with subtrees or without.
  void factor_all(const TreeSchedule& tree, std::size_t stacks, const PivotRule& rule) {
    StackPool pool(stacks);
    factor_tree(exec_, workers_, pool, store_, tree, rule, Stages(), [](std::size_t) {});
    exec_.fence();
  }
  void solve_all(const TreeSchedule& tree, bool transposed) {
    solve_tree(exec_, workers_, store_, tree, vectors(), Substitution{true, true, transposed});
    exec_.fence();
  }

  /// Vectors of the stage "solve", n x columns by position, column-major: `v` goes in and comes out, `y` lies
  /// between forward and backward.
  void put_vectors(Vertex columns, const std::vector<Scalar>& v, const std::vector<Scalar>& y) {
    columns_ = columns;
    v_ = by_rows(v);
    y_ = y.empty() ? std::vector<Scalar>(v_.size(), Scalar(kNothing)) : by_rows(y);
    border_.assign(plan_->border.size() * width(), Scalar(kNothing));
  }
  std::vector<Scalar> v() const { return by_columns(v_); }
  std::vector<Scalar> y() const { return by_columns(y_); }

  void solve_depth(const DepthSchedule& schedule, bool forward, bool transposed) {
    solve_tree(exec_, workers_, store_, TreeSchedule{nullptr, &schedule, 1}, vectors(),
               Substitution{forward, !forward, transposed});
    exec_.fence();
  }

 private:
  std::size_t width() const { return static_cast<std::size_t>(rows::width_of(columns_)); }
  SolveVectors<Scalar> vectors() {
    return {static_cast<Vertex>(width()), v_.data(), y_.data(), border_.data()};
  }
  std::vector<Scalar> by_rows(const std::vector<Scalar>& columns) const {
    const std::size_t n = static_cast<std::size_t>(plan_->n);
    std::vector<Scalar> rows(n * width(), Scalar(kNothing));
    for (std::size_t k = 0; k < columns.size(); ++k) rows[k % n * width() + k / n] = columns[k];
    return rows;
  }
  std::vector<Scalar> by_columns(const std::vector<Scalar>& rows) const {
    const std::size_t n = static_cast<std::size_t>(plan_->n);
    std::vector<Scalar> columns(n * static_cast<std::size_t>(columns_));
    for (std::size_t k = 0; k < columns.size(); ++k) columns[k] = rows[k % n * width() + k / n];
    return columns;
  }

  static constexpr RealOf<Scalar> kNothing = std::numeric_limits<RealOf<Scalar>>::quiet_NaN();
  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  NumericLayout layout_;
  HostArena arena_;
  FrontStore<Scalar> store_;
  Vertex columns_ = 0;
  std::vector<Scalar> v_, y_, border_;
  Exec exec_;
  Workers workers_{Exec().concurrency(), 128};
  blas::SequentialScope sequential_;
};

}  // namespace mfs::test
