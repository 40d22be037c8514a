#include "plan/delay_pivots.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "ordering/fronts.hpp"

namespace mfs {

namespace {

/// Position -> front that its pivot goes to.
RawVector<Vertex> goals(const SymbolicPlan& plan, const std::vector<FailedPivot>& failed, Vertex levels,
                        int threads) {
  RawVector<Vertex> goal(static_cast<std::size_t>(plan.n));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex f = 0; f < plan.num_fronts; ++f)
    std::fill(goal.begin() + plan.pivot_begin[f], goal.begin() + plan.pivot_begin[f + 1], f);
  for (const FailedPivot& pivot : failed) {
    Vertex& front = goal[pivot.position];
    for (Vertex level = 0; level < levels && plan.parent[front] >= 0; ++level) front = plan.parent[front];
  }
  return goal;
}

/// A failed pivot takes along the row that came to it; the row that was its own stays, with the column that
/// has lost one. Others keep theirs: borders are of pairs, and grow where these change.
std::vector<Vertex> row_order(const SymbolicPlan& plan, const std::vector<FailedPivot>& failed, int threads) {
  RawVector<Vertex> row_at(plan.row_of.size()), position_of(row_at.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex p = 0; p < plan.n; ++p) {
    row_at[p] = plan.row_of[p];
    position_of[row_at[p]] = p;
  }
  for (const auto [position, row] : failed) {
    const Vertex place = position_of[row];
    std::swap(row_at[position], row_at[place]);
    std::swap(position_of[row_at[position]], position_of[row_at[place]]);
  }
  std::vector<Vertex> order(row_at.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex p = 0; p < plan.n; ++p) order[plan.column_of[p]] = row_at[p];
  return order;
}

/// Front -> failed positions that come to it from below.
std::vector<std::vector<Vertex>> arrivals(const SymbolicPlan& plan, const std::vector<FailedPivot>& failed,
                                          const RawVector<Vertex>& goal) {
  std::vector<std::vector<Vertex>> arrived(static_cast<std::size_t>(plan.num_fronts));
  for (const FailedPivot& pivot : failed) {
    const Vertex front = goal[pivot.position];
    if (pivot.position < plan.pivot_begin[front]) arrived[front].push_back(pivot.position);
  }
  return arrived;
}

/// Front -> its node. A front that has lost all of its pivots is none, and its parent's stands for it.
std::vector<Vertex> node_numbers(const SymbolicPlan& plan, const RawVector<Vertex>& goal) {
  std::vector<Vertex> node(static_cast<std::size_t>(plan.num_fronts), -1);
  for (const Vertex front : goal) node[front] = 0;
  Vertex count = 0;
  for (Vertex& number : node) {
    if (number == 0) number = count++;
  }
  for (Vertex f = plan.num_fronts - 1; f >= 0; --f) {
    if (node[f] < 0) node[f] = node[plan.parent[f]];
  }
  return node;
}

}  // namespace

bool can_move(const SymbolicPlan& plan, const std::vector<FailedPivot>& failed) {
  return std::any_of(failed.begin(), failed.end(), [&](const FailedPivot& pivot) {
    const auto next = std::upper_bound(plan.pivot_begin.begin(), plan.pivot_begin.end(), pivot.position);
    return plan.parent[next - plan.pivot_begin.begin() - 1] >= 0;
  });
}

DelayedTree delay_pivots(const SymbolicPlan& plan, const std::vector<FailedPivot>& failed, Vertex levels,
                         int threads) {
  const RawVector<Vertex> goal = goals(plan, failed, levels, threads);
  const std::vector<std::vector<Vertex>> arrived = arrivals(plan, failed, goal);
  const std::vector<Vertex> node = node_numbers(plan, goal);
  NodeList nodes;
  nodes.order.reserve(static_cast<std::size_t>(plan.n));
  nodes.node_begin.push_back(0);
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    for (Vertex p = plan.pivot_begin[f]; p < plan.pivot_begin[f + 1]; ++p) {
      if (goal[p] == f) nodes.order.push_back(plan.column_of[p]);
    }
    for (const Vertex p : arrived[f]) nodes.order.push_back(plan.column_of[p]);
    const auto end = static_cast<Vertex>(nodes.order.size());
    if (end == nodes.node_begin.back()) continue;
    nodes.node_begin.push_back(end);
    nodes.parent.push_back(plan.parent[f] < 0 ? -1 : node[plan.parent[f]]);
  }
  return {breadth_first(nodes), row_order(plan, failed, threads)};
}

}  // namespace mfs
