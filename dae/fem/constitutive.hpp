// The laws of material.hpp at one point: stress and its derivative by the strain, in Voigt form.
#pragma once

#include <cmath>

#include "dae/fem/element_points.hpp"

namespace mfs::dae {

/// Hooke's stiffness C0 (6 x 6).
MFS_INLINE void hooke_stiffness(const SolidConstants& c, double* d) {
  for (int i = 0; i < 36; ++i) d[i] = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) d[6 * i + j] = c.lambda;
    d[7 * i] += 2 * c.mu;
    d[7 * (i + 3)] = c.mu;
  }
}

MFS_INLINE void hooke_stress(const SolidConstants& c, const double* strain, double* stress) {
  const double volumetric = c.lambda * (strain[0] + strain[1] + strain[2]);
  for (int k = 0; k < 3; ++k) {
    stress[k] = volumetric + 2 * c.mu * strain[k];
    stress[k + 3] = c.mu * strain[k + 3];
  }
}

// C^-1 as a full matrix and ln(J), for C = 2 E + 1; NaN where C is not positive.
struct InverseStretch {
  double inverse[3][3], log_j;
};

MFS_INLINE InverseStretch inverse_stretch(const double* strain) {
  const double a = 2 * strain[0] + 1, b = 2 * strain[1] + 1, c = 2 * strain[2] + 1;
  const double d = strain[3], e = strain[4], f = strain[5];
  const double i00 = b * c - e * e, i01 = e * f - d * c, i02 = d * e - b * f;
  const double det = a * i00 + d * i01 + f * i02, s = 1 / det;
  const double i12 = d * f - a * e;
  return {{{s * i00, s * i01, s * i02},
           {s * i01, s * (a * c - f * f), s * i12},
           {s * i02, s * i12, s * (a * b - d * d)}},
          0.5 * std::log(det)};
}

MFS_INLINE void neo_hookean_stress(const SolidConstants& c, const double* strain, double* stress) {
  const InverseStretch s = inverse_stretch(strain);
  for (int k = 0; k < 6; ++k)
    stress[k] = (k < 3 ? c.mu : 0.0) + (c.lambda * s.log_j - c.mu) * s.inverse[voigt(k, 0)][voigt(k, 1)];
}

/// Per undeformed volume. mu / 2 (tr C - 3) - mu ln J + lambda / 2 (ln J)^2.
MFS_INLINE double neo_hookean_energy(const SolidConstants& c, const double* strain) {
  const double log_j = inverse_stretch(strain).log_j;
  return c.mu * (strain[0] + strain[1] + strain[2] - log_j) + 0.5 * c.lambda * log_j * log_j;
}

MFS_INLINE void neo_hookean_stiffness(const SolidConstants& c, const double* strain, double* d) {
  const InverseStretch s = inverse_stretch(strain);
  const double mu = c.mu - c.lambda * s.log_j;
  for (int k = 0; k < 6; ++k)
    for (int l = 0; l < 6; ++l) {
      const int a = voigt(k, 0), b = voigt(k, 1), e = voigt(l, 0), f = voigt(l, 1);
      d[6 * k + l] = c.lambda * s.inverse[a][b] * s.inverse[e][f] +
                     mu * (s.inverse[a][e] * s.inverse[b][f] + s.inverse[a][f] * s.inverse[b][e]);
    }
}

/// Voigt components of the points: [component][point].
template <ElementKind kind, class Held = AllPoints<kind>>
struct PointVoigt {
  alignas(64) double value[6][Held::count];
};

// stress (+)= factor * law(strain) at every point.
template <ElementKind kind, class Held, class Law>
MFS_INLINE void at_points(const double (*strain)[Held::count], const Law& law,
                          PointVoigt<kind, Held>& stress) {
  for (int p = 0; p < Held::count; ++p) {
    double e[6], s[6];
    for (int k = 0; k < 6; ++k) e[k] = strain[k][p];
    law(e, s);
    for (int k = 0; k < 6; ++k) stress.value[k][p] = s[k];
  }
}

template <ElementKind kind, class Held>
MFS_INLINE void hooke_stresses(const SolidConstants& c, const double (*strain)[Held::count],
                               PointVoigt<kind, Held>& stress) {
  at_points<kind>(
      strain, [&](const double* e, double* s) { hooke_stress(c, e, s); }, stress);
}

template <ElementKind kind, class Held>
MFS_INLINE void elastic_stresses(const SolidConstants& c, const double (*strain)[Held::count],
                                 PointVoigt<kind, Held>& stress) {
  if (c.law == MaterialLaw::st_venant_kirchhoff) return hooke_stresses<kind>(c, strain, stress);
  at_points<kind>(
      strain, [&](const double* e, double* s) { neo_hookean_stress(c, e, s); }, stress);
}

/// The stiffness at every point, [point][36]; one for all where the law is linear.
template <ElementKind kind, class Held = AllPoints<kind>>
struct PointStiffness {
  bool same;
  alignas(64) double value[Held::count][36];
  MFS_INLINE const double* at(int p) const { return value[same ? 0 : p]; }
};

template <ElementKind kind, class Held>
MFS_INLINE void stiffnesses(const SolidConstants& c, const double (*strain)[Held::count],
                            PointStiffness<kind, Held>& out) {
  out.same = c.law == MaterialLaw::st_venant_kirchhoff;
  if (out.same) return hooke_stiffness(c, out.value[0]);
  for (int p = 0; p < Held::count; ++p) {
    double e[6];
    for (int k = 0; k < 6; ++k) e[k] = strain[k][p];
    neo_hookean_stiffness(c, e, out.value[p]);
  }
}

}  // namespace mfs::dae
