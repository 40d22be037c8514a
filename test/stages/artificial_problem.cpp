#include "test/stages/artificial_problem.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "test/reference/symbolic.hpp"

namespace mfs::test {

namespace {

// Positions at which the pivots of the ancestors of f lie.
std::vector<Vertex> ancestor_positions(const std::vector<FrontShape>& shapes,
                                       const std::vector<Vertex>& begin, Vertex f) {
  std::vector<Vertex> positions;
  for (Vertex ancestor = shapes[f].parent; ancestor >= 0; ancestor = shapes[ancestor].parent) {
    for (Vertex p = begin[ancestor]; p < begin[ancestor + 1]; ++p) positions.push_back(p);
  }
  return positions;
}

// The column of the large entry of each row: its own for a part of them, a random one for the others.
std::vector<Vertex> partners(Vertex pivots, double kept, Random& random) {
  if (kept == 0) return random.permutation(pivots);
  std::vector<Vertex> partner(pivots), moved;
  for (Vertex i = 0; i < pivots; ++i) {
    partner[i] = i;
    if (!random.chance(kept)) moved.push_back(i);
  }
  const std::vector<Vertex> to = random.permutation(static_cast<Vertex>(moved.size()));
  for (std::size_t k = 0; k < moved.size(); ++k) partner[moved[k]] = moved[to[k]];
  return partner;
}

// Entries of one front by position; the first pivot is tied to the whole border, so that none of it is lost.
void add_front(const std::vector<FrontShape>& shapes, const std::vector<Vertex>& begin, Vertex f,
               const ProblemOptions& options, Random& random, std::vector<Entry>& entries) {
  std::vector<Vertex> candidates = ancestor_positions(shapes, begin, f);
  const std::vector<Vertex> draw = random.permutation(static_cast<Vertex>(candidates.size()));
  std::vector<Vertex> border;
  for (Vertex k = 0; k < shapes[f].border; ++k) border.push_back(candidates[draw[k]]);

  const Vertex p = shapes[f].pivots;
  const double large = 4 * std::sqrt(static_cast<double>(p) + static_cast<double>(border.size()));
  const std::vector<Vertex> partner = partners(p, options.kept, random);
  for (Vertex i = 0; i < p; ++i) {
    for (Vertex j = 0; j < p; ++j) {
      if (j == partner[i]) {
        entries.push_back({begin[f] + i, begin[f] + j, random.chance(0.5) ? large : -large});
      } else if (random.chance(options.density)) {
        entries.push_back({begin[f] + i, begin[f] + j, random.entry()});
      }
    }
    for (const Vertex b : border) {
      if (i == 0 || random.chance(options.density)) entries.push_back({begin[f] + i, b, random.entry()});
      if (i == 0 || random.chance(options.density)) entries.push_back({b, begin[f] + i, random.entry()});
    }
  }
}

std::vector<double> powers_of_two(Random& random, Vertex n) {
  std::vector<double> scale(n);
  for (double& s : scale) s = std::ldexp(1.0, static_cast<int>(random.integer(-3, 4)));
  return scale;
}

}  // namespace

Pattern pattern_of(const SparseMatrix& matrix) {
  Pattern pattern;
  pattern.n = static_cast<Vertex>(matrix.n);
  pattern.offsets = matrix.offsets;
  pattern.columns.assign(matrix.columns.begin(), matrix.columns.end());
  pattern.num_entries = matrix.entries();
  return pattern;
}

StageProblem<double> artificial_problem(const std::vector<FrontShape>& shapes,
                                        const ProblemOptions& options) {
  Random random(options.seed);
  SeparatorTree tree;
  tree.node_begin.push_back(0);
  for (const FrontShape& shape : shapes) {
    tree.node_begin.push_back(tree.node_begin.back() + shape.pivots);
    tree.parent.push_back(shape.parent);
  }
  const Vertex n = tree.node_begin.back();
  std::vector<Entry> entries;
  for (Vertex f = 0; f < tree.num_nodes(); ++f) {
    add_front(shapes, tree.node_begin, f, options, random, entries);
  }
  tree.order = random.permutation(n);
  const std::vector<Vertex> row_order = random.permutation(n);  // unknown -> row of A
  StageProblem<double> problem;
  problem.row_scale = powers_of_two(random, n);
  problem.column_scale = powers_of_two(random, n);
  for (Entry& e : entries) {
    e.row = row_order[tree.order[e.row]];
    e.column = tree.order[e.column];
    e.value /= problem.row_scale[e.row] * problem.column_scale[e.column];
  }
  const SparseMatrix matrix = from_entries_summed(n, entries);
  problem.values = matrix.values;
  problem.pattern = std::make_shared<Pattern>(pattern_of(matrix));
  problem.plan = std::make_shared<SymbolicPlan>(
      make_symbolic_plan(*problem.pattern, row_order, tree, options.max_block_size, 1, options.turns));
  return problem;
}

namespace {

void convert(double value, Random&, double& to) {
  to = value;
}
void convert(double value, Random&, float& to) {
  to = static_cast<float>(value);
}
template <class Real>
void convert(double value, Random& random, std::complex<Real>& to) {
  to = std::complex<Real>(std::polar(value < 0 ? -value : value, 6.283185307179586 * random.unit()));
}

}  // namespace

template <class Scalar>
StageProblem<Scalar> in_numbers_of(const StageProblem<double>& problem) {
  Random random(99);
  StageProblem<Scalar> other{problem.pattern, {}, problem.row_scale, problem.column_scale, problem.plan};
  other.values.resize(problem.values.size());
  for (std::size_t k = 0; k < problem.values.size(); ++k) convert(problem.values[k], random, other.values[k]);
  return other;
}
template StageProblem<float> in_numbers_of(const StageProblem<double>&);
template StageProblem<double> in_numbers_of(const StageProblem<double>&);
template StageProblem<std::complex<float>> in_numbers_of(const StageProblem<double>&);
template StageProblem<std::complex<double>> in_numbers_of(const StageProblem<double>&);

StageProblem<double> matrix_problem(const SparseMatrix& matrix, const SeparatorTree& tree,
                                    Vertex max_block_size) {
  StageProblem<double> problem;
  problem.values = matrix.values;
  problem.row_scale.assign(matrix.n, 1.0);
  problem.column_scale.assign(matrix.n, 1.0);
  problem.pattern = std::make_shared<Pattern>(pattern_of(matrix));
  problem.plan =
      std::make_shared<SymbolicPlan>(make_symbolic_plan(*problem.pattern, {}, tree, max_block_size, 1));
  return problem;
}

SeparatorTree one_unknown_per_front(const Pattern& pattern) {
  const Vertex n = pattern.n;
  std::vector<Vertex> natural(n), one_by_one(n + 1);
  for (Vertex i = 0; i < n; ++i) natural[i] = one_by_one[i] = i;
  one_by_one[n] = n;
  const auto borders = eliminate_fronts(symmetric_pattern(pattern, {}, natural), one_by_one);
  std::vector<Vertex> depth(n, 0);
  for (Vertex i = n - 1; i >= 0; --i) {
    if (!borders[i].empty()) depth[i] = depth[borders[i].front()] + 1;
  }
  SeparatorTree tree;
  tree.order = natural;
  std::stable_sort(tree.order.begin(), tree.order.end(),
                   [&](Vertex a, Vertex b) { return depth[a] > depth[b]; });
  tree.node_begin = one_by_one;
  const std::vector<Vertex> place = inverse(tree.order);
  for (const Vertex unknown : tree.order) {
    tree.parent.push_back(borders[unknown].empty() ? -1 : place[borders[unknown].front()]);
  }
  return tree;
}

std::vector<FrontShape> leaf_and_root(Vertex pivots, Vertex border) {
  if (border == 0) return {{pivots, 0, -1}};
  return {{pivots, border, 1}, {border, 0, -1}};
}

std::vector<FrontShape> mixed_tree() {
  return {
      {1, 40, 4},    {65, 33, 4},  {2, 1, 5},    {33, 70, 6},  // depth 4
      {31, 90, 8},   {1, 1, 8},    {129, 64, 8}, {7, 0, 9},    // depth 3
      {64, 100, 11}, {32, 31, 12}, {5, 150, 12},               // depth 2
      {90, 60, 13},  {33, 64, 13},                             // depth 1
      {130, 0, -1},  {40, 0, -1},                              // roots
  };
}

std::vector<FrontShape> binary_tree(Vertex levels, Vertex pivots, Vertex border) {
  std::vector<FrontShape> shapes;
  Vertex first = 0;
  for (Vertex depth = levels - 1; depth >= 0; --depth) {
    const Vertex count = Vertex(1) << depth;
    for (Vertex i = 0; i < count; ++i)
      shapes.push_back({pivots + depth, depth > 0 ? std::min(border, pivots * depth) : 0,
                        depth > 0 ? first + count + i / 2 : -1});
    first += count;
  }
  return shapes;
}

std::vector<FrontShape> broom() {
  std::vector<FrontShape> shapes;
  for (Vertex k = 0; k < 200; ++k) shapes.push_back({1, k % 5, 200});
  shapes.push_back({20, 0, -1});
  return shapes;
}

std::vector<FrontShape> fork() {
  std::vector<FrontShape> shapes;
  for (Vertex k = 0; k < 6; ++k) shapes.push_back({100, 350, 14 + k / 2});
  for (Vertex k = 0; k < 8; ++k) shapes.push_back({10, 200, 17});
  for (Vertex k = 0; k < 3; ++k) shapes.push_back({100, 300, 18});
  shapes.push_back({40, 120, 18});
  shapes.push_back({300, 0, -1});
  return shapes;
}

std::vector<FrontShape> crowd() {
  std::vector<FrontShape> shapes;
  for (Vertex k = 0; k < 130; ++k) shapes.push_back({1 + 11 * k % 90, 100 + 13 * k % 201, 130});
  shapes.push_back({320, 0, -1});
  return shapes;
}

std::vector<FrontShape> chain() {
  std::vector<FrontShape> shapes;
  for (Vertex k = 0; k < 12; ++k) shapes.push_back({1 + 3 * k, std::min(5 * k, 40), k + 1});
  shapes.push_back({45, 0, -1});
  return shapes;
}

}  // namespace mfs::test
