// The force of one solid element (solid_kernels.hpp), compiled for the host and for a device. `Held` says
// which of the element's points the calling thread has (element_points.hpp).
#pragma once

#include "dae/fem/enhanced_strain.hpp"

namespace mfs::dae {

/// What an element has in every state.
template <ElementKind kind, class Held = AllPoints<kind>>
struct Undeformed {
  PointMaps<kind, Held> map;
  Modes<kind> modes;
};

/// cell: gradients on the reference cell; nodes: (nodes x 3).
template <ElementKind kind, class Held>
MFS_INLINE void undeform(const SolidConstants& c, const PointGradients<kind, Held>& cell, const double* nodes,
                         Undeformed<kind, Held>& out) {
  map_cell<kind>(cell, nodes, out.map);
  out.modes.prepare(c, nodes, cell, out.map);
}

// Strains and stresses at the points of one element; rates where there is viscosity.
template <ElementKind kind, class Held = AllPoints<kind>>
struct Response {
  Deformation<kind, Held> elastic, rate;
  PointVoigt<kind, Held> stress;
};

/// q, v: (nodes x 3). map, modes: of Undeformed.
template <ElementKind kind, class Held>
MFS_INLINE void respond(const SolidConstants& c, const PointGradients<kind, Held>& cell,
                        const PointMaps<kind, Held>& map, const Modes<kind>& modes, const double* q,
                        const double* v, Response<kind, Held>& r) {
  const Enhancement<kind, Held> enhancement(modes, map);
  deform<kind>(cell, map, q, r.elastic);
  if (c.beta > 0) deform_rate<kind>(cell, map, v, r.elastic, r.rate);
  if (c.law == MaterialLaw::st_venant_kirchhoff) {
    // One law for both stresses: strains and rates are enhanced as one.
    PointVoigt<kind, Held> strain;
    for (int k = 0; k < 6; ++k)
      for (int p = 0; p < Held::count; ++p)
        strain.value[k][p] = r.elastic.strain[k][p] + (c.beta > 0 ? c.beta * r.rate.strain[k][p] : 0.0);
    enhancement.enhance_linear(c, strain.value);
    return hooke_stresses<kind>(c, strain.value, r.stress);
  }
  enhancement.enhance(c, r.elastic.strain);
  elastic_stresses<kind>(c, r.elastic.strain, r.stress);
  if (c.beta == 0) return;
  enhancement.enhance_linear(c, r.rate.strain);
  PointVoigt<kind, Held> viscous;
  hooke_stresses<kind>(c, r.rate.strain, viscous);
  for (int k = 0; k < 6; ++k)
    for (int p = 0; p < Held::count; ++p) r.stress.value[k][p] += c.beta * viscous.value[k][p];
}

/// add(node, i, f): adds f to direction i of the internal force, for the nodes whose sums this thread gets.
template <ElementKind kind, class Held, class Add>
MFS_INLINE void add_force(const SolidConstants& c, const PointGradients<kind, Held>& cell,
                          const PointMaps<kind, Held>& map, const Modes<kind>& modes, const double* q,
                          const double* v, const Add& add) {
  constexpr int points = Held::count;
  Response<kind, Held> r;
  respond<kind>(c, cell, map, modes, q, v, r);
  alignas(64) double first[3][3][points], in_cell[3][3][points];  // F S, times the weight; that for the cell
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a)
      for (int p = 0; p < points; ++p)
        first[i][a][p] = map.weight[p] * (r.elastic.f[3 * i][p] * r.stress.value[voigt_of(0, a)][p] +
                                          r.elastic.f[3 * i + 1][p] * r.stress.value[voigt_of(1, a)][p] +
                                          r.elastic.f[3 * i + 2][p] * r.stress.value[voigt_of(2, a)][p]);
  for (int i = 0; i < 3; ++i)
    for (int b = 0; b < 3; ++b)
      for (int p = 0; p < points; ++p)
        in_cell[i][b][p] = first[i][0][p] * map.inverse[3 * b][p] +
                           first[i][1][p] * map.inverse[3 * b + 1][p] +
                           first[i][2][p] * map.inverse[3 * b + 2][p];
  for (int i = 0; i < 3; ++i)
    Held::template sum_all<Sizes<kind>::nodes>(
        [&](int node) {
          double at_point[points], sum = 0;
          for (int p = 0; p < points; ++p)
            at_point[p] = in_cell[i][0][p] * cell.gradient[0][node][p] +
                          in_cell[i][1][p] * cell.gradient[1][node][p] +
                          in_cell[i][2][p] * cell.gradient[2][node][p];
          for (int p = 0; p < points; ++p) sum += at_point[p];
          return sum;
        },
        [&](int node, double sum) { add(node, i, sum); });
}

/// How a body resists acceleration, and what else acts on its mass: M (a + alpha v - g).
struct SolidInertia {
  bool lumped;
  double alpha;  ///< 1/s
  double gravity[3];

  /// What the mass is multiplied with, of one coordinate in direction k.
  MFS_INLINE double acceleration(double a, double v, int k) const { return a + alpha * v - gravity[k]; }

  /// Entries that are kept of the mass of an element: one for each node where it is lumped, else the lower
  /// triangle by rows.
  MFS_INLINE int entries(int nodes) const { return lumped ? nodes : nodes * (nodes + 1) / 2; }
  /// That of nodes i and j.
  MFS_INLINE double mass(const double* entries, int i, int j) const {
    if (lumped) return i == j ? entries[i] : 0.0;
    return entries[j <= i ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i];
  }

  /// Adds the forces on node i of an element to force (3). acceleration(j, k): that of node j in direction k.
  template <class Acceleration>
  MFS_INLINE void add_row(int i, int nodes, const double* entries, const Acceleration& acceleration,
                          double* force) const {
    for (int j = lumped ? i : 0; j < (lumped ? i + 1 : nodes); ++j) {
      const double m = mass(entries, i, j);
      for (int k = 0; k < 3; ++k) force[k] += m * acceleration(j, k);
    }
  }
};

}  // namespace mfs::dae
