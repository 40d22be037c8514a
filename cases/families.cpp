#include "cases/families.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <mfs/error.hpp>

#include "parts/comma_list.hpp"

namespace mfs::cases {
namespace {

using Contribution = std::pair<int, double>;  // column and value
using Contributions = std::vector<Contribution>;

// Sorts by column and adds up what belongs together, first to last.
void merge(Contributions& row) {
  std::sort(row.begin(), row.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (kept && row[kept - 1].first == row[k].first)
      row[kept - 1].second += row[k].second;
    else
      row[kept++] = row[k];
  }
  row.resize(kept);
}

// Takes finished rows, first to last.
class Builder {
 public:
  explicit Builder(std::int64_t n) {
    matrix_.n = n;
    matrix_.offsets.reserve(static_cast<std::size_t>(n) + 1);
    matrix_.offsets.push_back(0);
  }
  void reserve(std::int64_t entries) {
    matrix_.column_indices.reserve(static_cast<std::size_t>(entries));
    matrix_.values.reserve(static_cast<std::size_t>(entries));
  }
  /// `row` is merged; its columns are shifted.
  void add(const Contributions& row, int shift = 0) {
    for (const auto& [column, value] : row) {
      matrix_.column_indices.push_back(column + shift);
      matrix_.values.push_back(value);
    }
    matrix_.offsets.push_back(static_cast<std::int64_t>(matrix_.values.size()));
  }
  FamilyMatrix take() { return std::move(matrix_); }

 private:
  FamilyMatrix matrix_;
};

// ---- elasticity ----

constexpr int kDof = 3;             // unknowns per node
constexpr int kElement = 8 * kDof;  // unknowns per element

// Stiffness of a unit hexahedron, linear elasticity, E = 1, nu = 0.3, 2 x 2 x 2 Gauss points, row-major.
std::array<double, kElement * kElement> element_stiffness() {
  std::array<double, kElement * kElement> stiffness{};
  const double E = 1, nu = 0.3, lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  const double g = 1 / std::sqrt(3.0);
  const auto sign = [](int node, int axis) { return (node >> axis & 1) ? 1 : -1; };
  for (int q = 0; q < 8; ++q) {
    double d[8][3];  // gradients of the shape functions in the Gauss point q
    for (int a = 0; a < 8; ++a)
      for (int c = 0; c < 3; ++c) {
        double v = sign(a, c) / 8.0;
        for (int e = 0; e < 3; ++e)
          if (e != c) v *= 1 + sign(a, e) * (g * sign(q, e));
        d[a][c] = v * 2;  // dx/dxi = 1/2
      }
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) {
        const double dot = d[a][0] * d[b][0] + d[a][1] * d[b][1] + d[a][2] * d[b][2];
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j)
            stiffness[static_cast<std::size_t>((kDof * a + i) * kElement + kDof * b + j)] +=
                (lambda * d[a][i] * d[b][j] + mu * d[a][j] * d[b][i] + (i == j ? mu * dot : 0)) / 8;
      }
  }
  return stiffness;
}

struct Grid {
  int nx, ny, nz;
  int node(int i, int j, int k) const { return (k * ny + j) * nx + i; }
};

// Rows of the elastic body: node (i, j, k) and unknown c give row 3 * node + c. The face i = 0 is on stiff
// springs, every diagonal entry is shifted by beta, `gyro` adds a skew-symmetric part.
class ElasticRows {
 public:
  ElasticRows(Grid grid, double beta, double gyro)
      : grid_(grid), beta_(beta), gyro_(gyro), stiffness_(element_stiffness()) {}

  /// What a node's row is made of depends on where the node lies: at the low or high end along each axis.
  static constexpr int kPlaces = 64;
  int place(int i, int j, int k) const {
    const auto ends = [](int x, int n) { return (x == 0 ? 1 : 0) + (x == n - 1 ? 2 : 0); };
    return ends(i, grid_.nx) + 4 * ends(j, grid_.ny) + 16 * ends(k, grid_.nz);
  }

  /// The contributions to row (node, c), columns relative to 3 * node: element by element, then the diagonal.
  Contributions contributions(int i, int j, int k, int c) const {
    Contributions row;
    row.reserve(8 * kElement + 1);
    for (int ek = k - 1; ek <= k; ++ek)
      for (int ej = j - 1; ej <= j; ++ej)
        for (int ei = i - 1; ei <= i; ++ei) {
          const bool inside =
              ei >= 0 && ei + 1 < grid_.nx && ej >= 0 && ej + 1 < grid_.ny && ek >= 0 && ek + 1 < grid_.nz;
          if (inside) add_element(row, {i - ei, j - ej, k - ek}, c);
        }
    row.push_back({c, beta_ + (i == 0 ? 10.0 : 0.0)});
    return row;
  }

 private:
  // The element in which our node has the local coordinates `own` (0 or 1 along each axis).
  void add_element(Contributions& row, const std::array<int, 3>& own, int p) const {
    const int a = own[0] + 2 * own[1] + 4 * own[2];
    for (int b = 0; b < 8; ++b) {
      const int away = grid_.node((b & 1) - own[0], (b >> 1 & 1) - own[1], (b >> 2) - own[2]);
      for (int q = 0; q < kDof; ++q) {
        const int side = away > 0 ? 1 : away < 0 ? -1 : (p < q ? 1 : p > q ? -1 : 0);
        const double g = gyro_ == 0 ? 0 : gyro_ * side / 64.0;
        row.push_back({kDof * away + q,
                       stiffness_[static_cast<std::size_t>((kDof * a + p) * kElement + kDof * b + q)] + g});
      }
    }
  }

  Grid grid_;
  double beta_, gyro_;
  std::array<double, kElement * kElement> stiffness_;
};

// Adds the rows of an elastic body. `more(row)` lists contributions that this row has besides (columns
// absolute); most rows have none and are copies of one row per place.
template <class More>
void add_elastic_rows(Builder& builder, Grid grid, double beta, double gyro, const More& more) {
  const ElasticRows elastic(grid, beta, gyro);
  std::array<std::array<Contributions, kDof>, ElasticRows::kPlaces> merged;
  for (int k = 0; k < grid.nz; ++k)
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        const int first = kDof * grid.node(i, j, k);
        for (int c = 0; c < kDof; ++c) {
          const Contributions added = more(first + c);
          Contributions& alike =
              merged[static_cast<std::size_t>(elastic.place(i, j, k))][static_cast<std::size_t>(c)];
          if (!added.empty()) {
            Contributions row = elastic.contributions(i, j, k, c);
            for (auto& entry : row) entry.first += first;
            row.insert(row.end(), added.begin(), added.end());
            merge(row);
            builder.add(row);
            continue;
          }
          if (alike.empty()) merge(alike = elastic.contributions(i, j, k, c));
          builder.add(alike, first);
        }
      }
}

constexpr std::int64_t kElasticEntriesPerRow = 27 * kDof;

FamilyMatrix elastic_body(Grid grid) {
  const std::int64_t n = std::int64_t{kDof} * grid.nx * grid.ny * grid.nz;
  Builder builder(n);
  builder.reserve(n * kElasticEntriesPerRow);
  add_elastic_rows(builder, grid, 1e-4, 0, [](int) { return Contributions(); });
  return builder.take();
}

// [K + beta M + gyro, C^T; C, 0]: constraint c ties the unknowns of its kTied contributions, which go through
// all unknowns of the body in ascending order.
FamilyMatrix saddle_point(int m) {
  constexpr int kTied = 12;
  const int n = kDof * m * m * m, constraints = 3 * m * m;
  Contributions ties;  // unknown and value, constraint by constraint
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  const std::int64_t count = std::int64_t{constraints} * kTied;
  for (std::int64_t t = 0; t < count; ++t) {
    const double value = uniform(random) * ((t % kTied) & 1 ? -1 : 1);
    ties.push_back({static_cast<int>(t * n / count), value});
  }

  Builder builder(n + constraints);
  builder.reserve(n * kElasticEntriesPerRow + 2 * count + constraints);
  std::size_t next = 0;  // ties are sorted by unknown, and rows come in ascending order
  add_elastic_rows(builder, {m, m, m}, 1e-2, 1e-2, [&](int row) {
    Contributions added;
    for (; next < ties.size() && ties[next].first == row; ++next)
      added.push_back({n + static_cast<int>(next) / kTied, ties[next].second});
    return added;
  });
  for (int c = 0; c < constraints; ++c) {
    Contributions row(ties.begin() + std::ptrdiff_t{c} * kTied, ties.begin() + std::ptrdiff_t{c + 1} * kTied);
    row.push_back({n + c, 0.0});  // structural zero diagonal
    merge(row);
    builder.add(row);
  }
  return builder.take();
}

// ---- grids of one unknown per point ----

FamilyMatrix convection_diffusion(int m) {
  const int n = m * m * m, stride[3] = {1, m, m * m};
  const double peclet = 50;
  Builder builder(n);
  builder.reserve(7 * std::int64_t{n});
  Contributions row;
  for (int r = 0; r < n; ++r) {
    const int x[3] = {r % m, r / m % m, r / (m * m)};
    const double velocity[3] = {std::sin(0.1 * x[1]), std::cos(0.1 * x[2]), 0.5};
    double diagonal = 0;
    row.clear();
    for (int c = 0; c < 3; ++c) {
      const double low = 1 + peclet / m * std::max(velocity[c], 0.0);
      const double high = 1 + peclet / m * std::max(-velocity[c], 0.0);
      diagonal += low + high;
      if (x[c] > 0) row.push_back({r - stride[c], -low});
      if (x[c] < m - 1) row.push_back({r + stride[c], -high});
    }
    row.push_back({r, diagonal});
    merge(row);
    builder.add(row);
  }
  return builder.take();
}

FamilyMatrix laplacian(int m) {
  const int n = m * m;
  Builder builder(n);
  builder.reserve(5 * std::int64_t{n});
  Contributions row;
  for (int r = 0; r < n; ++r) {
    const int i = r % m, j = r / m;
    row.clear();
    if (j > 0) row.push_back({r - m, -1});
    if (i > 0) row.push_back({r - 1, -1});
    row.push_back({r, 4.0});
    if (i < m - 1) row.push_back({r + 1, -1});
    if (j < m - 1) row.push_back({r + m, -1});
    builder.add(row);
  }
  return builder.take();
}

// ---- circuit ----

struct Element {
  int row, column;
  double value;
};

// All contributions in the order in which the random numbers make them; many go to rows other than the one
// that is being made.
std::vector<Element> circuit_elements(int n) {
  std::vector<Element> elements;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < n; ++i) {
    double diagonal = 1e-3;
    const int degree = 2 + (uniform(random) < 0.02 ? 30 : 0);
    for (int t = 0; t < degree; ++t) {
      const bool near = uniform(random) < 0.85;
      const int j = near ? std::clamp(i + static_cast<int>((uniform(random) - 0.5) * 60), 0, n - 1)
                         : static_cast<int>(n * std::pow(uniform(random), 3));
      if (j == i) continue;
      const double g = std::pow(10, 4 * uniform(random) - 2);
      elements.push_back({i, j, -g});
      diagonal += g;
      if (uniform(random) >= 0.8) continue;
      elements.push_back({j, i, -g});
      elements.push_back({j, j, g});
    }
    elements.push_back({i, i, diagonal});
  }
  return elements;
}

FamilyMatrix circuit(int n) {
  std::vector<Element> elements = circuit_elements(n);
  // Every 97th row is swapped with the next one: zero or missing diagonals.
  const auto place = [n](int row) {
    if (row % 97 == 0 && row + 1 < n) return row + 1;
    return row % 97 == 1 ? row - 1 : row;
  };
  for (Element& e : elements) e.row = place(e.row);
  std::stable_sort(elements.begin(), elements.end(),
                   [](const auto& x, const auto& y) { return x.row < y.row; });
  Builder builder(n);
  builder.reserve(static_cast<std::int64_t>(elements.size()));
  Contributions row;
  std::size_t next = 0;
  for (int r = 0; r < n; ++r) {
    row.clear();
    for (; next < elements.size() && elements[next].row == r; ++next)
      row.push_back({elements[next].column, elements[next].value});
    merge(row);
    builder.add(row);
  }
  return builder.take();
}

// Unknowns of the family, in double: large sizes must not overflow here.
double unknowns(const std::string& name, double m) {
  if (name == "elas3d") return 3 * m * m * m;
  if (name == "beam3d") return 24 * m * m * m;
  if (name == "kkt") return 3 * m * m * m + 3 * m * m;
  if (name == "convdiff3d") return m * m * m;
  if (name == "poisson2d") return m * m;
  return m;
}

}  // namespace

const std::vector<std::string>& family_names() {
  static const std::vector<std::string> names{"elas3d",     "beam3d",    "kkt",
                                              "convdiff3d", "poisson2d", "circuit"};
  return names;
}

FamilyMatrix make_family(const std::string& name, std::int64_t size) {
  const auto& names = family_names();
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw InvalidInput("family", "'" + name + "' is none of: " + comma_list(names));
  const bool fits =
      size >= 1 && unknowns(name, static_cast<double>(size)) <= std::numeric_limits<std::int32_t>::max();
  if (!fits)
    throw InvalidInput("size", "'" + std::to_string(size) + "' is below 1 or gives over 2147483647 unknowns");
  const int m = static_cast<int>(size);
  if (name == "elas3d") return elastic_body({m, m, m});
  if (name == "beam3d") return elastic_body({8 * m, m, m});
  if (name == "kkt") return saddle_point(m);
  if (name == "convdiff3d") return convection_diffusion(m);
  if (name == "poisson2d") return laplacian(m);
  return circuit(m);
}

}  // namespace mfs::cases
