#include "test/adversarial/hard_matrices.hpp"

#include <cmath>
#include <iterator>

#include "test/reference/random.hpp"

namespace mfs::test {

namespace {

double small_integer(Random& random) {
  const std::int64_t value = random.integer(-4, 5);
  return static_cast<double>(value == 0 ? 1 : value);
}

// Stiffness of a chain of masses with extra springs; entries are small integers.
std::vector<Entry> spring_chain(std::int64_t n, Random& random) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, 6.0});
    if (i > 0) entries.push_back({i, i - 1, -1.0});
    if (i + 1 < n) entries.push_back({i, i + 1, -2.0});
    const std::int64_t j = random.integer(0, n);
    if (j != i) entries.push_back({i, j, -1.0});
  }
  return entries;
}

void add_constraint(std::vector<Entry>& entries, std::int64_t row, const std::vector<Entry>& terms) {
  for (const Entry& term : terms) {
    entries.push_back({row, term.column, term.value});
    entries.push_back({term.column, row, term.value});
  }
}

// Saddle point whose last constraint is a copy of the first (combined = false) or the sum of the first two.
SparseMatrix redundant_constraints(bool combined, Random& random) {
  const std::int64_t n = random.integer(12, 120), constraints = random.integer(3, 8);
  std::vector<Entry> entries = spring_chain(n, random);
  std::vector<std::vector<Entry>> rows;
  for (std::int64_t c = 0; c + 1 < constraints; ++c) {
    std::vector<Entry> terms;
    for (int k = 0; k < 3; ++k) terms.push_back({0, (c * 3 + k) % n, small_integer(random)});
    rows.push_back(terms);
  }
  std::vector<Entry> last = rows[0];
  if (combined) last.insert(last.end(), rows[1].begin(), rows[1].end());
  rows.push_back(last);
  for (std::int64_t c = 0; c < constraints; ++c) add_constraint(entries, n + c, rows[c]);
  return from_entries_summed(n + constraints, entries);
}

// Small integers with row `n - 1` a copy of row 0, rows then permuted; `change` is added to one entry of the
// copy.
SparseMatrix copied_row(double change, Random& random) {
  const std::int64_t n = random.integer(4, 150);
  std::vector<Entry> entries;
  std::vector<Entry> first;
  for (std::int64_t i = 0; i + 1 < n; ++i) {
    std::vector<Entry> row = {{i, i, 8.0},
                              {i, (i + 1) % n, small_integer(random)},
                              {i, random.integer(0, n), small_integer(random)}};
    if (i == 0) first = row;
    entries.insert(entries.end(), row.begin(), row.end());
  }
  for (Entry e : first) {
    e.row = n - 1;
    entries.push_back(e);
  }
  if (change != 0) entries.push_back({n - 1, n - 1, change});
  const std::vector<std::int64_t> place = random.permutation(n);
  for (Entry& e : entries) e.row = place[e.row];
  return from_entries_summed(n, entries);
}

// Graph Laplacian: every row sums to zero.
SparseMatrix floating_network(Random& random) {
  const std::int64_t n = random.integer(3, 200);
  std::vector<Entry> entries;
  const auto join = [&](std::int64_t i, std::int64_t j) {
    const double g = std::fabs(small_integer(random));
    for (const Entry& e : {Entry{i, i, g}, Entry{j, j, g}, Entry{i, j, -g}, Entry{j, i, -g}})
      entries.push_back(e);
  };
  for (std::int64_t i = 1; i < n; ++i) join(i, random.integer(0, i));
  for (std::int64_t k = 0; k < n; ++k) {
    const std::int64_t i = random.integer(0, n), j = random.integer(0, n);
    if (i != j) join(i, j);
  }
  return from_entries_summed(n, entries);
}

SparseMatrix uniform_entries(double decades, Random& random) {
  const std::int64_t n = random.integer(2, 180), per_row = random.integer(2, 7);
  std::vector<Entry> entries;
  const std::vector<std::int64_t> place = random.permutation(n);
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, place[i], random.entry() * std::pow(10.0, decades * random.entry())});
    for (std::int64_t k = 1; k < per_row; ++k) {
      entries.push_back({i, random.integer(0, n), random.entry() * std::pow(10.0, decades * random.entry())});
    }
  }
  return from_entries_summed(n, entries);
}

// Index-3 iteration matrix: rows of momentum with stiffness 1e12 h^2, of kinematics with h, and constraints
// with a zero block, each scaled as an integrator leaves it.
SparseMatrix integrator_jacobian(Random& random) {
  const std::int64_t bodies = random.integer(5, 60), n = 2 * bodies, constraints = random.integer(1, bodies);
  const double h = std::pow(10.0, -6 * random.unit());
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < bodies; ++i) {
    entries.push_back({i, i, 1.0 + random.unit()});
    const std::int64_t j = random.integer(0, bodies);
    const double stiffness = 1e12 * h * h * random.unit();
    entries.push_back({i, bodies + i, stiffness});
    if (i != j) entries.push_back({i, bodies + j, -0.5 * stiffness});
    entries.push_back({bodies + i, i, -h});
    entries.push_back({bodies + i, bodies + i, 1.0});
  }
  for (std::int64_t c = 0; c < constraints; ++c) {
    for (int k = 0; k < 2; ++k) {
      const std::int64_t body = (c + k * (constraints + 1)) % bodies;
      const double value = random.entry();
      entries.push_back({n + c, bodies + body, value / (h * h)});
      entries.push_back({body, n + c, value});
    }
  }
  return from_entries_summed(n + constraints, entries);
}

SparseMatrix structurally_singular(Random& random) {
  const std::int64_t n = random.integer(3, 120), thin = random.integer(2, 4);
  std::vector<Entry> entries = spring_chain(n, random);
  // `thin` rows that have entries in fewer columns than they are.
  std::vector<Entry> kept;
  for (const Entry& e : entries) {
    if (e.row >= thin || e.column < thin - 1) kept.push_back(e);
  }
  return from_entries_summed(n, kept);
}

// Without zeros; entry(i, j) is asked row by row.
template <class EntryAt>
SparseMatrix full(std::int64_t n, const EntryAt& entry) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    for (std::int64_t j = 0; j < n; ++j) entries.push_back({i, j, entry(i, j)});
  }
  return from_entries(n, entries);
}

// Fronts of several tiles, whose pivots have to be searched.
SparseMatrix dense(double decades, Random& random) {
  return full(random.integer(100, 320), [&](std::int64_t, std::int64_t) {
    return random.entry() * std::pow(10.0, decades * random.entry());
  });
}

// Of small integers, one row the sum of two others.
SparseMatrix dense_singular(Random& random) {
  const std::int64_t n = random.integer(100, 320);
  std::vector<std::vector<double>> rows(n, std::vector<double>(n));
  for (std::vector<double>& row : rows) {
    for (double& entry : row) entry = small_integer(random);
  }
  const std::vector<std::int64_t> place = random.permutation(n);
  for (std::int64_t j = 0; j < n; ++j) rows[place[0]][j] = rows[place[1]][j] + rows[place[2]][j];
  return full(n, [&](std::int64_t i, std::int64_t j) { return rows[i][j]; });
}

// Partial pivoting lets it grow by 2^(n - 1), though it is well conditioned (Wilkinson, The Algebraic
// Eigenvalue Problem, 1965, p. 212): ones on the diagonal and in the last column, -1 below; permuted.
SparseMatrix growing(Random& random) {
  const std::int64_t n = random.integer(10, 200);
  const std::vector<std::int64_t> row = random.permutation(n), column = random.permutation(n);
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    for (std::int64_t j = 0; j < i; ++j) entries.push_back({row[i], column[j], -1.0});
    entries.push_back({row[i], column[i], 1.0});
    if (i < n - 1) entries.push_back({row[i], column[n - 1], 1.0});
  }
  return from_entries_summed(n, entries);
}

SparseMatrix hilbert(Random& random) {
  return full(random.integer(2, 15),
              [](std::int64_t i, std::int64_t j) { return 1.0 / static_cast<double>(i + j + 1); });
}

}  // namespace

HardMatrix hard_matrix(std::uint64_t seed) {
  Random random(seed * 0x9E3779B97F4A7C15u + 1);
  const std::string of_seed = ", seed " + std::to_string(seed);
  const auto made = [&](const std::string& name, SparseMatrix matrix, bool singular = false) {
    return HardMatrix{name + of_seed, std::move(matrix), singular};
  };
  switch (seed % 20) {
    case 0:
      return made("redundant constraint", redundant_constraints(false, random), true);
    case 1:
      return made("dependent constraints", redundant_constraints(true, random), true);
    case 2:
      return made("copied row", copied_row(0, random), true);
    case 3:
      return made("floating network", floating_network(random), true);
    case 4:
      return made("structurally singular", structurally_singular(random), true);
    case 5:
      return made("nearly copied row", copied_row(std::pow(10.0, -18 * random.unit()), random));
    case 6:
      return made("uniform entries", uniform_entries(0, random));
    case 7:
      return made("entries of 16 decades", uniform_entries(8, random));
    case 8:
      return made("entries of 600 decades", uniform_entries(290, random));
    case 9:
      return made("integrator", integrator_jacobian(random));
    case 10:
      return made("Hilbert", hilbert(random));
    case 11:
      return made("dense", dense(random.integer(0, 4), random));
    case 12:
      return made("dense, singular", dense_singular(random), true);
    case 13:
      return made("growing", growing(random));
    default:
      break;
  }
  std::vector<NamedMatrix> regular = adversarial_matrices(seed);
  NamedMatrix& chosen =
      regular[static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(regular.size())))];
  return {chosen.name, std::move(chosen.matrix), false, std::move(chosen.solution_sizes)};
}

}  // namespace mfs::test
