// Runs whole factorizations and substitutions on the device as CudaFactors does, and shows everything
// that they left. Memory that the device must write itself holds NaN before.
#pragma once

#include <memory>
#include <vector>

#include "kernels/cuda/device_stages.hpp"
#include "kernels/cuda/runtime/device.hpp"
#include "test/stages/factored_fronts.hpp"
#include "test/stages/inverted_blocks.hpp"

namespace mfs::test {

/// How the stages get to the device.
enum class Launches { direct, recorded };

/// Of a solve, n x columns by position: between forward and backward, and at the end.
template <class Scalar>
struct Substitution {
  std::vector<Scalar> y, x;
};

template <class Scalar>
class DeviceBench {
 public:
  using S = cuda::DeviceScalar<Scalar>;

  /// The library has roots of `least_root` pivots and more.
  explicit DeviceBench(const StageProblem<Scalar>& problem, Vertex least_root = kNoRoots)
      : plan_(problem.plan), pattern_(problem.pattern), stages_(*plan_, *pattern_, stream_, least_root) {
    put_problem(problem);
  }
  /// Panels of tall strict fronts have at most so many entries in shared memory.
  static DeviceBench with_panels(const StageProblem<Scalar>& problem, Vertex entries) {
    DevicePlan lists = cuda::DeviceStages<S, S>::lists_for(*problem.plan);
    lists.panel_entries = std::min(lists.panel_entries, entries);
    return DeviceBench(problem, std::move(lists));
  }
  void put_values(const std::vector<Scalar>& values) { put(stages_.matrix_values(), values); }

  /// Factors until no front becomes strict and no root needs pivots, as often as passes() then says.
  FactorStatus factor(const PivotPolicy& policy, Launches launches = Launches::direct) {
    const auto& at = stages_.store().fronts;
    stream_.fill(at.storage, kNan, plan_->storage_entries * size_of<S>());
    stream_.fill(at.local_row, kNan, plan_->n * size_of<Vertex>());
    stream_.fill(at.shift, kNan, plan_->n * size_of<S>());
    for (passes_ = 0;;) {
      const auto launch = [&] { stages_.factor(policy, search_); };
      if (launches == Launches::recorded) {
        graph_.record(stream_, launch);
        graph_.launch(stream_);
      } else {
        launch();
      }
      ++passes_;
      const cuda::DeviceStatus status = get(stages_.status(), 1)[0];
      if (passes_ > plan_->num_fronts + 1 || (status.found_strict == 0 && status.pivots_needed == 0))
        return status_ = status.pivots;
      if (status.found_strict > 0) stages_.make_ancestors_strict();
      search_ = status.found_strict > 0 ? cuda::PivotSearch::strict_by_panels : cuda::PivotSearch::tiles;
    }
  }
  int passes() const { return passes_; }
  /// From the next factorization on.
  void make_all_strict(cuda::PivotSearch search) {
    put(stages_.store().strict,
        std::vector<int>(static_cast<std::size_t>(plan_->num_fronts), kStrict | kNeedsStrict));
    search_ = search;
  }
  /// How many times its size the diagonal counted for when pivots were searched.
  double preference() const { return stages_.store().pivots.preference; }
  Vertex tile() const { return stages_.lists().tile; }
  Vertex small_rows() const { return stages_.lists().small_rows; }

  /// The factors with their diagonal blocks as an LU has them.
  FactoredFronts<Scalar> factored() const {
    FactoredFronts<Scalar> result = as_left();
    for (Vertex f = 0; f < plan_->num_fronts; ++f) {
      const Vertex p = plan_->pivots(f);
      invert_diagonal(result.fronts[f].lower, p, p + plan_->border_rows(f), kSolveTile,
                      stages_.store().substitutes);
    }
    return result;
  }
  /// As they lie in the memory of the device; contribution blocks hold what is left of them.
  FactoredFronts<Scalar> as_left() const {
    const auto& at = stages_.store().fronts;
    const auto storage = get_as<Scalar>(at.storage, plan_->storage_entries);
    const auto local_row = get_as<Vertex>(at.local_row, plan_->n);
    const auto shift = get_as<Scalar>(at.shift, plan_->n);
    const auto part = [](const auto& from, Offset begin, Offset count) {
      return std::decay_t<decltype(from)>(from.begin() + begin, from.begin() + begin + count);
    };
    FactoredFronts<Scalar> result;
    for (Vertex f = 0; f < plan_->num_fronts; ++f) {
      const Offset p = plan_->pivots(f);
      result.fronts.push_back(blocks_in(*plan_, storage.data(), f));
      result.row_at.push_back(part(local_row, plan_->pivot_begin[f], p));
      result.shift.push_back(part(shift, plan_->pivot_begin[f], p));
    }
    result.status = status_;
    return result;
  }
  /// Whether the last factorization had the library's roots.
  bool library_roots() const {
    return search_ == cuda::PivotSearch::not_in_roots && stages_.has_library_roots();
  }
  /// By front: whether it is.
  std::vector<int> strict() const {
    std::vector<int> states = get_as<int>(stages_.store().strict, plan_->num_fronts);
    for (int& state : states) state &= kStrict;
    return states;
  }

  /// v: n x columns by position.
  Substitution<Scalar> solve(Vertex columns, const std::vector<Scalar>& v, bool transposed,
                             Launches launches = Launches::direct) {
    Substitution<Scalar> all;
    const std::size_t n = static_cast<std::size_t>(plan_->n);
    const Vertex together = stages_.most_columns();
    for (Vertex first = 0; first < columns; first += together) {
      const std::vector<Scalar> block(v.begin() + first * n,
                                      v.begin() + std::min(first + together, columns) * n);
      const Substitution<Scalar> part = solve_block(block, transposed, launches);
      all.y.insert(all.y.end(), part.y.begin(), part.y.end());
      all.x.insert(all.x.end(), part.x.begin(), part.x.end());
    }
    return all;
  }

 private:
  static constexpr int kNan = 0xff;

  DeviceBench(const StageProblem<Scalar>& problem, DevicePlan lists)
      : plan_(problem.plan),
        pattern_(problem.pattern),
        stages_(*plan_, *pattern_, stream_, std::move(lists)) {
    put_problem(problem);
  }
  void put_problem(const StageProblem<Scalar>& problem) {
    put_values(problem.values);
    put(stages_.row_scale(), problem.row_scale);
    put(stages_.column_scale(), problem.column_scale);
  }

  // Columns side by side, zeros beyond those that are given, and back.
  Substitution<Scalar> solve_block(const std::vector<Scalar>& v, bool transposed, Launches launches) {
    const Offset n = plan_->n, columns = static_cast<Offset>(v.size()) / n;
    const Offset width = cuda::solve_width(static_cast<Vertex>(columns));
    const Offset block = n * width, border = stages_.border_rows(stages_.lists()) * width;
    std::vector<Scalar> beside(static_cast<std::size_t>(block));
    for (Offset i = 0; i < n; ++i) {
      for (Offset c = 0; c < columns; ++c) beside[i * width + c] = v[i + c * n];
    }
    ArenaLayout layout;
    const Offset v_at = layout.add(block * size_of<S>()), y_at = layout.add(block * size_of<S>()),
                 border_at = layout.add(border * size_of<S>()),
                 partial_at = layout.add(stages_.partial_rows(stages_.lists()) * width * size_of<S>());
    const cuda::DeviceArena arena(layout.total());
    const typename cuda::DeviceStages<S, S>::Vectors vectors{arena.at<S>(v_at), arena.at<S>(y_at),
                                                             arena.at<S>(border_at), arena.at<S>(partial_at)};
    const auto launch = [&] { stages_.substitute(vectors, static_cast<Vertex>(width), transposed); };
    put(vectors.v, beside);
    stream_.fill(vectors.border, kNan, border * size_of<S>());
    if (launches == Launches::recorded) {
      cuda::Graph graph;
      graph.record(stream_, launch);
      graph.launch(stream_);
      stream_.synchronize();
    } else {
      launch();
    }
    const auto columns_of = [&](const S* from) {
      const std::vector<Scalar> found = get_as<Scalar>(from, block);
      std::vector<Scalar> to(v.size());
      for (Offset i = 0; i < n; ++i) {
        for (Offset c = 0; c < columns; ++c) to[i + c * n] = found[i * width + c];
      }
      return to;
    };
    return {columns_of(vectors.y), columns_of(vectors.v)};
  }
  template <class T>
  static constexpr Offset size_of() {
    return static_cast<Offset>(sizeof(T));
  }
  template <class T, class From>
  void put(T* to, const std::vector<From>& from) const {
    static_assert(sizeof(T) == sizeof(From));
    stream_.to_device(to, from.data(), static_cast<Offset>(from.size()) * size_of<T>());
    stream_.synchronize();
  }
  template <class To, class T>
  std::vector<To> get_as(const T* from, Offset count) const {
    static_assert(sizeof(T) == sizeof(To));
    std::vector<To> to(static_cast<std::size_t>(count));
    stream_.to_host(to.data(), from, count * size_of<T>());
    stream_.synchronize();
    return to;
  }
  template <class T>
  std::vector<T> get(const T* from, Offset count) const {
    return get_as<T>(from, count);
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  cuda::Stream stream_;
  cuda::DeviceStages<S, S> stages_;
  cuda::Graph graph_;
  int passes_ = 0;
  cuda::PivotSearch search_ = cuda::PivotSearch::not_in_roots;
  FactorStatus status_{};
};

}  // namespace mfs::test
