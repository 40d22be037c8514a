#include "test/adversarial/engineering_matrices.hpp"

#include <array>
#include <cmath>

#include "test/reference/random.hpp"

namespace mfs::test {

namespace {

using Index = std::int64_t;
using Entries = std::vector<Entry>;

void add_symmetric(Entries& entries, Index i, Index j, double value) {
  entries.push_back({i, j, value});
  if (i != j) entries.push_back({j, i, value});
}

/// Row-major dense blocks, as small as nodes are.
using Block = std::vector<std::vector<double>>;

/// An orthogonal matrix: the product of reflections of random vectors.
Block turned_axes(std::size_t n, Random& random) {
  Block q(n, std::vector<double>(n, 0.0));
  for (std::size_t i = 0; i < n; ++i) q[i][i] = 1;
  for (int k = 0; k < 3; ++k) {
    const std::vector<double> v = random.vector(static_cast<Index>(n));
    double square = 0;
    for (const double entry : v) square += entry * entry;
    for (std::vector<double>& row : q) {
      double product = 0;
      for (std::size_t j = 0; j < n; ++j) product += row[j] * v[j];
      for (std::size_t j = 0; j < n; ++j) row[j] -= 2 * product / square * v[j];
    }
  }
  return q;
}

/// Nodes of a square grid, joined by springs whose stiffness differs by axis; each node's axes are turned.
SparseMatrix shell(Random& random) {
  constexpr std::size_t kUnknowns = 6;
  const Index side = random.integer(4, 11);
  const double membrane = std::pow(10.0, 6 * random.unit()), drilling = std::pow(10.0, -8 * random.unit());
  const std::array<double, kUnknowns> stiffness{membrane, membrane, 1, 1, 1, drilling};
  std::vector<Block> axes;
  for (Index i = 0; i < side * side; ++i) axes.push_back(turned_axes(kUnknowns, random));
  Entries entries;
  const auto add = [&](Index a, Index b, double factor) {
    for (std::size_t i = 0; i < kUnknowns; ++i) {
      for (std::size_t j = 0; j < kUnknowns; ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < kUnknowns; ++k) sum += axes[a][i][k] * stiffness[k] * axes[b][j][k];
        entries.push_back({6 * a + static_cast<Index>(i), 6 * b + static_cast<Index>(j), factor * sum});
      }
    }
  };
  const auto join = [&](Index a, Index b) {
    const double factor = 0.5 + random.unit();
    add(a, a, factor);
    add(b, b, factor);
    add(a, b, -factor);
    add(b, a, -factor);
  };
  for (Index i = 0; i < side * side; ++i) {
    add(i, i, i < side ? 10 : 0.1);
    if (i % side > 0) join(i, i - 1);
    if (i >= side) join(i, i - side);
  }
  return from_entries_summed(6 * side * side, entries);
}

/// Plane strain on squares of four nodes, clamped at one side, two points of quadrature each way.
SparseMatrix nearly_incompressible(Random& random) {
  const Index side = random.integer(4, 16);
  const double nu = 0.5 - std::pow(10.0, -2 - 8 * random.unit());
  const double lambda = nu / ((1 + nu) * (1 - 2 * nu)), mu = 0.5 / (1 + nu), point = 0.5 / std::sqrt(3.0);
  std::array<std::array<double, 8>, 8> element{};
  for (const double x : {0.5 - point, 0.5 + point}) {
    for (const double y : {0.5 - point, 0.5 + point}) {
      const std::array<double, 4> dx{-(1 - y), 1 - y, -y, y}, dy{-(1 - x), -x, 1 - x, x};
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
          element[2 * a][2 * b] += 0.25 * ((lambda + 2 * mu) * dx[a] * dx[b] + mu * dy[a] * dy[b]);
          element[2 * a + 1][2 * b + 1] += 0.25 * ((lambda + 2 * mu) * dy[a] * dy[b] + mu * dx[a] * dx[b]);
          element[2 * a][2 * b + 1] += 0.25 * (lambda * dx[a] * dy[b] + mu * dy[a] * dx[b]);
          element[2 * a + 1][2 * b] += 0.25 * (lambda * dy[a] * dx[b] + mu * dx[a] * dy[b]);
        }
      }
    }
  }
  Entries entries;
  const Index clamped = 2 * (side + 1);  // the first row of nodes
  for (Index i = 0; i < side * side; ++i) {
    const Index corner = i / side * (side + 1) + i % side;
    const std::array<Index, 4> node{corner, corner + 1, corner + side + 1, corner + side + 2};
    for (std::size_t a = 0; a < 8; ++a) {
      for (std::size_t b = 0; b < 8; ++b) {
        const Index row = 2 * node[a / 2] + static_cast<Index>(a % 2) - clamped;
        const Index column = 2 * node[b / 2] + static_cast<Index>(b % 2) - clamped;
        if (row >= 0 && column >= 0) entries.push_back({row, column, element[a][b]});
      }
    }
  }
  return from_entries_summed(2 * side * (side + 1), entries);
}

/// Fluxes through the sides of squares and pressures in them, lowest order of Raviart and Thomas.
SparseMatrix darcy(Random& random) {
  const Index side = random.integer(4, 16), fluxes = side * (side + 1);
  const double decades = 8 * random.unit();
  Entries entries;
  for (Index i = 0; i < side; ++i) {
    for (Index j = 0; j < side; ++j) {
      const double resistance = std::pow(10.0, decades * random.entry());
      const Index pressure = 2 * fluxes + i * side + j;
      const std::array<std::array<Index, 2>, 2> sides{
          {{i * (side + 1) + j, i * (side + 1) + j + 1},
           {fluxes + j * (side + 1) + i, fluxes + j * (side + 1) + i + 1}}};
      for (const std::array<Index, 2>& two : sides) {
        for (const Index flux : two) {
          entries.push_back({flux, flux, resistance / 3});
          add_symmetric(entries, flux, pressure, flux == two[0] ? -1.0 : 1.0);
        }
        add_symmetric(entries, two[0], two[1], resistance / 6);
      }
    }
  }
  return from_entries_summed(2 * fluxes + side * side, entries);
}

/// The last steps of an interior point method: half of the variables at their bounds.
SparseMatrix interior_point(Random& random) {
  const Index n = random.integer(40, 400), constraints = n / 3;
  const double mu = std::pow(10.0, -5 - 5 * random.unit());
  Entries entries;
  for (Index i = 0; i < n; ++i) {
    const double free = 0.1 + 2 * random.unit(), bound = mu / (0.1 + 2 * random.unit());
    const double x = random.chance(0.5) ? bound : free;
    entries.push_back({i, i, mu / (x * x) + (random.chance(0.3) ? random.unit() : 0.0)});
  }
  const std::vector<Index> own = random.permutation(n);
  for (Index c = 0; c < constraints; ++c) {
    add_symmetric(entries, n + c, own[c], 1 + random.unit());
    for (int k = 0; k < 3; ++k) add_symmetric(entries, n + c, random.integer(0, n), random.entry());
  }
  return from_entries_summed(n + constraints, entries);
}

SparseMatrix random_penalties(Random& random) {
  const Index side = random.integer(6, 24);
  return penalties(side, std::pow(10.0, 6 + 6 * random.unit()), random);
}

/// Rows and columns graded over 2 x 140 decades each, one after the other or at random.
HardMatrix graded(Random& random) {
  const Index n = random.integer(20, 300);
  const double decades = 60 + 80 * random.unit();
  const std::vector<Index> place = random.permutation(n);
  const auto size = [&](Index i) {
    return std::pow(10.0, decades * (2 * static_cast<double>(i) / static_cast<double>(n - 1) - 1));
  };
  HardMatrix hard;
  Entries entries;
  for (Index i = 0; i < n; ++i) {
    const auto add = [&](Index j, double value) {
      entries.push_back({i, j, value * size(i) * size(place[j])});
    };
    add(i, 4 + random.entry());
    for (int k = 0; k < 3; ++k) add(random.integer(0, n), random.entry());
    hard.solution_sizes.push_back(1 / size(place[i]));
  }
  hard.matrix = from_entries_summed(n, entries);
  return hard;
}

/// Steady flow around a vortex, linearized, on staggered squares; one pressure is given.
SparseMatrix oseen(Random& random) {
  const Index side = random.integer(4, 16), across = (side - 1) * side, pressures = 2 * across;
  const double h = 1.0 / static_cast<double>(side), viscosity = std::pow(10.0, -6 * random.unit());
  Entries entries;
  for (int axis = 0; axis < 2; ++axis) {
    // Velocity (i, j) of this axis lies between cells i and i + 1 along it, in row j across it.
    const auto velocity = [&](Index i, Index j) { return axis * across + i * side + j; };
    const auto pressure = [&](Index i, Index j) {
      return pressures + (axis == 0 ? i * side + j : j * side + i);
    };
    for (Index i = 0; i < side - 1; ++i) {
      for (Index j = 0; j < side; ++j) {
        const Index row = velocity(i, j);
        const double along = std::sin(3.14 * h * static_cast<double>(i + 1)), turn = axis == 0 ? 1 : -1;
        const double wind = turn * along / (2 * h), diffusion = viscosity / (h * h);
        entries.push_back({row, row, 4 * diffusion});
        if (i > 0) entries.push_back({row, velocity(i - 1, j), -diffusion - wind});
        if (i < side - 2) entries.push_back({row, velocity(i + 1, j), -diffusion + wind});
        if (j > 0) entries.push_back({row, velocity(i, j - 1), -diffusion + wind / 2});
        if (j < side - 1) entries.push_back({row, velocity(i, j + 1), -diffusion - wind / 2});
        for (const Index cell : {pressure(i, j), pressure(i + 1, j)}) {
          const double value = cell == pressure(i, j) ? -1 / h : 1 / h;
          entries.push_back({row, cell, value});
          if (cell != pressures) entries.push_back({cell, row, value});
        }
      }
    }
  }
  entries.push_back({pressures, pressures, 1.0});
  return from_entries_summed(pressures + side * side, entries);
}

/// Bodies of a plane lattice, three unknowns each, joined to a tree by joints that hold two places and an
/// angle. One joint more closes a loop whose constraints depend on the others.
SparseMatrix lattice(bool redundant, Random& random) {
  const Index side = random.integer(3, 9), bodies = side * side, turn = 2;
  const double step = std::pow(10.0, -4 * random.unit());
  Entries entries;
  for (Index i = 0; i < bodies; ++i) {
    for (Index k = 0; k < 3; ++k)
      entries.push_back({3 * i + k, 3 * i + k, std::ldexp(k == turn ? 1.0 : 64.0, -2 * std::ilogb(step))});
  }
  Index row = 3 * bodies;
  // A joint half way between the two: both have its point in common, and the same angle.
  const auto join = [&](Index one, Index other, double x, double y) {
    for (const Index body : {one, other}) {
      const double sign = body == one ? 1 : -1;
      add_symmetric(entries, row, 3 * body, sign);
      add_symmetric(entries, row, 3 * body + turn, -y / 2);
      add_symmetric(entries, row + 1, 3 * body + 1, sign);
      add_symmetric(entries, row + 1, 3 * body + turn, x / 2);
      add_symmetric(entries, row + 2, 3 * body + turn, sign);
    }
    row += 3;
  };
  const Index closing = redundant ? random.integer(1, side) + side * random.integer(1, side) : -1;
  for (Index i = 0; i < bodies; ++i) {
    const bool first_column = i % side == 0;
    if (!first_column) join(i - 1, i, 1, 0);
    if (i >= side && (first_column || i == closing)) join(i - side, i, 0, 1);
  }
  return from_entries_summed(row, entries);
}

}  // namespace

SparseMatrix penalties(std::int64_t side, double penalty, Random& random) {
  const Index n = side * side;
  Entries entries;
  for (Index i = 0; i < n; ++i) {
    entries.push_back({i, i, 4.0});
    if (i % side > 0) add_symmetric(entries, i, i - 1, -1.0);
    if (i >= side) add_symmetric(entries, i, i - side, -1.0);
  }
  for (Index c = 0; c < n / 4; ++c) {
    const Index first = random.integer(0, n - side);
    const std::array<Index, 3> place{first, first + 1, first + side};
    constexpr std::array<double, 3> kFactor{1, -0.5, -0.5};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) entries.push_back({place[i], place[j], penalty * kFactor[i] * kFactor[j]});
    }
  }
  return from_entries_summed(n, entries);
}

SparseMatrix curl_curl(std::int64_t side, double mass) {
  const Index nodes = side + 1, edges = nodes * nodes * nodes;
  std::vector<Index> number(static_cast<std::size_t>(3 * edges), -1);
  Index n = 0;
  // An edge is its first node and its direction.
  const auto edge = [&](std::array<Index, 3> at, int axis) {
    Index& known = number[static_cast<std::size_t>(axis * edges + (at[0] * nodes + at[1]) * nodes + at[2])];
    if (known < 0) known = n++;
    return known;
  };
  Entries entries;
  for (Index node = 0; node < edges; ++node) {
    const std::array<Index, 3> at{node / (nodes * nodes), node / nodes % nodes, node % nodes};
    for (int axis = 0; axis < 3; ++axis) {
      const int one = (axis + 1) % 3, other = (axis + 2) % 3;
      if (at[one] == side || at[other] == side) continue;
      std::array<Index, 3> beside = at, above = at;
      ++beside[one];
      ++above[other];
      const std::array<Index, 4> around{edge(at, one), edge(beside, other), edge(above, one),
                                        edge(at, other)};
      constexpr std::array<double, 4> kSign{1, 1, -1, -1};
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) entries.push_back({around[i], around[j], kSign[i] * kSign[j]});
      }
    }
  }
  for (Index i = 0; i < n && mass > 0; ++i) entries.push_back({i, i, mass});
  return from_entries_summed(n, entries);
}

/// Multiple shooting of a linear system of 2 or 4 equations whose solutions grow and decay, between periodic
/// boundary conditions, by Taylor's series of the exponential (Wright 1993): exchanges of rows in the order
/// of time let entries grow as its solutions do.
SparseMatrix multiple_shooting(Random& random) {
  const std::size_t m = random.unit() < 0.5 ? 2 : 4;
  const Index steps = random.integer(60, 500);
  const double h = 0.1 + 0.3 * random.unit();
  Block system(m, std::vector<double>(m)), step(m, std::vector<double>(m, 0.0));
  for (std::vector<double>& row : system) row = random.vector(static_cast<Index>(m));
  system[0][0] += 1;
  system[1][1] -= 1;
  Block term = step;
  for (std::size_t i = 0; i < m; ++i) step[i][i] = term[i][i] = 1;
  for (int power = 1; power < 20; ++power) {
    Block next(m, std::vector<double>(m, 0.0));
    for (std::size_t i = 0; i < m; ++i) {
      for (std::size_t j = 0; j < m; ++j) {
        for (std::size_t k = 0; k < m; ++k) next[i][j] += term[i][k] * system[k][j] * h / power;
        step[i][j] += next[i][j];
      }
    }
    term = next;
  }
  const auto size = static_cast<Index>(m);
  Entries entries;
  for (Index i = 0; i < size; ++i) {
    entries.push_back({i, i, 1.0});
    entries.push_back({i, steps * size + i, 1.0});
    for (Index t = 0; t < steps; ++t) {
      entries.push_back({(t + 1) * size + i, (t + 1) * size + i, 1.0});
      for (Index j = 0; j < size; ++j) entries.push_back({(t + 1) * size + i, t * size + j, -step[i][j]});
    }
  }
  return from_entries(size * (steps + 1), entries);
}

HardMatrix engineering_matrix(std::uint64_t seed) {
  Random random(seed * 0xD1B54A32D192ED03u + 1);
  HardMatrix made;
  const auto take = [&](const char* name, SparseMatrix matrix, bool singular = false) {
    made = {name, std::move(matrix), singular};
  };
  switch (seed % 12 == 11 ? 11 : seed % 11) {
    case 0:
      take("shell", shell(random));
      break;
    case 1:
      take("nearly incompressible", nearly_incompressible(random));
      break;
    case 2: {
      const Index side = random.integer(3, 9);
      take("curl-curl", curl_curl(side, std::pow(10.0, -6 - 6 * random.unit())));
      break;
    }
    case 3:
      take("curl-curl, singular", curl_curl(random.integer(3, 6), 0), true);
      break;
    case 4:
      take("Darcy", darcy(random));
      break;
    case 5:
      take("interior point", interior_point(random));
      break;
    case 6:
      take("penalties", random_penalties(random));
      break;
    case 7:
      made = graded(random);
      made.name = "graded";
      break;
    case 8:
      take("Oseen", oseen(random));
      break;
    case 9:
      take("lattice", lattice(false, random));
      break;
    case 11:
      take(kGrowing, multiple_shooting(random));
      break;
    default:
      take("lattice, redundant", lattice(true, random), true);
  }
  made.name += ", seed " + std::to_string(seed);
  return made;
}

}  // namespace mfs::test
