#include "ordering/subgraph.hpp"

#include <camd.h>

#include <algorithm>
#include <limits>
#include <string>

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

}  // namespace

SubGraph whole_graph(const Graph& graph, const std::vector<bool>& left_out) {
  constexpr Offset limit = std::numeric_limits<idx_t>::max();
  if (graph.offsets[graph.n] > limit) {
    throw BackendError("METIS", METIS_ERROR_INPUT,
                       "the graph has more than " + std::to_string(limit) + " edges");
  }
  std::vector<Vertex> number(graph.n, -1);
  SubGraph sub;
  for (Vertex v = 0; v < graph.n; ++v) {
    if (left_out[v]) continue;
    number[v] = sub.size();
    sub.vertices.push_back(v);
    sub.weights.push_back(graph.weight[v]);
    sub.weight += graph.weight[v];
  }
  sub.offsets.reserve(sub.vertices.size() + 1);
  sub.offsets.push_back(0);
  sub.neighbors.reserve(graph.neighbors.size());
  for (const Vertex v : sub.vertices) {
    for (Offset k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
      const Vertex w = number[graph.neighbors[k]];
      if (w >= 0) sub.neighbors.push_back(w);
    }
    sub.offsets.push_back(static_cast<idx_t>(sub.neighbors.size()));
  }
  return sub;
}

std::vector<SubGraph> split(const SubGraph& sub, const std::vector<idx_t>& part_of, int parts) {
  std::vector<SubGraph> result(parts);
  std::vector<idx_t> number(sub.vertices.size());
  for (Vertex v = 0; v < sub.size(); ++v) {
    if (part_of[v] < 0) continue;
    SubGraph& part = result[part_of[v]];
    number[v] = part.size();
    part.vertices.push_back(sub.vertices[v]);
    part.weights.push_back(sub.weights[v]);
    part.weight += sub.weights[v];
  }
  for (SubGraph& part : result) {
    part.offsets.reserve(part.vertices.size() + 1);
    part.offsets.push_back(0);
  }
  for (Vertex v = 0; v < sub.size(); ++v) {
    if (part_of[v] < 0) continue;
    SubGraph& part = result[part_of[v]];
    for (idx_t k = sub.offsets[v]; k < sub.offsets[v + 1]; ++k) {
      const idx_t w = sub.neighbors[k];
      if (part_of[w] == part_of[v]) part.neighbors.push_back(number[w]);
    }
    part.offsets.push_back(static_cast<idx_t>(part.neighbors.size()));
  }
  return result;
}

Components find_components(const SubGraph& sub, Offset small, std::vector<idx_t>& part_of) {
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

Separator find_separator(const SubGraph& sub, idx_t seed, idx_t refinement) {
  Separator found;
  found.part_of.resize(sub.vertices.size());
  const int status = mfs_metis_vertex_separator(sub.size(), sub.offsets.data(), sub.neighbors.data(),
                                                sub.weights.data(), seed, refinement, found.part_of.data());
  if (status == METIS_ERROR_MEMORY) throw OutOfMemory(MemorySpace::host, bytes(sub), 0);
  if (status != METIS_OK) throw BackendError("METIS", status, "vertex separator");
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

std::vector<Vertex> minimum_degree(const Graph& graph, const std::vector<bool>& left_out,
                                   const SubGraph& sub) {
  if (sub.size() == 1) return sub.vertices;
  WithBoundary input = with_boundary(graph, left_out, sub);
  if (input.rows.empty()) return sub.vertices;  // single vertices, all of them
  const int count = static_cast<int>(input.constraint.size());
  std::vector<int> permutation(count);
  double control[CAMD_CONTROL], info[CAMD_INFO];
  camd_defaults(control);
  const int status = camd_order(count, input.offsets.data(), input.rows.data(), permutation.data(), control,
                                info, input.constraint.data());
  if (status == CAMD_OUT_OF_MEMORY) throw OutOfMemory(MemorySpace::host, bytes(sub), 0);
  if (status < CAMD_OK) throw BackendError("CAMD", status, "minimum degree");
  std::vector<Vertex> order(sub.vertices.size());
  std::transform(permutation.begin(), permutation.begin() + sub.size(), order.begin(),
                 [&](int v) { return sub.vertices[v]; });
  return order;
}

}  // namespace mfs
