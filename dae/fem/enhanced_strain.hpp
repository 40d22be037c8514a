// The enhanced strains of hex8 (see solid_kernels.hpp); nothing for the other elements.
//
// A mode is a constant tensor times one coordinate of the cell: mode 3 a + j is xi_a times the symmetric
// product of rows a and j of J0^-1, times j0 / j. So with the rows as R and
//
//   T = R S R^T at a point,    int M^T S dV = sum over the points of j0 xi_a T[a][j],
//   M alpha = j0 / j R^T B R, its symmetric part,    B[a][j] = xi_a alpha[3 a + j].
//
// What an element's modes are depends on its undeformed shape and its material alone (Modes).
#pragma once

#include "dae/fem/constitutive.hpp"

namespace mfs::dae {

constexpr int kModes = 9;
MFS_INLINE int mode_axis(int mode) {
  return mode / 3;
}
MFS_INLINE int mode_pair(int mode) {
  return voigt_of(mode / 3, mode % 3);
}

/// L D L^T of the 9 x 9 matrix of the modes: L below its diagonal of ones, where 1 / D is.
class ModeFactors {
 public:
  /// The matrix, or its factors: row i, column j <= i.
  MFS_INLINE double& at(int i, int j) { return value_[i * (i + 1) / 2 + j]; }
  MFS_INLINE double at(int i, int j) const { return value_[i * (i + 1) / 2 + j]; }

  MFS_INLINE void factor() {
    for (int j = 0; j < kModes; ++j) {
      at(j, j) = 1 / at(j, j);
      for (int i = kModes - 1; i > j; --i) {
        const double ratio = at(i, j) * at(j, j);
        for (int k = j + 1; k <= i; ++k) at(i, k) -= ratio * at(k, j);
        at(i, j) = ratio;
      }
    }
  }
  /// rows (9 x stride) := L^-1 rows.
  template <int stride>
  MFS_INLINE void forward(double* rows) const {
    for (int i = 1; i < kModes; ++i)
      for (int j = 0; j < i; ++j)
        for (int n = 0; n < stride; ++n) rows[i * stride + n] -= at(i, j) * rows[j * stride + n];
  }
  MFS_INLINE void solve(double* x) const {
    forward<1>(x);
    for (int i = 0; i < kModes; ++i) x[i] *= at(i, i);
    for (int j = kModes - 1; j > 0; --j)
      for (int i = 0; i < j; ++i) x[i] -= at(j, i) * x[j];
  }

 private:
  double value_[kModes * (kModes + 1) / 2];
};

/// Moments with xi of 6 rows of `stride` columns: [axis][6 * stride].
template <int stride>
struct RowMoments {
  alignas(64) double value[3][6 * stride] = {};
};

/// The modes of an element, the same in every state.
template <ElementKind kind>
struct Modes {
  static constexpr int count = 0;
  template <class Held>
  MFS_INLINE void prepare(const SolidConstants&, const double*, const PointGradients<kind, Held>&,
                          const PointMaps<kind, Held>&) {}
};

template <>
struct Modes<ElementKind::hex8> {
  static constexpr ElementKind kind = ElementKind::hex8;
  static constexpr int count = kModes;

  double rows[3][3];  ///< of J0^-1, without a unit
  double det0;
  ModeFactors linear;  ///< int M^T D M dV of Hooke's law: one factorization serves strains, rates and tangent

  template <class Held>
  MFS_INLINE void prepare(const SolidConstants& c, const double* nodes,
                          const PointGradients<kind, Held>& cell, const PointMaps<kind, Held>& map);

  /// The coordinate xi_axis of point `point`.
  MFS_INLINE static double coordinate(int point, int axis) {
    constexpr double kGauss = 0.577350269189625764509;  // 1 / sqrt(3)
    return (point >> axis & 1) != 0 ? kGauss : -kGauss;
  }

  template <int stride>
  MFS_INLINE void add_moments(int p, const double* of_point, RowMoments<stride>& moments) const {
    for (int a = 0; a < 3; ++a) {
      const double factor = det0 * coordinate(p, a);
      for (int n = 0; n < 6 * stride; ++n) moments.value[a][n] += factor * of_point[n];
    }
  }
  /// int M^T (rows) dV, 9 x stride, from the moments of the rows.
  template <int stride>
  MFS_INLINE void mode_rows(const RowMoments<stride>& moments, double* out) const {
    for (int a = 0; a < 3; ++a) {
      alignas(64) double along[3][stride];
      for (int i = 0; i < 3; ++i)
        for (int n = 0; n < stride; ++n) {
          double sum = 0;
          for (int k = 0; k < 3; ++k) sum += rows[a][k] * moments.value[a][voigt_of(i, k) * stride + n];
          along[i][n] = sum;
        }
      for (int j = 0; j < 3; ++j)
        for (int n = 0; n < stride; ++n)
          out[(3 * a + j) * stride + n] =
              rows[j][0] * along[0][n] + rows[j][1] * along[1][n] + rows[j][2] * along[2][n];
    }
  }
};

/// What the modes of an element do to strains at its points.
template <ElementKind kind, class Held = AllPoints<kind>>
struct Enhancement {
  MFS_INLINE Enhancement(const Modes<kind>&, const PointMaps<kind, Held>&) {}
  MFS_INLINE void enhance(const SolidConstants&, double (*)[Held::count]) const {}
  MFS_INLINE void enhance_linear(const SolidConstants&, double (*)[Held::count]) const {}
};

template <class Held>
struct Enhancement<ElementKind::hex8, Held> {
  static constexpr ElementKind kind = ElementKind::hex8;
  static constexpr int points = Held::count;
  static constexpr int kMostNewtonSteps = 30;

  const Modes<kind>& modes;
  double ratio[points];  ///< j0 / j
  double xi[3][points];

  MFS_INLINE Enhancement(const Modes<kind>& of_element, const PointMaps<kind, Held>& map)
      : modes(of_element) {
    for (int p = 0; p < points; ++p) {
      ratio[p] = modes.det0 / map.weight[p];  // the weights of the rule are 1
      for (int a = 0; a < 3; ++a) xi[a][p] = Modes<kind>::coordinate(Held::point(p), a);
    }
  }

  /// Adds the enhanced strains that leave no stress of `c`'s law, which is not Hooke's, in the modes; NaN
  /// where none are found.
  MFS_INLINE void enhance(const SolidConstants& c, double (*strain)[points]) const {
    enhance_linear(c, strain);
    PointVoigt<kind, Held> stress;
    PointStiffness<kind, Held> stiffness;
    ModeFactors factors;
    for (int step = 0; step < kMostNewtonSteps; ++step) {
      elastic_stresses<kind>(c, strain, stress);
      stiffnesses<kind>(c, strain, stiffness);
      factor(stiffness, factors);
      if (correct(stress, factors, strain) <= kSmallestStep) return;
    }
    for (int p = 0; p < points; ++p) strain[0][p] = kNaN;
  }

  /// The same for Hooke's law, whatever the law of `c`.
  MFS_INLINE void enhance_linear(const SolidConstants& c, double (*strain)[points]) const {
    PointVoigt<kind, Held> stress;
    hooke_stresses<kind>(c, strain, stress);
    correct(stress, modes.linear, strain);
  }

  /// int M^T D M dV, factored. Where D is the same at all points, only moments have to be summed over them.
  MFS_INLINE void factor(const PointStiffness<kind, Held>& stiffness, ModeFactors& factors) const {
    double basis[6][6];  // the tensors of the modes in Voigt form, by pairs of rows
    for (int pair = 0; pair < 6; ++pair)
      for (int k = 0; k < 6; ++k) {
        const double *first = modes.rows[voigt(pair, 0)], *second = modes.rows[voigt(pair, 1)];
        const int a = voigt(k, 0), b = voigt(k, 1);
        basis[pair][k] = k < 3 ? first[a] * second[a] : first[a] * second[b] + first[b] * second[a];
      }
    for (int m = 0; m < kModes; ++m)
      for (int n = 0; n <= m; ++n) factors.at(m, n) = 0;
    for (int first = 0; first < points; first += stiffness.same ? points : 1) {
      const int end = stiffness.same ? points : first + 1;
      double moment[3][3] = {}, product[6][6], modes_stiffness[6][6];
      for (int p = first; p < end; ++p)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) moment[a][b] += modes.det0 * ratio[p] * xi[a][p] * xi[b][p];
      if (stiffness.same)
        for (auto& row : moment)
          for (double& value : row) value = Held::sum(value);
      const double* d = stiffness.at(first);
      for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 6; ++k) {
          product[i][k] = 0;
          for (int l = 0; l < 6; ++l) product[i][k] += basis[i][l] * d[6 * l + k];
        }
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) {
          modes_stiffness[i][j] = 0;
          for (int k = 0; k < 6; ++k) modes_stiffness[i][j] += product[i][k] * basis[j][k];
        }
      for (int m = 0; m < kModes; ++m)
        for (int n = 0; n <= m; ++n)
          factors.at(m, n) +=
              moment[mode_axis(m)][mode_axis(n)] * modes_stiffness[mode_pair(m)][mode_pair(n)];
    }
    if (!stiffness.same)
      for (int m = 0; m < kModes; ++m)
        for (int n = 0; n <= m; ++n) factors.at(m, n) = Held::sum(factors.at(m, n));
    factors.factor();
  }

 private:
  static constexpr double kSmallestStep = 1e-13;  ///< of a strain; convergence is quadratic

  // One Newton step: alpha = - factors^-1 int M^T stress dV, strain += M alpha. The largest |alpha|.
  MFS_INLINE double correct(const PointVoigt<kind, Held>& stress, const ModeFactors& factors,
                            double (*strain)[points]) const {
    double alpha[kModes], largest = 0;
    integrate(stress, alpha);
    factors.solve(alpha);
    for (const double value : alpha)
      largest = std::abs(value) < largest ? largest : std::abs(value);  // NaN stays
    add_strains(alpha, strain);
    return largest;
  }

  // alpha = - int M^T stress dV
  MFS_INLINE void integrate(const PointVoigt<kind, Held>& stress, double* alpha) const {
    alignas(64) double along[3][3][points], turned[6][points];  // R S, R S R^T
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < 3; ++i)
        for (int p = 0; p < points; ++p)
          along[a][i][p] = modes.rows[a][0] * stress.value[voigt_of(0, i)][p] +
                           modes.rows[a][1] * stress.value[voigt_of(1, i)][p] +
                           modes.rows[a][2] * stress.value[voigt_of(2, i)][p];
    for (int k = 0; k < 6; ++k) {
      const auto& first = along[voigt(k, 0)];
      const double* second = modes.rows[voigt(k, 1)];
      for (int p = 0; p < points; ++p)
        turned[k][p] = first[0][p] * second[0] + first[1][p] * second[1] + first[2][p] * second[2];
    }
    for (int m = 0; m < kModes; ++m) {
      double sum = 0;
      for (int p = 0; p < points; ++p) sum += xi[mode_axis(m)][p] * turned[mode_pair(m)][p];
      alpha[m] = -modes.det0 * Held::sum(sum);
    }
  }

  // strain += M alpha
  MFS_INLINE void add_strains(const double* alpha, double (*strain)[points]) const {
    double along[3][3];  // of each axis: the rows of R, times its alphas
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < 3; ++i)
        along[a][i] = alpha[3 * a] * modes.rows[0][i] + alpha[3 * a + 1] * modes.rows[1][i] +
                      alpha[3 * a + 2] * modes.rows[2][i];
    for (int k = 0; k < 6; ++k) {
      const int i = voigt(k, 0), j = voigt(k, 1);
      double of_axis[3];
      for (int a = 0; a < 3; ++a) {
        of_axis[a] = modes.rows[a][i] * along[a][j];
        if (k >= 3) of_axis[a] += modes.rows[a][j] * along[a][i];
      }
      for (int p = 0; p < points; ++p)
        strain[k][p] += ratio[p] * (xi[0][p] * of_axis[0] + xi[1][p] * of_axis[1] + xi[2][p] * of_axis[2]);
    }
  }
};

/// nodes: (nodes x 3); cell: gradients on the reference cell; map: that to the element.
template <class Held>
MFS_INLINE void Modes<ElementKind::hex8>::prepare(const SolidConstants& c, const double* nodes,
                                                  const PointGradients<kind, Held>& cell,
                                                  const PointMaps<kind, Held>& map) {
  double j[9][1] = {};
  for (int i = 0; i < Sizes<kind>::nodes; ++i)
    for (int a = 0; a < 3; ++a) {
      double slope = 0;  // of shape function i at the centre: the mean over the points
      for (int p = 0; p < Held::count; ++p) slope += cell.gradient[a][i][p] / Sizes<kind>::points;
      for (int x = 0; x < 3; ++x) j[3 * x + a][0] += nodes[3 * i + x] * slope;
    }
  for (auto& entry : j) entry[0] = Held::sum(entry[0]);
  det0 = determinant_at(j, 0);
  const double scale = std::cbrt(det0) / det0;
  for (int r = 0; r < 3; ++r)
    for (int x = 0; x < 3; ++x) rows[r][x] = scale * adjugate_at(j, r, x, 0);
  PointStiffness<kind, Held> hooke;
  hooke.same = true;
  hooke_stiffness(c, hooke.value[0]);
  Enhancement<kind, Held>(*this, map).factor(hooke, linear);
}

}  // namespace mfs::dae
