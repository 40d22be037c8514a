// The enhanced strains of hex8 (see solid_kernels.hpp); nothing for the other elements.
//
// A mode is a constant tensor times one coordinate of the cell. The tensors are the symmetric products of the
// rows of J0^-1, in Voigt form basis[pair]; mode m is basis[mode_pair(m)] * xi[mode_axis(m)] * j0 / j.
// Integrals of a mode with anything need the moments of that thing with the three coordinates only.
#pragma once

#include "dae/fem/constitutive.hpp"

namespace mfs::dae {

constexpr int kModes = 9;
MFS_INLINE int mode_pair(int mode) {
  static constexpr int pair[kModes] = {0, 1, 2, 3, 3, 4, 4, 5, 5};
  return pair[mode];
}
MFS_INLINE int mode_axis(int mode) {
  static constexpr int axis[kModes] = {0, 1, 2, 0, 1, 1, 2, 0, 2};
  return axis[mode];
}

/// L D L^T of the 9 x 9 matrix of the modes, L with unit diagonal below it, D on it.
struct ModeFactors {
  double l[kModes][kModes];

  MFS_INLINE void factor() {
    for (int j = 0; j < kModes; ++j)
      for (int i = j + 1; i < kModes; ++i) {
        const double ratio = l[i][j] / l[j][j];
        for (int k = j + 1; k <= i; ++k) l[i][k] -= ratio * l[k][j];
      }
    for (int j = 0; j < kModes; ++j)
      for (int i = j + 1; i < kModes; ++i) l[i][j] /= l[j][j];
  }
  /// rows (9 x stride) := L^-1 rows.
  template <int stride>
  MFS_INLINE void forward(double* rows) const {
    for (int i = 1; i < kModes; ++i)
      for (int j = 0; j < i; ++j)
        for (int n = 0; n < stride; ++n) rows[i * stride + n] -= l[i][j] * rows[j * stride + n];
  }
  MFS_INLINE void solve(double* x) const {
    forward<1>(x);
    for (int i = 0; i < kModes; ++i) x[i] /= l[i][i];
    for (int i = kModes - 1; i >= 0; --i)
      for (int j = i + 1; j < kModes; ++j) x[i] -= l[j][i] * x[j];
  }
};

/// Moments with xi of 6 rows of `stride` columns: [axis][6 * stride].
template <int stride>
struct RowMoments {
  alignas(64) double value[3][6 * stride] = {};
};

template <ElementKind kind, class Held = AllPoints<kind>>
struct Enhancement {
  static constexpr int modes = 0;
  using Gradients = PointGradients<kind, Held>;
  MFS_INLINE void prepare(const SolidConstants&, const double*, const Gradients&, const Gradients&) {}
  MFS_INLINE void enhance(const SolidConstants&, double (*)[Held::count]) const {}
  MFS_INLINE void enhance_linear(const SolidConstants&, double (*)[Held::count]) const {}
};

template <class Held>
struct Enhancement<ElementKind::hex8, Held> {
  static constexpr ElementKind kind = ElementKind::hex8;
  static constexpr int modes = kModes, points = Held::count;
  using Gradients = PointGradients<kind, Held>;
  static constexpr int kMostNewtonSteps = 30;

  double basis[6][6];
  double det0;
  double ratio[points];  ///< j0 / j
  double xi[3][points];
  ModeFactors linear;  ///< int M^T D M dV of Hooke's law: one factorization serves strains, rates and tangent

  MFS_INLINE void prepare(const SolidConstants& c, const double* nodes, const Gradients& cell,
                          const Gradients& reference) {
    double j[9][1] = {}, rows[3][3];
    for (int i = 0; i < Sizes<kind>::nodes; ++i)
      for (int a = 0; a < 3; ++a) {
        double slope = 0;  // of shape function i at the centre: the mean over the points
        for (int p = 0; p < points; ++p) slope += cell.gradient[a][i][p] / Sizes<kind>::points;
        for (int c = 0; c < 3; ++c) j[3 * c + a][0] += nodes[3 * i + c] * slope;
      }
    for (auto& entry : j) entry[0] = Held::sum(entry[0]);
    det0 = determinant_at(j, 0);
    const double scale = std::cbrt(det0) / det0;  // rows of J0^-1 without a unit
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) rows[r][c] = scale * adjugate_at(j, r, c, 0);
    for (int pair = 0; pair < 6; ++pair)
      for (int k = 0; k < 6; ++k) {
        const double *first = rows[voigt(pair, 0)], *second = rows[voigt(pair, 1)];
        const int a = voigt(k, 0), b = voigt(k, 1);
        basis[pair][k] = k < 3 ? first[a] * second[a] : first[a] * second[b] + first[b] * second[a];
      }
    for (int p = 0; p < points; ++p) {
      ratio[p] = det0 / reference.weight[p];  // the weights of the rule are 1
      for (int a = 0; a < 3; ++a) xi[a][p] = (Held::point(p) >> a & 1) != 0 ? kGauss : -kGauss;
    }
    PointStiffness<kind, Held> hooke;
    hooke.same = true;
    hooke_stiffness(c, hooke.value[0]);
    factor(hooke, linear);
  }

  /// Adds the enhanced strains that leave no stress of `c`'s law in the modes; NaN where none are found.
  MFS_INLINE void enhance(const SolidConstants& c, double (*strain)[points]) const {
    enhance_linear(c, strain);
    if (c.law == MaterialLaw::st_venant_kirchhoff) return;
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
    correct(stress, linear, strain);
  }

  /// int M^T D M dV, factored. Where D is the same at all points, only moments have to be summed over them.
  MFS_INLINE void factor(const PointStiffness<kind, Held>& stiffness, ModeFactors& factors) const {
    for (auto& row : factors.l)
      for (double& value : row) value = 0;
    for (int first = 0; first < points; first += stiffness.same ? points : 1) {
      const int end = stiffness.same ? points : first + 1;
      double moment[3][3] = {}, product[6][6], modes_stiffness[6][6];
      for (int p = first; p < end; ++p)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) moment[a][b] += det0 * ratio[p] * xi[a][p] * xi[b][p];
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
          factors.l[m][n] += moment[mode_axis(m)][mode_axis(n)] * modes_stiffness[mode_pair(m)][mode_pair(n)];
    }
    if (!stiffness.same)
      for (int m = 0; m < kModes; ++m)
        for (int n = 0; n <= m; ++n) factors.l[m][n] = Held::sum(factors.l[m][n]);
    factors.factor();
  }

  template <int stride>
  MFS_INLINE void add_moments(int p, const double* rows, RowMoments<stride>& moments) const {
    for (int a = 0; a < 3; ++a)
      for (int n = 0; n < 6 * stride; ++n) moments.value[a][n] += det0 * xi[a][p] * rows[n];
  }
  /// int M^T (rows) dV, 9 x stride, from the moments of the rows.
  template <int stride>
  MFS_INLINE void mode_rows(const RowMoments<stride>& moments, double* out) const {
    for (int m = 0; m < kModes; ++m)
      for (int n = 0; n < stride; ++n) {
        double sum = 0;
        for (int k = 0; k < 6; ++k)
          sum += basis[mode_pair(m)][k] * moments.value[mode_axis(m)][k * stride + n];
        out[m * stride + n] = sum;
      }
  }

 private:
  static constexpr double kGauss = 0.577350269189625764509;  ///< 1 / sqrt(3)
  static constexpr double kSmallestStep = 1e-13;             ///< of a strain; convergence is quadratic

  // One Newton step: alpha = - factors^-1 int M^T stress dV, strain += M alpha. The largest |alpha|.
  MFS_INLINE double correct(const PointVoigt<kind, Held>& stress, const ModeFactors& factors,
                            double (*strain)[points]) const {
    double moment[3][6] = {}, alpha[kModes], sum[3][6] = {}, largest = 0;
    for (int a = 0; a < 3; ++a)
      for (int k = 0; k < 6; ++k)
        for (int p = 0; p < points; ++p) moment[a][k] += det0 * xi[a][p] * stress.value[k][p];
    for (auto& row : moment)
      for (double& value : row) value = Held::sum(value);
    for (int m = 0; m < kModes; ++m) {
      alpha[m] = 0;
      for (int k = 0; k < 6; ++k) alpha[m] -= basis[mode_pair(m)][k] * moment[mode_axis(m)][k];
    }
    factors.solve(alpha);
    for (int m = 0; m < kModes; ++m) {
      largest = std::abs(alpha[m]) < largest ? largest : std::abs(alpha[m]);  // NaN stays
      for (int k = 0; k < 6; ++k) sum[mode_axis(m)][k] += basis[mode_pair(m)][k] * alpha[m];
    }
    for (int k = 0; k < 6; ++k)
      for (int p = 0; p < points; ++p)
        strain[k][p] += ratio[p] * (xi[0][p] * sum[0][k] + xi[1][p] * sum[1][k] + xi[2][p] * sum[2][k]);
    return largest;
  }
};

}  // namespace mfs::dae
