#include "test/reference/generators.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "test/reference/random.hpp"

namespace mfs::test {

SparseMatrix grid_2d(std::int64_t rows, std::int64_t columns) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < rows; ++i) {
    for (std::int64_t j = 0; j < columns; ++j) {
      const std::int64_t point = i * columns + j;
      if (i > 0) entries.push_back({point, point - columns, -1.3});
      if (j > 0) entries.push_back({point, point - 1, -1.1});
      entries.push_back({point, point, 4.5});
      if (j + 1 < columns) entries.push_back({point, point + 1, -0.9});
      if (i + 1 < rows) entries.push_back({point, point + columns, -0.7});
    }
  }
  return from_entries(rows * columns, entries);
}

SparseMatrix grid_3d(std::int64_t points) {
  std::vector<Entry> entries;
  const std::int64_t apart[] = {points * points, points, 1};
  for (std::int64_t row = 0; row < points * points * points; ++row) {
    const std::int64_t place[] = {row / apart[0], row / points % points, row % points};
    for (int k = 0; k < 3; ++k) {
      if (place[k] > 0) entries.push_back({row, row - apart[k], -1.3 + 0.1 * k});
      if (place[k] + 1 < points) entries.push_back({row, row + apart[k], -0.9 + 0.1 * k});
    }
    entries.push_back({row, row, 6.5});
  }
  return from_entries(points * points * points, entries);
}

SparseMatrix tridiagonal(std::int64_t n) {
  return grid_2d(1, n);
}

SparseMatrix arrow(std::int64_t n, std::int64_t width) {
  std::vector<Entry> entries;
  Random random(static_cast<std::uint64_t>(n * 1000 + width));
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, i < n - width ? 4.0 : 4.0 * static_cast<double>(n)});
    for (std::int64_t j = n - width; j < n; ++j) {
      if (i == j) continue;
      entries.push_back({i, j, random.entry()});
      if (i < n - width) entries.push_back({j, i, random.entry()});
    }
  }
  return from_entries_summed(n, entries);
}

SparseMatrix permuted_blocks(const std::vector<std::int64_t>& sizes, std::uint64_t seed) {
  Random random(seed);
  std::int64_t n = 0;
  for (const std::int64_t size : sizes) n += size;
  const std::vector<std::int64_t> row = random.permutation(n), column = random.permutation(n);
  std::vector<Entry> entries;
  std::int64_t begin = 0;
  for (const std::int64_t size : sizes) {
    for (std::int64_t i = 0; i < size; ++i) {
      const auto add = [&](std::int64_t j, double value) {
        entries.push_back({row[begin + i], column[j], value});
      };
      add(begin + i, random.chance(0.5) ? 4 : -4);
      if (size > 1) add(begin + (i + 1) % size, 0.5 + random.unit());
      for (int k = 0; k < 6 && size > 6; ++k) add(begin + random.integer(0, size), 0.15 * random.entry());
      for (int k = 0; k < 2 && begin > 0; ++k) add(random.integer(0, begin), 0.5 * random.entry());
    }
    begin += size;
  }
  return from_entries_summed(n, std::move(entries));
}

SparseMatrix random_diagonally_dominant(std::int64_t n, std::int64_t per_row, std::uint64_t seed) {
  Random random(seed);
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, static_cast<double>(2 * per_row)});
    for (std::int64_t k = 0; k < per_row; ++k) entries.push_back({i, random.integer(0, n), random.entry()});
  }
  return from_entries_summed(n, entries);
}

SparseMatrix resistors(std::int64_t nodes, std::uint64_t seed) {
  Random random(seed);
  std::vector<Entry> entries;
  std::vector<double> diagonal(static_cast<std::size_t>(nodes), 1e-6);
  for (std::int64_t i = 1; i < nodes; ++i) {
    const std::int64_t before = random.integer(std::max<std::int64_t>(i - 300, 0), i);
    const double conductance = std::pow(10.0, 3 * random.entry());
    for (const std::int64_t node : {i, before}) diagonal[node] += conductance;
    entries.push_back({i, before, -conductance});
    entries.push_back({before, i, -conductance});
  }
  for (std::int64_t i = 0; i < nodes; ++i) entries.push_back({i, i, diagonal[i]});
  return from_entries(nodes, entries);
}

SparseMatrix renumbered(const SparseMatrix& a, Random& random) {
  const std::vector<std::int64_t> place = random.permutation(a.n);
  std::vector<Entry> entries = entries_of(a);
  for (Entry& e : entries) {
    e.row = place[e.row];
    e.column = place[e.column];
  }
  return from_entries_summed(a.n, entries);
}

SparseMatrix floating_chains(std::int64_t chains, std::int64_t length, bool alike, double spring) {
  std::vector<Entry> entries;
  for (std::int64_t chain = 0; chain < chains; ++chain) {
    Random random(alike ? 1 : static_cast<std::uint64_t>(chain) + 1);
    for (std::int64_t k = 0; k < length; ++k) {
      const std::int64_t i = chain * length + k;
      const double before = k > 0 ? 1 + 0.5 * random.entry() : 0;
      const double after = k + 1 < length ? 1 + 0.5 * random.entry() : 0;
      if (k > 0) entries.push_back({i, i - 1, -before});
      entries.push_back({i, i, before + after + spring * (1 + (alike ? 0 : 10 * random.unit()))});
      if (k + 1 < length) entries.push_back({i, i + 1, -after});
    }
  }
  return from_entries(chains * length, entries);
}

SparseMatrix with_cancelling_pivots(const SparseMatrix& a, std::int64_t count) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < a.n; ++i) {
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
      entries.push_back({i, a.columns[k], a.values[k]});
  }
  for (std::int64_t pair = 0; pair < count; ++pair) {
    const std::int64_t first = a.n + 2 * pair, second = first + 1;
    for (const std::int64_t row : {first, second}) {
      for (const std::int64_t column : {first, second}) entries.push_back({row, column, 1.0});
    }
    entries.push_back({pair, second, 1.0});
    entries.push_back({second, pair, 1.0});
  }
  return from_entries(a.n + 2 * count, entries);
}

SparseMatrix adversarial_matrix(const std::string& family, std::uint64_t seed) {
  for (const NamedMatrix& named : adversarial_matrices(seed)) {
    if (named.name.rfind(family + ", seed", 0) == 0) return named.matrix;
  }
  throw std::invalid_argument("no family " + family);
}

namespace {

std::vector<Entry> random_entries(Random& random, std::int64_t n, std::int64_t count) {
  std::vector<Entry> entries;
  for (std::int64_t k = 0; k < count; ++k) {
    entries.push_back({random.integer(0, n), random.integer(0, n), random.entry()});
  }
  return entries;
}

// Rows permuted against columns, so that what was the diagonal lies anywhere.
SparseMatrix rows_permuted(const SparseMatrix& a, Random& random) {
  const std::vector<std::int64_t> row = random.permutation(a.n);
  std::vector<Entry> entries = entries_of(a);
  for (Entry& e : entries) e.row = row[e.row];
  return from_entries_summed(a.n, entries);
}

// Row i times 10^r_i, column j times 10^c_j, with exponents in [-most, most].
NamedMatrix graded(const std::string& name, const SparseMatrix& a, double most, Random& random) {
  NamedMatrix made{name, {}};
  std::vector<double> row = random.vector(a.n), column = random.vector(a.n);
  for (double& r : row) made.transposed_solution_sizes.push_back(1 / (r = std::pow(10.0, most * r)));
  for (double& c : column) made.solution_sizes.push_back(1 / (c = std::pow(10.0, most * c)));
  std::vector<Entry> entries = entries_of(a);
  for (Entry& e : entries) e.value *= row[e.row] * column[e.column];
  made.matrix = from_entries_summed(a.n, entries);
  return made;
}

// [ K  B^T ]   K diagonally dominant, each row of B with three unknowns of its own block, zeros stored in the
// [ B   0  ]   lower right corner where `explicit_zeros` says so.
SparseMatrix saddle_point(std::int64_t n, std::int64_t constraints, bool explicit_zeros, Random& random) {
  std::vector<Entry> entries =
      entries_of(random_diagonally_dominant(n, 3, static_cast<std::uint64_t>(random.integer(0, 1 << 30))));
  const std::int64_t share = n / constraints;
  for (std::int64_t c = 0; c < constraints; ++c) {
    for (std::int64_t k = 0; k < 3; ++k) {
      const std::int64_t unknown = c * share + k % share;
      const double value = (k == 0 ? 2.0 : 0.5) * random.entry() + (k == 0 ? 3.0 : 0.0);
      entries.push_back({n + c, unknown, value});
      entries.push_back({unknown, n + c, value});
    }
    if (explicit_zeros) entries.push_back({n + c, n + c, 0.0});
  }
  return from_entries_summed(n + constraints, entries);
}

SparseMatrix zero_diagonal(std::int64_t n, Random& random) {  // pairs (2k, 2k+1) joined by large entries
  std::vector<Entry> entries = random_entries(random, n, 3 * n);
  for (Entry& e : entries) {
    if (e.row == e.column) e.value = 0.0;
  }
  for (std::int64_t k = 0; k + 1 < n; k += 2) {
    entries.push_back({k, k + 1, 12.0});
    entries.push_back({k + 1, k, -11.0});
  }
  return from_entries_summed(n, entries);
}

SparseMatrix explicit_zeros(std::int64_t n, Random& random) {
  std::vector<Entry> entries =
      entries_of(random_diagonally_dominant(n, 3, static_cast<std::uint64_t>(random.integer(0, 1 << 30))));
  for (std::int64_t k = 0; k < 5 * n; ++k)
    entries.push_back({random.integer(0, n), random.integer(0, n), 0.0});
  return from_entries_summed(n, entries);
}

SparseMatrix block_triangular(std::int64_t blocks, std::int64_t width, Random& random) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < blocks * width; ++i) {
    const std::int64_t begin = i / width * width;
    for (std::int64_t j = begin; j < begin + width; ++j) {
      entries.push_back({i, j, random.entry() + (j - begin == (i + 1 - begin) % width ? 6.0 : 0.0)});
    }
    for (int k = 0; k < 3 && begin + width < blocks * width; ++k) {
      entries.push_back({i, random.integer(begin + width, blocks * width), random.entry()});
    }
  }
  return from_entries_summed(blocks * width, entries);
}

SparseMatrix dense_rows(std::int64_t n, std::int64_t rows, Random& random) {
  std::vector<Entry> entries =
      entries_of(random_diagonally_dominant(n, 2, static_cast<std::uint64_t>(random.integer(0, 1 << 30))));
  for (std::int64_t k = 0; k < rows; ++k) {
    const std::int64_t row = random.integer(0, n), column = random.integer(0, n);
    for (std::int64_t j = 0; j < n; ++j) {
      entries.push_back({row, j, random.entry()});
      if (k % 2 == 0) entries.push_back({j, column, random.entry()});
    }
    entries.push_back({row, row, 2.0 * static_cast<double>(n)});
    if (k % 2 == 0) entries.push_back({column, column, 2.0 * static_cast<double>(n)});
  }
  return from_entries_summed(n, entries);
}

SparseMatrix disconnected(Random& random) {  // grids of different sizes, single unknowns between them
  std::vector<Entry> entries;
  std::int64_t n = 0;
  for (const std::int64_t m : {7, 1, 12, 1, 1, 3, 9}) {
    for (const Entry& e : entries_of(grid_2d(m, m))) entries.push_back({n + e.row, n + e.column, e.value});
    n += m * m;
  }
  return renumbered(from_entries_summed(n, entries), random);
}

SparseMatrix permuted_identity(std::int64_t n, Random& random) {
  const std::vector<std::int64_t> column = random.permutation(n);
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) entries.push_back({i, column[i], random.entry()});
  return from_entries_summed(n, entries);
}

}  // namespace

std::vector<NamedMatrix> adversarial_matrices(std::uint64_t seed) {
  Random random(seed);
  std::vector<NamedMatrix> matrices;
  const auto add = [&](const std::string& name, SparseMatrix matrix) {
    matrices.push_back({name + ", seed " + std::to_string(seed), std::move(matrix)});
  };
  add("grid", grid_2d(random.integer(2, 40), random.integer(2, 40)));
  add("random", random_diagonally_dominant(random.integer(5, 600), 4, seed));
  add("rows permuted", rows_permuted(random_diagonally_dominant(random.integer(5, 400), 4, seed), random));
  add("zero diagonal", zero_diagonal(2 * random.integer(2, 150), random));
  add("saddle point", saddle_point(200, random.integer(5, 60), false, random));
  add("saddle point with zeros", saddle_point(200, random.integer(5, 60), true, random));
  add("saddle point renumbered", renumbered(saddle_point(150, random.integer(5, 50), true, random), random));
  const std::string of_seed = ", seed " + std::to_string(seed);
  matrices.push_back(graded("graded 1e20" + of_seed, random_diagonally_dominant(300, 4, seed), 10, random));
  matrices.push_back(graded("graded 1e300" + of_seed, random_diagonally_dominant(200, 3, seed), 150, random));
  matrices.push_back(graded("graded and permuted" + of_seed,
                            rows_permuted(random_diagonally_dominant(200, 3, seed), random), 100, random));
  matrices.push_back(graded("graded saddle point" + of_seed, saddle_point(150, 40, true, random), 8, random));
  add("explicit zeros", explicit_zeros(random.integer(5, 300), random));
  add("block triangular", block_triangular(random.integer(2, 20), random.integer(1, 15), random));
  add("block triangular, permuted", rows_permuted(block_triangular(12, 9, random), random));
  add("arrow", arrow(random.integer(10, 400), 3));
  add("arrow renumbered", renumbered(arrow(random.integer(10, 400), 5), random));
  add("dense rows", dense_rows(random.integer(20, 400), 4, random));
  add("disconnected", disconnected(random));
  add("tridiagonal", tridiagonal(random.integer(2, 2000)));
  add("permuted identity", permuted_identity(random.integer(1, 500), random));
  add("one unknown", from_entries(1, {{0, 0, random.entry()}}));
  return matrices;
}

}  // namespace mfs::test
