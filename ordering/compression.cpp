#include "ordering/compression.hpp"

#include <cstdint>
#include <numeric>
#include <utility>

#include "ordering/mixed_bits.hpp"

namespace mfs {
namespace {

/// A second merge pays only if it removes at least one vertex in ten.
constexpr double kWorthMerging = 0.9;

/// leader[i] = the first unknown of i's pair (or longer cycle).
std::vector<Vertex> pair_leaders(Vertex n, const std::vector<Vertex>& pair) {
  std::vector<Vertex> leader(n);
  std::iota(leader.begin(), leader.end(), 0);
  if (pair.empty()) return leader;
  for (Vertex i = 0; i < n; ++i) {
    if (leader[i] != i) continue;
    for (Vertex j = pair[i]; j != i; j = pair[j]) leader[j] = i;
  }
  return leader;
}

/// Hash of the closed row and the closed column of each unknown of Ahat. Sums: the order of the threads is of
/// no account. Rows of unknowns that are paired hash to something of their own.
std::vector<std::uint64_t> closed_hashes(const Pattern& pattern, const MatchedScaling& matched, int threads) {
  const Vertex n = pattern.n;
  std::vector<std::uint64_t> row_hash(n), column_hash(n, 0);
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < n; ++i) {
    const Vertex row = matched.row_order.empty() ? i : matched.row_order[i];
    const std::uint64_t own = mixed(i);
    std::uint64_t sum = own;
    for (Offset k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k) {
      const Vertex j = pattern.columns[k];
      if (j == i) continue;
      sum += mixed(j);
      if (threads == 1) {
        column_hash[j] += own;
      } else {
#pragma omp atomic
        column_hash[j] += own;
      }
    }
    row_hash[i] = sum;
  }
  for (Vertex i = 0; i < n; ++i) {
    row_hash[i] = mixed(row_hash[i]) + column_hash[i] + mixed(i);
    if (!matched.pair.empty() && matched.pair[i] != i) row_hash[i] = mixed(row_hash[i] ^ mixed(i));
  }
  return row_hash;
}

/// Leads each unknown to the first of its neighbours that is like it. `row_of(i)` is i's sorted neighbour
/// list.
template <class RowOf>
void lead_alike(const std::vector<std::uint64_t>& hash, const RowOf& row_of, int threads,
                std::vector<Vertex>& leader) {
  const auto n = static_cast<Vertex>(leader.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < n; ++i) {
    if (leader[i] != i) continue;
    const auto [first, last] = row_of(i);
    for (const Vertex* j = first; j != last && *j < i; ++j) {
      if (hash[*j] != hash[i]) continue;
      leader[i] = *j;
      break;
    }
  }
  for (Vertex i = 0; i < n; ++i) leader[i] = leader[leader[i]];
}

/// Vertices of `graph` with equal closed neighbourhoods.
Partition alike_vertices(const Graph& graph, int threads) {
  std::vector<std::uint64_t> hash(graph.n);
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex v = 0; v < graph.n; ++v) {
    hash[v] = mixed(v);
    for (Offset k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) hash[v] += mixed(graph.neighbors[k]);
  }
  std::vector<Vertex> leader(graph.n);
  std::iota(leader.begin(), leader.end(), 0);
  const auto row_of = [&](Vertex v) {
    return std::pair(graph.neighbors.data() + graph.offsets[v],
                     graph.neighbors.data() + graph.offsets[v + 1]);
  };
  lead_alike(hash, row_of, threads, leader);
  return partition_by_leader(leader);
}

/// Pairs, and unknowns that are alike as the matrix shows it: the cheap pass, before any graph is built. A
/// finite element matrix shrinks here by the square of its degrees of freedom per node.
Partition alike_unknowns(const Pattern& pattern, const MatchedScaling& matched, int threads) {
  std::vector<Vertex> leader = pair_leaders(pattern.n, matched.pair);
  const auto row_of = [&](Vertex i) {
    const Vertex row = matched.row_order.empty() ? i : matched.row_order[i];
    return std::pair(pattern.columns.data() + pattern.offsets[row],
                     pattern.columns.data() + pattern.offsets[row + 1]);
  };
  lead_alike(closed_hashes(pattern, matched, threads), row_of, threads, leader);
  return partition_by_leader(leader);
}

}  // namespace

CompressedGraph compressed_graph(const Pattern& pattern, const MatchedScaling& matched, int threads) {
  CompressedGraph result;
  result.partition = alike_unknowns(pattern, matched, threads);
  result.graph = build_graph(pattern, matched.row_order, result.partition, threads);
  // What pairs and one-sided entries hid from the first pass.
  const Partition coarser = alike_vertices(result.graph, threads);
  if (coarser.num_vertices() < kWorthMerging * result.graph.n) {
    result.graph = merge_vertices(result.graph, coarser, threads);
    result.partition = compose(result.partition, coarser);
  }
  return result;
}

CompressedGraph paired_graph(const Pattern& pattern, const MatchedScaling& matched, int threads) {
  CompressedGraph result;
  result.partition = partition_by_leader(pair_leaders(pattern.n, matched.pair));
  result.graph = build_graph(pattern, matched.row_order, result.partition, threads);
  return result;
}

}  // namespace mfs
