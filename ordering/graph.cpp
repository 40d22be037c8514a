#include "ordering/graph.hpp"

#include <omp.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "ordering/first_error.hpp"

namespace mfs {
namespace {

/// A contiguous share of [0, count) for each thread.
std::pair<Vertex, Vertex> share(Vertex count, int thread, int threads) {
  const auto bound = [&](int t) { return static_cast<Vertex>(static_cast<Offset>(count) * t / threads); };
  return {bound(thread), bound(thread + 1)};
}

/// What one thread found for its share of the vertices, in their order.
using Piece = std::vector<Vertex>;

/// Appends the sorted, unique list of the other vertices that the members' rows touch; returns its length.
/// `row_of(member)` gives the first and last of the member's column list.
template <class RowOf>
Vertex append_row(const Partition& partition, Vertex v, const RowOf& row_of, Piece& piece) {
  const std::size_t start = piece.size();
  Vertex previous = -1;
  bool ascending = true;
  for (Vertex m = partition.begin[v]; m < partition.begin[v + 1]; ++m) {
    const auto [first, last] = row_of(partition.members[m]);
    if (m > partition.begin[v]) {
      const auto [leader_first, leader_last] = row_of(partition.members[partition.begin[v]]);
      if (std::equal(first, last, leader_first, leader_last)) continue;
    }
    for (const Vertex* column = first; column != last; ++column) {
      const Vertex w = partition.vertex_of[*column];
      if (w == v || w == previous) continue;
      ascending = ascending && w > previous;
      piece.push_back(w);
      previous = w;
    }
  }
  if (!ascending) {
    std::sort(piece.begin() + start, piece.end());
    piece.erase(std::unique(piece.begin() + start, piece.end()), piece.end());
  }
  return static_cast<Vertex>(piece.size() - start);
}

/// One direction of each edge: the rows of the merged pattern, without the diagonal.
template <class RowOf>
Graph directed_graph(const Partition& partition, const RowOf& row_of, int threads) {
  Graph graph;
  graph.n = partition.num_vertices();
  graph.offsets.assign(static_cast<std::size_t>(graph.n) + 1, 0);
  std::vector<Piece> pieces(threads);
  FirstError error;
#pragma omp parallel num_threads(threads)
  {
    // One thread may get several pieces where the system grants fewer threads than asked for.
    for (int p = omp_get_thread_num(); p < threads; p += omp_get_num_threads()) {
      error.attempt([&] {
        const auto [first, last] = share(graph.n, p, threads);
        for (Vertex v = first; v < last; ++v)
          graph.offsets[v + 1] = append_row(partition, v, row_of, pieces[p]);
      });
    }
  }
  error.rethrow();
  std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
  if (threads == 1) {
    graph.neighbors = std::move(pieces[0]);
    return graph;
  }
  graph.neighbors.resize(static_cast<std::size_t>(graph.offsets[graph.n]));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int p = 0; p < threads; ++p) {
    std::copy(pieces[p].begin(), pieces[p].end(),
              graph.neighbors.begin() + graph.offsets[share(graph.n, p, threads).first]);
    Piece().swap(pieces[p]);
  }
  return graph;
}

struct Edge {
  Vertex from, to;
};

/// Edges (v, w) whose reverse is not stored, ascending by v; in pieces, one after the other.
std::vector<std::vector<Edge>> one_way_edges(const Graph& graph, int threads) {
  std::vector<std::vector<Edge>> pieces(threads);
  FirstError error;
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int p = 0; p < threads; ++p) {
    error.attempt([&] {
      const auto [first, last] = share(graph.n, p, threads);
      for (Vertex v = first; v < last; ++v) {
        for (Offset k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
          const Vertex w = graph.neighbors[k];
          const auto begin = graph.neighbors.begin() + graph.offsets[w];
          const auto end = graph.neighbors.begin() + graph.offsets[w + 1];
          if (!std::binary_search(begin, end, v)) pieces[p].push_back({v, w});
        }
      }
    });
  }
  error.rethrow();
  return pieces;
}

/// The reverses of one-way edges, gathered by the vertex where they must be added: a counting sort, which
/// keeps the order of the sources and so leaves every row sorted.
Graph reversed(Vertex n, const std::vector<std::vector<Edge>>& pieces) {
  Graph graph;
  graph.n = n;
  graph.offsets.assign(static_cast<std::size_t>(n) + 1, 0);
  for (const auto& piece : pieces) {
    for (const Edge& edge : piece) ++graph.offsets[edge.to + 1];
  }
  std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
  graph.neighbors.resize(static_cast<std::size_t>(graph.offsets[n]));
  std::vector<Offset> next(graph.offsets.begin(), graph.offsets.end() - 1);
  for (const auto& piece : pieces) {
    for (const Edge& edge : piece) graph.neighbors[next[edge.to]++] = edge.from;
  }
  return graph;
}

/// Adds what is missing so that each edge is stored at both ends.
Graph symmetrised(Graph directed, int threads) {
  const auto pieces = one_way_edges(directed, threads);
  if (std::all_of(pieces.begin(), pieces.end(), [](const auto& piece) { return piece.empty(); }))
    return directed;
  const Graph missing = reversed(directed.n, pieces);
  Graph graph;
  graph.n = directed.n;
  graph.offsets.resize(directed.offsets.size());
  std::transform(directed.offsets.begin(), directed.offsets.end(), missing.offsets.begin(),
                 graph.offsets.begin(), std::plus<>());
  graph.neighbors.resize(directed.neighbors.size() + missing.neighbors.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex v = 0; v < graph.n; ++v) {
    std::merge(
        directed.neighbors.begin() + directed.offsets[v],
        directed.neighbors.begin() + directed.offsets[v + 1], missing.neighbors.begin() + missing.offsets[v],
        missing.neighbors.begin() + missing.offsets[v + 1], graph.neighbors.begin() + graph.offsets[v]);
  }
  return graph;
}

}  // namespace

Partition partition_by_leader(const std::vector<Vertex>& leader) {
  const auto n = static_cast<Vertex>(leader.size());
  Partition partition;
  partition.vertex_of.resize(n);
  std::vector<Vertex> size;
  for (Vertex i = 0; i < n; ++i) {
    if (leader[i] == i) {
      partition.vertex_of[i] = static_cast<Vertex>(size.size());
      size.push_back(0);
    } else {
      partition.vertex_of[i] = partition.vertex_of[leader[i]];
    }
    ++size[partition.vertex_of[i]];
  }
  partition.begin.assign(size.size() + 1, 0);
  std::partial_sum(size.begin(), size.end(), partition.begin.begin() + 1);
  std::vector<Vertex> next(partition.begin.begin(), partition.begin.end() - 1);
  partition.members.resize(n);
  for (Vertex i = 0; i < n; ++i) partition.members[next[partition.vertex_of[i]]++] = i;
  return partition;
}

Partition trivial_partition(Vertex n) {
  Partition partition;
  partition.vertex_of.resize(n);
  partition.begin.resize(static_cast<std::size_t>(n) + 1);
  std::iota(partition.vertex_of.begin(), partition.vertex_of.end(), 0);
  std::iota(partition.begin.begin(), partition.begin.end(), 0);
  partition.members = partition.vertex_of;
  return partition;
}

Partition compose(const Partition& fine, const Partition& coarse) {
  std::vector<Vertex> leader(fine.vertex_of.size());
  std::vector<Vertex> first(coarse.num_vertices(), -1);
  for (std::size_t i = 0; i < leader.size(); ++i) {
    Vertex& group_leader = first[coarse.vertex_of[fine.vertex_of[i]]];
    if (group_leader < 0) group_leader = static_cast<Vertex>(i);
    leader[i] = group_leader;
  }
  return partition_by_leader(leader);
}

Graph build_graph(const Pattern& pattern, const std::vector<Vertex>& row_order, const Partition& partition,
                  int threads) {
  const auto row_of = [&](Vertex unknown) {
    const Vertex row = row_order.empty() ? unknown : row_order[unknown];
    return std::pair(pattern.columns.data() + pattern.offsets[row],
                     pattern.columns.data() + pattern.offsets[row + 1]);
  };
  Graph graph = symmetrised(directed_graph(partition, row_of, threads), threads);
  graph.weight.resize(graph.n);
  for (Vertex v = 0; v < graph.n; ++v) graph.weight[v] = partition.begin[v + 1] - partition.begin[v];
  return graph;
}

Graph merge_vertices(const Graph& graph, const Partition& partition, int threads) {
  const auto row_of = [&](Vertex v) {
    return std::pair(graph.neighbors.data() + graph.offsets[v],
                     graph.neighbors.data() + graph.offsets[v + 1]);
  };
  Graph merged = directed_graph(partition, row_of, threads);
  merged.weight.assign(merged.n, 0);
  for (Vertex v = 0; v < graph.n; ++v) merged.weight[partition.vertex_of[v]] += graph.weight[v];
  return merged;
}

}  // namespace mfs
