#include "test/stages/weak_pivots.hpp"

#include <cmath>

namespace mfs::test {

StageProblem<double> two_fronts(Vertex pivots, Vertex border, const std::vector<Entry>& entries,
                                Vertex max_block_size) {
  SeparatorTree tree;
  for (Vertex p = 0; p < pivots + border; ++p) tree.order.push_back(p);
  tree.node_begin = {0, pivots};
  tree.parent = {-1};
  if (border > 0) {
    tree.node_begin.push_back(pivots + border);
    tree.parent = {1, -1};
  }
  return matrix_problem(from_entries_summed(pivots + border, entries), tree, max_block_size);
}

StageProblem<double> zero_pivot_block(Vertex pivots, Vertex border, Vertex max_block_size, double corner) {
  Random random(static_cast<std::uint64_t>(100 * pivots + border));
  std::vector<Entry> entries;
  for (Vertex i = 0; i < pivots; ++i) {
    for (Vertex j = 0; j < pivots; ++j) entries.push_back({i, j, 0.0});
    for (Vertex j = pivots; j < pivots + border; ++j) {
      entries.push_back({i, j, random.entry()});
      entries.push_back({j, i, random.entry()});
    }
  }
  for (Vertex j = pivots; j < pivots + border; ++j) entries.push_back({j, j, corner});
  return two_fronts(pivots, border, entries, max_block_size);
}

StageProblem<double> low_rank_pivot_block(std::uint64_t seed, Vertex pivots, Vertex rank, Vertex border,
                                          Vertex max_block_size, double corner) {
  Random random(seed);
  std::vector<std::vector<double>> x(pivots, std::vector<double>(rank)), y = x;
  for (auto* factor : {&x, &y}) {
    for (auto& row : *factor) {
      for (double& value : row) value = static_cast<double>(random.integer(-2, 3));
    }
  }
  std::vector<Entry> entries;
  for (Vertex i = 0; i < pivots; ++i) {
    for (Vertex j = 0; j < pivots; ++j) {
      double value = 0;
      for (Vertex k = 0; k < rank; ++k) value += x[i][k] * y[j][k];
      entries.push_back({i, j, value / 64});
    }
    for (Vertex j = pivots; j < pivots + border; ++j) entries.push_back({i, j, random.entry()});
    for (Vertex j = pivots; j < pivots + border; ++j) entries.push_back({j, i, random.entry()});
  }
  for (Vertex j = pivots; j < pivots + border; ++j) entries.push_back({j, j, corner});
  return two_fronts(pivots, border, entries, max_block_size);
}

StageProblem<double> pivots_below_the_tile(Vertex pivots, Vertex half, double own) {
  constexpr Vertex b = 50;
  Random random(31);
  std::vector<Entry> entries;
  for (Vertex i = 0; i < pivots; ++i) {
    const Vertex partner = i < half ? i + half : i < 2 * half ? i - half : i;
    for (Vertex j = 0; j < pivots + b; ++j) {
      const double size = i < half && j < half ? own : 1;
      entries.push_back({i, j, j == partner ? 80.0 : size * random.entry()});
      if (j >= pivots) entries.push_back({j, i, random.entry()});
    }
  }
  for (Vertex j = pivots; j < pivots + b; ++j) entries.push_back({j, j, 80.0});
  return two_fronts(pivots, b, entries, 64);
}

void weaken_rows(StageProblem<double>& problem, std::uint64_t seed) {
  Random random(seed);
  for (Vertex row = 0; row < problem.pattern->n; ++row) {
    const double factor =
        random.chance(0.15) ? std::ldexp(1.0, -static_cast<int>(random.integer(10, 40))) : 1.0;
    for (Offset k = problem.pattern->offsets[row]; k < problem.pattern->offsets[row + 1]; ++k) {
      problem.values[k] *= factor;
    }
  }
}

}  // namespace mfs::test
