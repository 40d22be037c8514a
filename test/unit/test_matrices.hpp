// Small matrices for the tests of the ordering phase, and plain checks of its results.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <mfs/csr_view.hpp>

#include "ordering/matrix_check.hpp"
#include "ordering/types.hpp"

namespace mfs::test {

/// Compressed rows that own their arrays.
template <class Scalar, class Offsets = std::int32_t, class Columns = std::int32_t>
struct Matrix {
  std::vector<Offsets> offsets;
  std::vector<Columns> columns;
  std::vector<Scalar> values;

  CsrView<Scalar> view() const {
    const auto n = static_cast<std::int64_t>(offsets.size()) - 1;
    return {n, n, offsets.data(), columns.data(), values.data()};
  }
};

/// Rows in order, columns ascending, the last value of a place wins.
using Entries = std::map<std::pair<Vertex, Vertex>, double>;

template <class Scalar>
Matrix<Scalar> matrix_of(Vertex n, const std::map<std::pair<Vertex, Vertex>, Scalar>& entries) {
  Matrix<Scalar> a;
  a.offsets.assign(static_cast<std::size_t>(n) + 1, 0);
  for (const auto& [place, value] : entries) {
    ++a.offsets[place.first + 1];
    a.columns.push_back(place.second);
    a.values.push_back(value);
  }
  for (Vertex i = 0; i < n; ++i) a.offsets[i + 1] += a.offsets[i];
  return a;
}

inline Matrix<double> matrix_of(Vertex n, const Entries& entries) {
  return matrix_of<double>(n, entries);
}

inline Pattern pattern_of(Vertex n, const Entries& entries) {
  return check_pattern(matrix_of(n, entries).view(), 1);
}

/// Both directions of each edge and, unless told otherwise, the diagonal.
inline Entries symmetric(Vertex n, const std::vector<std::pair<Vertex, Vertex>>& edges,
                         double diagonal = 4.0) {
  Entries entries;
  for (const auto& [i, j] : edges) entries[{i, j}] = entries[{j, i}] = -1.0;
  for (Vertex i = 0; diagonal != 0.0 && i < n; ++i) entries[{i, i}] = diagonal;
  return entries;
}

inline Entries path(Vertex n) {
  std::vector<std::pair<Vertex, Vertex>> edges;
  for (Vertex i = 0; i + 1 < n; ++i) edges.emplace_back(i, i + 1);
  return symmetric(n, edges);
}

/// Unknown 0 is tied to all others.
inline Entries star(Vertex n) {
  std::vector<std::pair<Vertex, Vertex>> edges;
  for (Vertex i = 1; i < n; ++i) edges.emplace_back(0, i);
  return symmetric(n, edges);
}

/// m x m nodes, nine-point neighbourhoods, `dofs` unknowns per node, all of them coupled.
inline Entries grid(Vertex m, Vertex dofs = 1) {
  Entries entries;
  for (Vertex y = 0; y < m; ++y) {
    for (Vertex x = 0; x < m; ++x) {
      for (Vertex v = std::max(y - 1, 0); v <= std::min(y + 1, m - 1); ++v) {
        for (Vertex u = std::max(x - 1, 0); u <= std::min(x + 1, m - 1); ++u) {
          for (Vertex d = 0; d < dofs; ++d) {
            for (Vertex e = 0; e < dofs; ++e) {
              const Vertex i = (y * m + x) * dofs + d, j = (v * m + u) * dofs + e;
              entries[{i, j}] = i == j ? 20.0 * dofs : -1.0;
            }
          }
        }
      }
    }
  }
  return entries;
}

/// Bodies of six unknowns, and between two of them, before the first and behind the last a joint of five,
/// which has no diagonal.
inline Entries chain_of_bodies(Vertex bodies) {
  Entries entries;
  for (Vertex body = 0; body < bodies; ++body) {
    for (Vertex i = 0; i < 36; ++i) entries[{6 * body + i / 6, 6 * body + i % 6}] = i % 7 == 0 ? 4.0 : 0.3;
    for (Vertex joint = body; joint <= body + 1; ++joint) {
      for (Vertex i = 0; i < 30; ++i) {
        const Vertex force = 6 * bodies + 5 * joint + i / 6, motion = 6 * body + i % 6;
        entries[{force, motion}] = entries[{motion, force}] = i / 6 == i % 6 ? 1.0 : 0.2;
      }
    }
  }
  return entries;
}

/// Fronts on the longest path.
inline Vertex depths_of(const SeparatorTree& tree) {
  Vertex most = 0;
  for (Vertex f = 0; f < tree.num_nodes(); ++f) {
    Vertex fronts = 0;
    for (Vertex at = f; at >= 0; at = tree.parent[at]) ++fronts;
    most = std::max(most, fronts);
  }
  return most;
}

/// About `density` off-diagonal entries per row; the diagonal is there with probability `diagonal`.
inline Entries random_entries(std::mt19937& generator, Vertex n, double density, double diagonal,
                              bool mirrored) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::uniform_int_distribution<Vertex> any(0, n - 1);
  Entries entries;
  for (Vertex i = 0; i < n; ++i) {
    if (uniform(generator) < diagonal) entries[{i, i}] = 1.0 + uniform(generator);
  }
  const int off_diagonal = static_cast<int>(density * n);
  for (int k = 0; k < off_diagonal; ++k) {
    const Vertex i = any(generator), j = any(generator);
    if (i == j) continue;
    entries[{i, j}] = uniform(generator) - 0.5;
    if (mirrored) entries[{j, i}] = uniform(generator) - 0.5;
  }
  return entries;
}

inline std::vector<std::set<Vertex>> neighbor_sets(const Graph& graph) {
  std::vector<std::set<Vertex>> sets(graph.n);
  for (Vertex v = 0; v < graph.n; ++v) {
    sets[v].insert(graph.neighbors.begin() + graph.offsets[v],
                   graph.neighbors.begin() + graph.offsets[v + 1]);
  }
  return sets;
}

/// What Ahat + Ahat^T ties together, as sets.
inline std::vector<std::set<Vertex>> plain_graph(Vertex n, const Entries& entries,
                                                 const std::vector<Vertex>& row_order = {}) {
  std::vector<Vertex> unknown_of_row(n);
  for (Vertex i = 0; i < n; ++i) unknown_of_row[row_order.empty() ? i : row_order[i]] = i;
  std::vector<std::set<Vertex>> sets(n);
  for (const auto& entry : entries) {
    const Vertex i = unknown_of_row[entry.first.first], j = entry.first.second;
    if (i == j) continue;
    sets[i].insert(j);
    sets[j].insert(i);
  }
  return sets;
}

inline void expect_permutation(const std::vector<Vertex>& order, Vertex n) {
  ASSERT_EQ(static_cast<Vertex>(order.size()), n);
  std::vector<Vertex> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (Vertex i = 0; i < n; ++i) ASSERT_EQ(sorted[i], i);
}

/// The shape that every separator tree promises: a permutation, no empty node, parents later, breadth first
/// from the deepest depth, siblings together; and no entry of the matrix between unrelated nodes.
inline void expect_valid_tree(const SeparatorTree& tree, const std::vector<std::set<Vertex>>& graph) {
  const auto n = static_cast<Vertex>(graph.size());
  const Vertex nodes = tree.num_nodes();
  expect_permutation(tree.order, n);
  ASSERT_EQ(static_cast<Vertex>(tree.node_begin.size()), nodes + 1);
  ASSERT_EQ(tree.node_begin.front(), 0);
  ASSERT_EQ(tree.node_begin.back(), n);
  std::vector<Vertex> node_of(n), depth(nodes);
  for (Vertex k = 0; k < nodes; ++k) {
    ASSERT_LT(tree.node_begin[k], tree.node_begin[k + 1]) << "empty node " << k;
    for (Vertex p = tree.node_begin[k]; p < tree.node_begin[k + 1]; ++p) node_of[tree.order[p]] = k;
  }
  for (Vertex k = nodes - 1; k >= 0; --k) {
    ASSERT_TRUE(tree.parent[k] == -1 || (tree.parent[k] > k && tree.parent[k] < nodes)) << "parent of " << k;
    depth[k] = tree.parent[k] < 0 ? 0 : depth[tree.parent[k]] + 1;
  }
  for (Vertex k = 0; k + 1 < nodes; ++k) {
    ASSERT_GE(depth[k], depth[k + 1]) << "not breadth first at node " << k;
    if (depth[k] == depth[k + 1]) {
      ASSERT_LE(tree.parent[k], tree.parent[k + 1]) << "siblings apart at node " << k;
    }
  }
  for (Vertex i = 0; i < n; ++i) {
    for (const Vertex j : graph[i]) {
      Vertex low = std::min(node_of[i], node_of[j]);
      const Vertex high = std::max(node_of[i], node_of[j]);
      while (low != -1 && low < high) low = tree.parent[low];
      ASSERT_EQ(low, high) << "unknowns " << i << " and " << j << " are in unrelated nodes";
    }
  }
}

/// The columns of the factor, by plain elimination on sets: structure[p] = later positions in the column of
/// p.
inline std::vector<std::set<Vertex>> plain_elimination(const std::vector<std::set<Vertex>>& graph,
                                                       const std::vector<Vertex>& order) {
  std::vector<Vertex> position(order.size());
  for (std::size_t p = 0; p < order.size(); ++p) position[order[p]] = static_cast<Vertex>(p);
  std::vector<std::set<Vertex>> structure(order.size());
  for (std::size_t v = 0; v < graph.size(); ++v) {
    for (const Vertex w : graph[v]) {
      if (position[w] > position[v]) structure[position[v]].insert(position[w]);
    }
  }
  for (auto& column : structure) {
    if (column.empty()) continue;
    const Vertex parent = *column.begin();
    structure[parent].insert(std::next(column.begin()), column.end());
  }
  return structure;
}

inline std::size_t plain_fill(const std::vector<std::set<Vertex>>& graph, const std::vector<Vertex>& order) {
  std::size_t entries = order.size();
  for (const auto& column : plain_elimination(graph, order)) entries += column.size();
  return entries;
}

/// Can every weak unknown have a partner of its own that stands before it? Kuhn's algorithm, plainly.
inline bool all_served(const WeakUnknowns& weak, const std::vector<Vertex>& order) {
  std::vector<std::size_t> position(order.size());
  for (std::size_t p = 0; p < order.size(); ++p) position[order[p]] = p;
  std::vector<int> holder(order.size(), -1);
  std::vector<bool> seen;
  const std::function<bool(int)> serve = [&](int k) {
    for (Offset p = weak.begin[k]; p < weak.begin[k + 1]; ++p) {
      const Vertex partner = weak.partner[p];
      if (seen[partner] || position[partner] > position[weak.unknown[k]]) continue;
      seen[partner] = true;
      if (holder[partner] >= 0 && !serve(holder[partner])) continue;
      holder[partner] = k;
      return true;
    }
    return false;
  };
  for (std::size_t k = 0; k < weak.unknown.size(); ++k) {
    seen.assign(order.size(), false);
    if (!serve(static_cast<int>(k))) return false;
  }
  return true;
}

}  // namespace mfs::test
