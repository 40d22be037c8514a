// Quantities at the integration points of one element, the point as the last index: the loops over points and
// over columns are what the compiler turns into wide instructions. Sizes are known at compile time.
// Everything here is inlined into the three functions of solid_kernels.cpp that are compiled for several
// processor levels, and into the kernels of a device (dae/fem/cuda): one source for both. A thread of
// the host holds all points of an element. On a device each lane of a warp holds one, and the lanes of an
// element add up what is summed over its points. `Held` says which it is: Held::count points are here, number
// Held::point(p) of the element is the p-th of them, Held::sum(x) is x of all who hold some, and
// Held::sum_all(count, f, take) gives each of many sums to one of them.
#pragma once

#include <cmath>
#include <limits>

#include "dae/fem/shape.hpp"
#include "dae/fem/solid_kernels.hpp"

#ifdef __CUDACC__
#define MFS_INLINE __host__ __device__ __forceinline__
#else
#define MFS_INLINE [[gnu::always_inline]] inline
#endif

namespace mfs::dae {

template <ElementKind kind>
struct Sizes {
  static constexpr int nodes = nodes_per_element(kind);
  static constexpr int points = kind == ElementKind::hex8 ? 8 : kind == ElementKind::hex20 ? 27 : 4;
  static constexpr int unknowns = 3 * nodes;
  static constexpr int stride = (unknowns + 7) / 8 * 8;    ///< of rows over unknowns
  static constexpr int node_stride = (nodes + 7) / 8 * 8;  ///< of rows over nodes
};

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// One thread holds all points of an element.
template <ElementKind kind>
struct AllPoints {
  static constexpr int count = Sizes<kind>::points;
  MFS_INLINE static int point(int p) { return p; }
  MFS_INLINE static double sum(double x) { return x; }
  /// take(i, sum of f(i)), for all i < total.
  template <int total, class F, class Take>
  MFS_INLINE static void sum_all(const F& f, const Take& take) {
    for (int i = 0; i < total; ++i) take(i, f(i));
  }
};

/// One thread holds all columns of rows over the unknowns, with `stride` places for them; `used` of those are
/// columns, number column(n) the n-th.
template <ElementKind kind>
struct AllColumns {
  static constexpr int used = Sizes<kind>::unknowns, stride = Sizes<kind>::stride;
  MFS_INLINE static int column(int n) { return n; }
};

/// dN_i / dX_a as gradient[a][i][point], and the integration weight times det(dX/dxi).
template <ElementKind kind, class Held = AllPoints<kind>>
struct PointGradients {
  alignas(64) double gradient[3][Sizes<kind>::nodes][Held::count];
  alignas(64) double weight[Held::count];
};

/// Of the map from the cell to an element: dxi_b / dX_a as inverse[3 b + a][point], and the integration
/// weight times det(dX/dxi).
template <ElementKind kind, class Held = AllPoints<kind>>
struct PointMaps {
  alignas(64) double inverse[9][Held::count];
  alignas(64) double weight[Held::count];
};

/// F (or F'), f[3 c + a][point] = dx_c / dX_a; and the strain (or its rate) that belongs to it.
template <ElementKind kind, class Held = AllPoints<kind>>
struct Deformation {
  alignas(64) double f[9][Held::count];
  alignas(64) double strain[6][Held::count];
};

/// Gradients on the reference cell in the layout of PointGradients, and the weights of the rule.
template <ElementKind kind>
const PointGradients<kind>& cell_gradients() {
  static const PointGradients<kind> table = [] {
    PointGradients<kind> t{};
    const QuadratureRule& rule = stiffness_rule(kind);
    double gradients[Sizes<kind>::unknowns];
    for (int p = 0; p < Sizes<kind>::points; ++p) {
      shape_gradients(kind, rule.points[static_cast<std::size_t>(p)], gradients);
      t.weight[p] = rule.weights[static_cast<std::size_t>(p)];
      for (int i = 0; i < Sizes<kind>::nodes; ++i)
        for (int a = 0; a < 3; ++a) t.gradient[a][i][p] = gradients[3 * i + a];
    }
    return t;
  }();
  return table;
}

// sum[3 c + a][point] = sum over the nodes of x_i[c] * gradient[a][i][point].
template <ElementKind kind, class Held>
MFS_INLINE void nodal_sum(const PointGradients<kind, Held>& g, const double* x, double (*sum)[Held::count]) {
  constexpr int points = Held::count;
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < 3; ++a) {
      double total[points] = {};
      for (int i = 0; i < Sizes<kind>::nodes; ++i)
        for (int p = 0; p < points; ++p) total[p] += x[3 * i + c] * g.gradient[a][i][p];
      for (int p = 0; p < points; ++p) sum[3 * c + a][p] = total[p];
    }
}

template <class Matrix>
MFS_INLINE double determinant_at(const Matrix& m, int p) {
  return m[0][p] * (m[4][p] * m[8][p] - m[5][p] * m[7][p]) -
         m[1][p] * (m[3][p] * m[8][p] - m[5][p] * m[6][p]) +
         m[2][p] * (m[3][p] * m[7][p] - m[4][p] * m[6][p]);
}

// Entry (r, c) of det(m) m^-1.
template <class Matrix>
MFS_INLINE double adjugate_at(const Matrix& m, int r, int c, int p) {
  const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
  return m[3 * c1 + r1][p] * m[3 * c2 + r2][p] - m[3 * c1 + r2][p] * m[3 * c2 + r1][p];
}

/// The map to an element whose nodes lie at `nodes`. cell: gradients on the reference cell.
template <ElementKind kind, class Held>
MFS_INLINE void map_cell(const PointGradients<kind, Held>& cell, const double* nodes,
                         PointMaps<kind, Held>& out) {
  alignas(64) double j[9][Held::count];
  nodal_sum<kind>(cell, nodes, j);
  for (int p = 0; p < Held::count; ++p) {
    const double det = determinant_at(j, p), scale = 1 / det;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) out.inverse[3 * r + c][p] = scale * adjugate_at(j, r, c, p);
    out.weight[p] = cell.weight[p] * det;
  }
}

/// Gradients of the element, from those on the reference cell.
template <ElementKind kind, class Held>
MFS_INLINE void map_gradients(const PointGradients<kind, Held>& cell, const PointMaps<kind, Held>& map,
                              PointGradients<kind, Held>& out) {
  for (int p = 0; p < Held::count; ++p) out.weight[p] = map.weight[p];
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < Sizes<kind>::nodes; ++i)
      for (int p = 0; p < Held::count; ++p)
        out.gradient[a][i][p] = cell.gradient[0][i][p] * map.inverse[a][p] +
                                cell.gradient[1][i][p] * map.inverse[3 + a][p] +
                                cell.gradient[2][i][p] * map.inverse[6 + a][p];
}

/// dx_c / dX_a as out[3 c + a][point], of nodal values x.
template <ElementKind kind, class Held>
MFS_INLINE void derivatives(const PointGradients<kind, Held>& cell, const PointMaps<kind, Held>& map,
                            const double* x, double (*out)[Held::count]) {
  alignas(64) double in_cell[9][Held::count];
  nodal_sum<kind>(cell, x, in_cell);
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < 3; ++a)
      for (int p = 0; p < Held::count; ++p)
        out[3 * c + a][p] = in_cell[3 * c][p] * map.inverse[a][p] +
                            in_cell[3 * c + 1][p] * map.inverse[3 + a][p] +
                            in_cell[3 * c + 2][p] * map.inverse[6 + a][p];
}

// The first or second index (which = 0 or 1) of a Voigt component. A function, because code of a device sees
// no arrays of the host.
MFS_INLINE int voigt(int component, int which) {
  static constexpr int indices[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
  return indices[component][which];
}

// Row `row` of a symmetric tensor, as a function of the column: its place in Voigt order.
MFS_INLINE int voigt_of(int row, int column) {
  static constexpr int component[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  return component[row][column];
}

/// Green strain; NaN where the element is turned inside out.
template <ElementKind kind, class Held>
MFS_INLINE void deform(const PointGradients<kind, Held>& cell, const PointMaps<kind, Held>& map,
                       const double* q, Deformation<kind, Held>& out) {
  derivatives<kind>(cell, map, q, out.f);
  for (int k = 0; k < 6; ++k) {
    const int a = voigt(k, 0), b = voigt(k, 1);
    for (int p = 0; p < Held::count; ++p) {
      const double product =
          out.f[a][p] * out.f[b][p] + out.f[3 + a][p] * out.f[3 + b][p] + out.f[6 + a][p] * out.f[6 + b][p];
      const double sound = determinant_at(out.f, p) > 0 ? 0.0 : kNaN;
      out.strain[k][p] = (k < 3 ? 0.5 * (product - 1) : product) + sound;
    }
  }
}

/// F' and E' = sym(F^T F').
template <ElementKind kind, class Held>
MFS_INLINE void deform_rate(const PointGradients<kind, Held>& cell, const PointMaps<kind, Held>& map,
                            const double* v, const Deformation<kind, Held>& elastic,
                            Deformation<kind, Held>& out) {
  derivatives<kind>(cell, map, v, out.f);
  for (int k = 0; k < 6; ++k) {
    const int a = voigt(k, 0), b = voigt(k, 1);
    const double share = k < 3 ? 0.5 : 1.0;
    for (int p = 0; p < Held::count; ++p) {
      double sum = 0;
      for (int c = 0; c < 9; c += 3)
        sum += elastic.f[c + a][p] * out.f[c + b][p] + out.f[c + a][p] * elastic.f[c + b][p];
      out.strain[k][p] = share * sum;
    }
  }
}

/// Derivatives of the strains at one point by the unknowns: rows[6][stride]. With F' in place of F they are
/// those of the strain rates by the positions.
template <ElementKind kind, class Columns>
MFS_INLINE void strain_rows(const PointGradients<kind>& g, const Deformation<kind>& d, int p, double* rows) {
  constexpr int stride = Columns::stride;
  alignas(64) double gradient[3][stride] = {}, f[3][stride] = {};
  for (int a = 0; a < 3; ++a)
    for (int n = 0; n < Columns::used; ++n) {
      const int node = Columns::column(n) / 3, direction = Columns::column(n) % 3;
      gradient[a][n] = g.gradient[a][node][p];
      f[a][n] = d.f[3 * direction + a][p];
    }
  for (int k = 0; k < 6; ++k) {
    const int a = voigt(k, 0), b = voigt(k, 1);
    if (a == b)
      for (int n = 0; n < stride; ++n) rows[k * stride + n] = f[a][n] * gradient[a][n];
    else
      for (int n = 0; n < stride; ++n)
        rows[k * stride + n] = f[a][n] * gradient[b][n] + f[b][n] * gradient[a][n];
  }
}

}  // namespace mfs::dae
