#include "plan/merge_fronts.hpp"

#include <cstddef>

#include "ordering/fronts.hpp"

namespace mfs {

namespace {

/// The front that each front ends up in; fronts are numbered with children before parents.
std::vector<Vertex> survivors(const SymbolicPlan& plan, const std::vector<char>& failed) {
  std::vector<Vertex> into(static_cast<std::size_t>(plan.num_fronts));
  for (Vertex f = plan.num_fronts - 1; f >= 0; --f) {
    into[f] = failed[f] && plan.parent[f] >= 0 ? into[plan.parent[f]] : f;
  }
  return into;
}

}  // namespace

SeparatorTree merge_into_parents(const SymbolicPlan& plan, const std::vector<char>& failed) {
  const std::vector<Vertex> into = survivors(plan, failed);
  std::vector<Vertex> node_of(static_cast<std::size_t>(plan.num_fronts), -1);
  NodeList nodes;
  Vertex count = 0;
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    if (into[f] == f) node_of[f] = count++;
  }
  std::vector<Vertex> size(static_cast<std::size_t>(count), 0);
  for (Vertex f = 0; f < plan.num_fronts; ++f) size[node_of[into[f]]] += plan.pivots(f);
  nodes.node_begin.assign(1, 0);
  for (const Vertex pivots : size) nodes.node_begin.push_back(nodes.node_begin.back() + pivots);
  nodes.order.resize(static_cast<std::size_t>(plan.n));
  std::vector<Vertex> next(nodes.node_begin.begin(), nodes.node_begin.end() - 1);
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    Vertex& place = next[node_of[into[f]]];
    for (Vertex p = plan.pivot_begin[f]; p < plan.pivot_begin[f + 1]; ++p)
      nodes.order[place++] = plan.column_of[p];
    if (into[f] == f) {
      nodes.parent.push_back(plan.parent[f] < 0 ? -1 : node_of[into[plan.parent[f]]]);
    }
  }
  return breadth_first(nodes);
}

}  // namespace mfs
