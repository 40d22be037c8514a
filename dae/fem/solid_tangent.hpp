// The derivatives of one solid element's force (solid_kernels.hpp), compiled for the host and for a device.
// Their material parts are sums over rows,
//
//   force_q += left^T by_q,   force_v += left^T by_v:
//
// left holds strains by the unknowns, by_q and by_v stresses by them, six rows at every point; hex8 has nine
// rows more for each law that its modes condense. All that is done to rows is done to each of their columns
// by itself. So a thread of the host holds all columns, and on a device each thread of an element holds one:
// `Columns` says which (AllColumns). The rest of force_q is the initial stress: grad N_i . S grad N_j.
#pragma once

#include "dae/fem/solid_force.hpp"

namespace mfs::dae {

/// What the rows are made of. On a device lanes make it, one point each.
template <ElementKind kind, class Held = AllPoints<kind>>
struct TangentState {
  Response<kind, Held> response;
  PointGradients<kind, Held> reference;
  PointStiffness<kind, Held> stiffness;  ///< `same`: it is Hooke's
  ModeFactors factors;                   ///< of the modes by it, where it is not Hooke's
};

/// As respond().
template <ElementKind kind, class Held>
MFS_INLINE void prepare_tangent(const SolidConstants& c, const PointGradients<kind, Held>& cell,
                                const PointMaps<kind, Held>& map, const Modes<kind>& modes, const double* q,
                                const double* v, TangentState<kind, Held>& s) {
  respond<kind>(c, cell, map, modes, q, v, s.response);
  map_gradients<kind>(cell, map, s.reference);
  stiffnesses<kind>(c, s.response.elastic.strain, s.stiffness);
  if constexpr (Modes<kind>::count > 0)
    if (!s.stiffness.same) Enhancement<kind, Held>(modes, map).factor(s.stiffness, s.factors);
}

// out = d rows, for d of 6 x 6 and 6 rows.
template <int stride>
MFS_INLINE void stiffness_times(const double* d, const double* rows, double* out) {
  for (int i = 0; i < 6; ++i)
    for (int n = 0; n < stride; ++n) {
      double sum = 0;
      for (int k = 0; k < 6; ++k) sum += d[6 * i + k] * rows[k * stride + n];
      out[i * stride + n] = sum;
    }
}

// The same for Hooke's law.
template <int stride>
MFS_INLINE void hooke_times(const SolidConstants& c, const double* rows, double* out) {
  for (int n = 0; n < stride; ++n) {
    const double volumetric = c.lambda * (rows[n] + rows[stride + n] + rows[2 * stride + n]);
    for (int k = 0; k < 3; ++k) {
      out[k * stride + n] = volumetric + 2 * c.mu * rows[k * stride + n];
      out[(k + 3) * stride + n] = c.mu * rows[(k + 3) * stride + n];
    }
  }
}

template <int rows, int stride>
MFS_INLINE void scale_rows(double factor, const double* in, double* out) {
  for (int n = 0; n < rows * stride; ++n) out[n] = factor * in[n];
}

// out = -scale D^-1 rows, for the D of L D L^T.
template <int stride>
MFS_INLINE void divide_modes(const ModeFactors& factors, double scale, const double* rows, double* out) {
  for (int m = 0; m < kModes; ++m)
    scale_rows<1, stride>(-scale * factors.at(m, m), rows + m * stride, out + m * stride);
}

// Stresses of each point by the unknowns, and their moments for the modes.
template <ElementKind kind, int stride>
struct StressRows {
  alignas(64) double value[6 * stride];
  RowMoments<stride> moments;

  MFS_INLINE void add_moments(const Modes<kind>& modes, int p) {
    if constexpr (Modes<kind>::count > 0) modes.add_moments(p, value, moments);
  }
  MFS_INLINE void set(const double* d, const double* strain_rows, const Modes<kind>& modes, int p) {
    stiffness_times<stride>(d, strain_rows, value);
    add_moments(modes, p);
  }
  MFS_INLINE void set_by_hooke(const SolidConstants& c, const double* strain_rows, const Modes<kind>& modes,
                               int p) {
    hooke_times<stride>(c, strain_rows, value);
    add_moments(modes, p);
  }
  // L^-1 int M^T (rows) dV: the modes' coupling with the unknowns, half eliminated.
  MFS_INLINE void couple(const ModeFactors& factors, const Modes<kind>& modes, double* out) const {
    modes.mode_rows(moments, out);
    factors.template forward<stride>(out);
  }
};

// Where the law is Hooke's, stresses by the positions are those by the velocities, but for beta, and
// `by_velocity` is not used.
template <ElementKind kind, int stride>
struct TangentStress {
  bool linear;
  StressRows<kind, stride> elastic, by_velocity, by_position;  ///< the last two: viscous

  MFS_INLINE const StressRows<kind, stride>& viscous() const { return linear ? elastic : by_velocity; }
};

// by_q += the viscous stress by the positions, by_v = the same by the velocities, at point p.
template <ElementKind kind, class Columns>
MFS_INLINE void add_viscous_rows(const SolidConstants& c, const Modes<kind>& modes,
                                 const TangentState<kind>& s, int p,
                                 TangentStress<kind, Columns::stride>& stress, const double* left,
                                 double* by_q, double* by_v) {
  constexpr int stride = Columns::stride;
  const double weight = c.beta * s.reference.weight[p];
  alignas(64) double rate_rows[6 * stride];
  strain_rows<kind, Columns>(s.reference, s.response.rate, p, rate_rows);
  stress.by_position.set_by_hooke(c, rate_rows, modes, p);
  for (int n = 0; n < 6 * stride; ++n) by_q[n] += weight * stress.by_position.value[n];
  if (!stress.linear) stress.by_velocity.set_by_hooke(c, left, modes, p);
  scale_rows<6, stride>(weight, stress.viscous().value, by_v);
}

// The six rows of point p.
template <ElementKind kind, class Columns>
MFS_INLINE void point_rows(const SolidConstants& c, const Modes<kind>& modes, const TangentState<kind>& s,
                           int p, TangentStress<kind, Columns::stride>& stress, double* left, double* by_q,
                           double* by_v) {
  strain_rows<kind, Columns>(s.reference, s.response.elastic, p, left);
  if (stress.linear)
    stress.elastic.set_by_hooke(c, left, modes, p);
  else
    stress.elastic.set(s.stiffness.at(p), left, modes, p);
  scale_rows<6, Columns::stride>(s.reference.weight[p], stress.elastic.value, by_q);
  if (c.beta > 0) add_viscous_rows<kind, Columns>(c, modes, s, p, stress, left, by_q, by_v);
}

// The rows that the modes of the viscous stress condense into, with those of the elastic one where the law is
// Hooke's.
template <ElementKind kind, int stride>
MFS_INLINE void viscous_mode_rows(const SolidConstants& c, const Modes<kind>& modes,
                                  const TangentStress<kind, stride>& stress, double* left, double* by_q,
                                  double* by_v) {
  const ModeFactors& hooke = modes.linear;
  stress.viscous().couple(hooke, modes, left);
  divide_modes<stride>(hooke, c.beta, left, by_v);
  stress.by_position.couple(hooke, modes, by_q);
  if (stress.linear)
    for (int n = 0; n < kModes * stride; ++n) by_q[n] = c.beta * by_q[n] + left[n];
  divide_modes<stride>(hooke, stress.linear ? 1.0 : c.beta, by_q, by_q);
}

/// Makes all rows, some at a time: writes them (row by row) to rows.left(), by_q() and by_v(), then calls
/// rows.take<how many>(whether by_v is there).
template <ElementKind kind, class Columns, class Rows>
MFS_INLINE void tangent_rows(const SolidConstants& c, const Modes<kind>& modes, const TangentState<kind>& s,
                             Rows& rows) {
  constexpr int stride = Columns::stride;
  const bool viscous = c.beta > 0;
  TangentStress<kind, stride> stress;
  stress.linear = c.law == MaterialLaw::st_venant_kirchhoff;
  for (int p = 0; p < Sizes<kind>::points; ++p) {
    point_rows<kind, Columns>(c, modes, s, p, stress, rows.left(), rows.by_q(), rows.by_v());
    rows.template take<6>(viscous);
  }
  if constexpr (Modes<kind>::count > 0) {
    if (viscous) {
      viscous_mode_rows<kind, stride>(c, modes, stress, rows.left(), rows.by_q(), rows.by_v());
      rows.template take<kModes>(true);
      if (stress.linear) return;
    }
    const ModeFactors& factors = stress.linear ? modes.linear : s.factors;
    stress.elastic.couple(factors, modes, rows.left());
    divide_modes<stride>(factors, 1.0, rows.left(), rows.by_q());
    rows.template take<kModes>(false);
  }
}

/// Direction a of S grad N_i at point p, times the weight.
template <ElementKind kind>
MFS_INLINE double stressed_gradient(const TangentState<kind>& s, int p, int a, int i) {
  double sum = 0;
  for (int b = 0; b < 3; ++b)
    sum += s.response.stress.value[voigt_of(a, b)][p] * s.reference.gradient[b][i][p];
  return s.reference.weight[p] * sum;
}

}  // namespace mfs::dae
