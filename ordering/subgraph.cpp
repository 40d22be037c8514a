#include "ordering/subgraph.hpp"

#include <camd.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "ordering/metis/vertex_separator.h"

namespace mfs {
namespace {

/// A separator must not hold more than this share of the sub-graph, nor a side.
constexpr double kLargestSeparator = 0.5;
constexpr double kLargestSide = 0.95;

/// The neighbours of sub-graph vertex v that lie outside of the sub-graph, appended to `outside`. Both lists
/// are ascending, so one walk along them finds the difference.
void append_outside(const Graph& graph, const std::vector<bool>& left_out, const SubGraph& sub, Vertex v,
                    std::vector<Vertex>& outside) {
  const Vertex global = sub.vertices[v];
  idx_t inside = sub.offsets[v];
  for (Offset k = graph.offsets[global]; k < graph.offsets[global + 1]; ++k) {
    const Vertex w = graph.neighbors[k];
    if (inside < sub.offsets[v + 1] && sub.vertices[sub.neighbors[inside]] == w) {
      ++inside;
    } else if (!left_out[w]) {
      outside.push_back(w);
    }
  }
}

/// The sub-graph and its boundary, as columns for CAMD: boundary vertices follow the inner ones.
struct WithBoundary {
  std::vector<int> offsets, rows, constraint;
};

WithBoundary with_boundary(const Graph& graph, const std::vector<bool>& left_out, const SubGraph& sub) {
  std::vector<Vertex> outside;
  for (Vertex v = 0; v < sub.size(); ++v) append_outside(graph, left_out, sub, v, outside);
  std::vector<Vertex> boundary = outside;
  std::sort(boundary.begin(), boundary.end());
  boundary.erase(std::unique(boundary.begin(), boundary.end()), boundary.end());

  WithBoundary result;
  const std::size_t count = sub.vertices.size() + boundary.size();
  result.offsets.reserve(count + 1);
  result.offsets.push_back(0);
  result.rows.reserve(sub.neighbors.size() + outside.size());
  for (Vertex v = 0; v < sub.size(); ++v) {
    result.rows.insert(result.rows.end(), sub.neighbors.begin() + sub.offsets[v],
                       sub.neighbors.begin() + sub.offsets[v + 1]);
    outside.clear();
    append_outside(graph, left_out, sub, v, outside);
    for (const Vertex w : outside) {
      const auto place = std::lower_bound(boundary.begin(), boundary.end(), w) - boundary.begin();
      result.rows.push_back(static_cast<int>(sub.size() + place));
    }
    result.offsets.push_back(static_cast<int>(result.rows.size()));
  }
  // CAMD adds the transpose itself: the boundary's own columns stay empty.
  result.offsets.resize(count + 1, result.offsets.back());
  result.constraint.assign(count, 1);
  std::fill_n(result.constraint.begin(), sub.size(), 0);
  return result;
}

std::size_t bytes(const SubGraph& sub) {
  return (sub.neighbors.size() + 3 * sub.vertices.size()) * sizeof(idx_t);
}

/// A tree that hangs from its first vertex.
struct RootedTree {
  RawVector<Vertex> top_down;  // parents before their children
  RawVector<Vertex> parent;    // -1: none
  RawVector<Offset> below;     // weight of a vertex and all that hang from it

  explicit RootedTree(const SubGraph& tree) {
    const std::size_t n = tree.vertices.size();
    top_down.reserve(n);
    parent.resize(n);
    below.assign(tree.weights.begin(), tree.weights.end());
    top_down.push_back(0);
    parent[0] = -1;
    for (std::size_t done = 0; done < top_down.size(); ++done) {
      const Vertex v = top_down[done];
      for (idx_t k = tree.offsets[v]; k < tree.offsets[v + 1]; ++k) {
        const Vertex w = tree.neighbors[k];
        if (w == parent[v]) continue;
        parent[w] = v;
        top_down.push_back(w);
      }
    }
    for (std::size_t done = n - 1; done > 0; --done) {
      const Vertex v = top_down[done];
      below[parent[v]] += below[v];
    }
  }

  /// The lowest vertex below which more than half of the weight hangs, itself included.
  Vertex centroid() const {
    Vertex found = 0;
    for (const Vertex v : top_down)
      if (2 * below[v] > below[0]) found = v;
    return found;
  }
};

}  // namespace

SubGraph whole_graph(const Graph& graph, const std::vector<bool>& left_out, int threads) {
  constexpr Offset limit = std::numeric_limits<idx_t>::max();
  if (graph.offsets[graph.n] > limit) {
    throw BackendError("METIS", METIS_ERROR_INPUT,
                       "the graph has more than " + std::to_string(limit) + " edges");
  }
  RawVector<Vertex> number(static_cast<std::size_t>(graph.n));
  SubGraph sub;
  sub.vertices.reserve(number.size());
  for (Vertex v = 0; v < graph.n; ++v) {
    number[v] = left_out[v] ? -1 : sub.size();
    if (!left_out[v]) sub.vertices.push_back(v);
  }
  const Vertex n = sub.size();
  sub.weights.resize(sub.vertices.size());
  sub.offsets.resize(sub.vertices.size() + 1);
  sub.offsets[0] = 0;
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < n; ++i) {
    const Vertex v = sub.vertices[i];
    const auto first = graph.neighbors.begin() + graph.offsets[v],
               last = graph.neighbors.begin() + graph.offsets[v + 1];
    sub.weights[i] = graph.weight[v];
    sub.offsets[i + 1] =
        static_cast<idx_t>(std::count_if(first, last, [&](Vertex w) { return number[w] >= 0; }));
  }
  std::partial_sum(sub.offsets.begin(), sub.offsets.end(), sub.offsets.begin());
  sub.weight = std::accumulate(sub.weights.begin(), sub.weights.end(), Offset(0));
  sub.neighbors.resize(static_cast<std::size_t>(sub.offsets[n]));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < n; ++i) {
    const Vertex v = sub.vertices[i];
    idx_t next = sub.offsets[i];
    for (Offset k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
      const Vertex w = number[graph.neighbors[k]];
      if (w >= 0) sub.neighbors[next++] = w;
    }
  }
  return sub;
}

std::vector<SubGraph> split(const SubGraph& sub, const RawVector<idx_t>& part_of, int parts) {
  struct Size {
    std::size_t vertices = 0, neighbors = 0;  // these at most
  };
  std::vector<Size> sizes(parts);
  RawVector<idx_t> number(sub.vertices.size());
  for (Vertex v = 0; v < sub.size(); ++v) {
    if (part_of[v] < 0) continue;
    Size& size = sizes[part_of[v]];
    number[v] = static_cast<idx_t>(size.vertices++);
    size.neighbors += static_cast<std::size_t>(sub.offsets[v + 1] - sub.offsets[v]);
  }
  std::vector<SubGraph> result(parts);
  for (int p = 0; p < parts; ++p) {
    result[p].vertices.reserve(sizes[p].vertices);
    result[p].weights.reserve(sizes[p].vertices);
    result[p].offsets.reserve(sizes[p].vertices + 1);
    result[p].offsets.push_back(0);
    result[p].neighbors.reserve(sizes[p].neighbors);
  }
  for (Vertex v = 0; v < sub.size(); ++v) {
    if (part_of[v] < 0) continue;
    SubGraph& part = result[part_of[v]];
    part.vertices.push_back(sub.vertices[v]);
    part.weights.push_back(sub.weights[v]);
    part.weight += sub.weights[v];
    for (idx_t k = sub.offsets[v]; k < sub.offsets[v + 1]; ++k) {
      const idx_t w = sub.neighbors[k];
      if (part_of[w] == part_of[v]) part.neighbors.push_back(number[w]);
    }
    part.offsets.push_back(static_cast<idx_t>(part.neighbors.size()));
  }
  return result;
}

Components find_components(const SubGraph& sub, Offset small, RawVector<idx_t>& part_of) {
  part_of.assign(sub.vertices.size(), -1);
  std::vector<Vertex> component;
  Components found;
  constexpr idx_t kSmall = std::numeric_limits<idx_t>::max();
  for (Vertex start = 0; start < sub.size(); ++start) {
    if (part_of[start] >= 0) continue;
    component.assign(1, start);
    part_of[start] = found.large;
    Offset weight = 0;
    for (std::size_t done = 0; done < component.size(); ++done) {
      const Vertex v = component[done];
      weight += sub.weights[v];
      for (idx_t k = sub.offsets[v]; k < sub.offsets[v + 1]; ++k) {
        const idx_t w = sub.neighbors[k];
        if (part_of[w] >= 0) continue;
        part_of[w] = found.large;
        component.push_back(w);
      }
    }
    if (weight > small) {
      ++found.large;
    } else {
      found.any_small = true;
      for (const Vertex v : component) part_of[v] = kSmall;
    }
  }
  if (found.any_small) std::replace(part_of.begin(), part_of.end(), kSmall, static_cast<idx_t>(found.large));
  return found;
}

Separator judged(const SubGraph& sub, RawVector<idx_t> part_of) {
  Separator found{std::move(part_of)};
  Offset weight[3] = {0, 0, 0};
  for (Vertex v = 0; v < sub.size(); ++v) weight[found.part_of[v]] += sub.weights[v];
  if (weight[0] == 0 || weight[1] == 0 || weight[2] > kLargestSeparator * sub.weight ||
      std::max(weight[0], weight[1]) > kLargestSide * sub.weight) {
    return found;
  }
  const double difference =
      static_cast<double>(weight[0] - weight[1]) / static_cast<double>(weight[0] + weight[1]);
  found.cost = static_cast<double>(weight[2]) * (1 + difference * difference);
  return found;
}

Separator find_separator(const SubGraph& sub, idx_t seed, idx_t refinement) {
  RawVector<idx_t> part_of(sub.vertices.size());
  const int status = mfs_metis_vertex_separator(sub.size(), sub.offsets.data(), sub.neighbors.data(),
                                                sub.weights.data(), seed, refinement, part_of.data());
  if (status == METIS_ERROR_MEMORY) throw OutOfMemory(MemorySpace::host, bytes(sub), 0);
  if (status != METIS_OK) throw BackendError("METIS", status, "vertex separator");
  return judged(sub, std::move(part_of));
}

bool is_tree(const SubGraph& connected) {
  return connected.neighbors.size() == 2 * (connected.vertices.size() - 1);
}

Separator tree_separator(const SubGraph& tree) {
  const RootedTree rooted(tree);
  const Vertex centroid = rooted.centroid();
  std::vector<std::pair<Offset, Vertex>> components;  // weight, neighbour of the centroid
  for (idx_t k = tree.offsets[centroid]; k < tree.offsets[centroid + 1]; ++k) {
    const Vertex w = tree.neighbors[k];
    const bool above = w == rooted.parent[centroid];
    components.emplace_back(above ? rooted.below[0] - rooted.below[centroid] : rooted.below[w], w);
  }
  std::sort(components.rbegin(), components.rend());

  RawVector<idx_t> part_of(tree.vertices.size());
  Offset side[2] = {0, 0};
  idx_t part_above = 2;
  for (const auto& [weight, w] : components) {
    const idx_t lighter = side[1] < side[0];
    side[lighter] += weight;
    if (w == rooted.parent[centroid])
      part_above = lighter;
    else
      part_of[w] = lighter;
  }
  for (const Vertex v : rooted.top_down) {
    const Vertex parent = rooted.parent[v];
    if (v == centroid)
      part_of[v] = 2;
    else if (parent != centroid)
      part_of[v] = parent < 0 ? part_above : part_of[parent];
  }
  return judged(tree, std::move(part_of));
}

std::vector<Vertex> minimum_degree(const Graph& graph, const std::vector<bool>& left_out,
                                   const SubGraph& sub) {
  std::vector<Vertex> order(sub.vertices.begin(), sub.vertices.end());
  if (sub.size() == 1) return order;
  WithBoundary input = with_boundary(graph, left_out, sub);
  if (input.rows.empty()) return order;  // single vertices, all of them
  const int count = static_cast<int>(input.constraint.size());
  std::vector<int> permutation(count);
  double control[CAMD_CONTROL], info[CAMD_INFO];
  camd_defaults(control);
  const int status = camd_order(count, input.offsets.data(), input.rows.data(), permutation.data(), control,
                                info, input.constraint.data());
  if (status == CAMD_OUT_OF_MEMORY) throw OutOfMemory(MemorySpace::host, bytes(sub), 0);
  if (status < CAMD_OK) throw BackendError("CAMD", status, "minimum degree");
  std::transform(permutation.begin(), permutation.begin() + sub.size(), order.begin(),
                 [&](int v) { return sub.vertices[v]; });
  return order;
}

}  // namespace mfs
