#include "ordering/nested_dissection.hpp"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "ordering/first_error.hpp"
#include "ordering/skeleton.hpp"
#include "ordering/subgraph.hpp"

namespace mfs {
namespace {

/// Sub-graphs below this many unknowns are done by the task that made them.
constexpr Offset kTaskWeight = 2000;
/// Sub-graphs with this share of all unknowns get the best of several separators (those of the first three
/// levels, where cuts are even): their fronts do most of the work, and they are too few to keep all threads
/// busy.
constexpr double kTriedShare = 1.0 / 6;
/// No row with fewer neighbours than this is called dense (as in AMD).
constexpr double kLeastDense = 16;

class Dissection {
 public:
  Dissection(const Graph& graph, const AnalysisOptions& options, const OrderingProgress& progress)
      : graph_(graph),
        options_(options),
        progress_(progress),
        unknowns_(std::accumulate(graph.weight.begin(), graph.weight.end(), Offset(0))),
        levels_(1 + static_cast<int>(std::log2(1 + static_cast<double>(unknowns_) / options_.leaf_size))),
        dense_(graph.n, false),
        order_(graph.n) {}

  void prepare(int threads) {
    order_dense_last(threads);
    rest_ = whole_graph(graph_, dense_, threads);
  }
  /// In a task.
  void run() {
    if (rest_.size() > 0) error_.attempt([&] { dissect(std::move(rest_), 0, 0); });
  }
  std::vector<Vertex> order() {
    error_.rethrow();
    return std::move(order_);
  }

  std::vector<Vertex> run_by_degree() {
    order_dense_last(1);
    const SubGraph rest = whole_graph(graph_, dense_, 1);
    if (rest.size() > 0) order_leaf(rest, 0, 0);
    return std::move(order_);
  }

 private:
  /// The dense vertices take the last positions, the densest the very last.
  void order_dense_last(int threads) {
    const double limit =
        std::max(kLeastDense, options_.dense_row * std::sqrt(static_cast<double>(unknowns_)));
    RawVector<Offset> degree(static_cast<std::size_t>(graph_.n));
#pragma omp parallel for num_threads(threads) schedule(static)
    for (Vertex v = 0; v < graph_.n; ++v) {
      degree[v] = graph_.weight[v] - 1;
      for (Offset k = graph_.offsets[v]; k < graph_.offsets[v + 1]; ++k)
        degree[v] += graph_.weight[graph_.neighbors[k]];
    }
    std::vector<std::pair<Offset, Vertex>> dense;
    for (Vertex v = 0; v < graph_.n; ++v) {
      if (static_cast<double>(degree[v]) <= limit) continue;
      dense.emplace_back(degree[v], v);
      dense_[v] = true;
    }
    std::sort(dense.begin(), dense.end());
    std::transform(dense.begin(), dense.end(), order_.end() - static_cast<std::ptrdiff_t>(dense.size()),
                   [](const auto& d) { return d.second; });
  }

  /// Orders `sub` into the positions from `begin` on.
  void dissect(SubGraph sub, Vertex begin, int level) {
    if (sub.weight <= options_.leaf_size) {
      order_leaf(sub, begin, level);
      return;
    }
    RawVector<idx_t> part_of;
    const Components components = find_components(sub, options_.leaf_size, part_of);
    if (components.large + components.any_small > 1) {
      std::vector<SubGraph> parts = split(sub, part_of, components.large + components.any_small);
      sub = SubGraph();
      if (components.any_small) {
        begin = order_leaf(parts.back(), begin, level);
        parts.pop_back();
      }
      return dissect_parts(std::move(parts), begin, level);
    }
    Separator separator;
    if (!components.any_small) separator = separator_of(sub);
    if (!std::isfinite(separator.cost)) {
      order_leaf(sub, begin, level);
      return;
    }
    place_separator(sub, begin, separator.part_of);
    std::vector<SubGraph> sides = split(sub, separator.part_of, 2);
    advance(static_cast<double>(sub.weight));
    sub = SubGraph();
    dissect_parts(std::move(sides), begin, level + 1);
  }

  Separator separator_of(const SubGraph& connected) {
    Separator centroid;
    if (is_tree(connected)) centroid = tree_separator(connected);
    return std::isfinite(centroid.cost) ? std::move(centroid) : best_separator(connected);
  }

  /// Of trials that differ by their seed the cheapest, of equal ones the first. The last is the one that
  /// finds the least cost again, as in regular meshes, whatever threads have tried beside it.
  Separator best_separator(const SubGraph& sub) {
    const bool large = static_cast<double>(sub.weight) >= kTriedShare * static_cast<double>(unknowns_);
    const int most = large ? options_.separator_trials : 1, at_once = omp_get_num_threads();
    const Skeleton skeleton = make_skeleton(sub);
    std::vector<Separator> found;
    auto last = found.end();
    while (last == found.end() && static_cast<int>(found.size()) < most) {
      add_trials(sub, skeleton, std::min(at_once, most - static_cast<int>(found.size())), found);
      last = least_again(found);
    }
    return std::move(*std::min_element(found.begin(), last, cheaper));
  }
  static bool cheaper(const Separator& a, const Separator& b) {
    return a.cost < b.cost;
  }

  /// The first that is the cheapest of those before it once more.
  static std::vector<Separator>::iterator least_again(std::vector<Separator>& found) {
    auto least = found.begin();
    for (auto trial = found.begin() + 1; trial != found.end(); ++trial) {
      if (is_same(*least, *trial)) return trial;
      if (cheaper(*trial, *least)) least = trial;
    }
    return found.end();
  }
  static bool is_same(const Separator& a, const Separator& b) {
    const auto both = [](idx_t x, idx_t y) { return (x == 2) == (y == 2); };
    return a.cost == b.cost && std::isfinite(a.cost) &&
           std::equal(a.part_of.begin(), a.part_of.end(), b.part_of.begin(), both);
  }

  void add_trials(const SubGraph& sub, const Skeleton& skeleton, int trials,
                  std::vector<Separator>& found) const {
    const auto seed = static_cast<std::uint32_t>(options_.seed) +  // may wrap around
                      static_cast<std::uint32_t>(found.size());
    const auto before = found.size();
    found.resize(before + trials);
    FirstError error;
#pragma omp taskgroup
    for (int trial = 0; trial < trials; ++trial) {
#pragma omp task default(shared) firstprivate(trial) if (trials > 1)
      error.attempt(
          [&] { found[before + trial] = separator_from(sub, skeleton, static_cast<idx_t>(seed + trial)); });
    }
    error.rethrow();
  }

  Separator separator_from(const SubGraph& sub, const Skeleton& skeleton, idx_t seed) const {
    if (!skeleton.empty()) {
      const Separator kept = find_separator(skeleton.graph, seed, options_.separator_refinement);
      Separator whole = judged(sub, whole_part_of(sub, skeleton, kept.part_of));
      if (std::isfinite(whole.cost)) return whole;
    }
    return find_separator(sub, seed, options_.separator_refinement);
  }

  /// The separator (part 2) takes the last positions of its sub-graph and leaves it.
  void place_separator(const SubGraph& sub, Vertex begin, RawVector<idx_t>& part_of) {
    Vertex next = begin + sub.size();
    for (Vertex v = sub.size() - 1; v >= 0; --v) {
      if (part_of[v] != 2) continue;
      order_[--next] = sub.vertices[v];
      part_of[v] = -1;
    }
  }

  void dissect_parts(std::vector<SubGraph> parts, Vertex begin, int level) {
    for (SubGraph& part : parts) {
      const Vertex part_begin = begin;
      begin += part.size();
      if (part.weight <= kTaskWeight) {
        dissect(std::move(part), part_begin, level);
        continue;
      }
      auto* owned = new SubGraph(std::move(part));
#pragma omp task firstprivate(owned, part_begin, level)
      {
        const std::unique_ptr<SubGraph> guard(owned);
        error_.attempt([&] { dissect(std::move(*guard), part_begin, level); });
      }
    }
  }

  /// Returns the position behind the leaf.
  Vertex order_leaf(const SubGraph& sub, Vertex begin, int level) {
    const std::vector<Vertex> inner = minimum_degree(graph_, dense_, sub);
    std::copy(inner.begin(), inner.end(), order_.begin() + begin);
    advance(static_cast<double>(sub.weight) * std::max(levels_ - level, 1));
    return begin + sub.size();
  }

  /// Counts work in unknowns per level of the dissection; the thread that called tells the caller.
  void advance(double work) {
    double done = work_done_.load();
    while (!work_done_.compare_exchange_weak(done, done + work)) {
    }
    if (progress_ && omp_get_thread_num() == 0) {
      progress_(std::min(1.0, (done + work) / (static_cast<double>(unknowns_) * levels_)));
    }
  }

  const Graph& graph_;
  const AnalysisOptions& options_;
  const OrderingProgress& progress_;
  const Offset unknowns_;
  const int levels_;         // expected
  std::vector<bool> dense_;  // taken out, ordered last
  SubGraph rest_;
  std::vector<Vertex> order_;
  std::atomic<double> work_done_{0};
  FirstError error_;
};

}  // namespace

std::vector<std::vector<Vertex>> nested_dissections(const std::vector<const Graph*>& graphs,
                                                    const AnalysisOptions& options, int threads,
                                                    const OrderingProgress& progress) {
  const OrderingProgress nobody;
  std::vector<std::unique_ptr<Dissection>> dissections;
  for (const Graph* const graph : graphs) {
    dissections.push_back(
        std::make_unique<Dissection>(*graph, options, dissections.empty() ? progress : nobody));
    dissections.back()->prepare(threads);
  }
#pragma omp parallel num_threads(threads)
#pragma omp masked
  for (const auto& dissection : dissections) {
    Dissection* const one = dissection.get();
#pragma omp task firstprivate(one) if (dissections.size() > 1)
    one->run();
  }
  std::vector<std::vector<Vertex>> orders;
  for (const auto& dissection : dissections) orders.push_back(dissection->order());
  return orders;
}

std::vector<Vertex> minimum_degree_order(const Graph& graph, const AnalysisOptions& options) {
  const OrderingProgress nobody;
  return Dissection(graph, options, nobody).run_by_degree();
}

}  // namespace mfs
