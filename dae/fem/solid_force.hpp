// The force of one solid element (solid_kernels.hpp), compiled for the host and for a device. `Held` says
// which of the element's points the calling thread has (element_points.hpp).
#pragma once

#include "dae/fem/enhanced_strain.hpp"

namespace mfs::dae {

// Strains and stresses at the points of one element; rates and viscous stress where there is viscosity.
template <ElementKind kind, class Held = AllPoints<kind>>
struct Response {
  PointGradients<kind, Held> reference;
  Enhancement<kind, Held> enhancement;
  Deformation<kind, Held> elastic, rate;
  PointVoigt<kind, Held> stress;
};

/// cell: gradients on the reference cell; nodes, q, v: (nodes x 3).
template <ElementKind kind, class Held>
MFS_INLINE void respond(const SolidConstants& c, const PointGradients<kind, Held>& cell, const double* nodes,
                        const double* q, const double* v, Response<kind, Held>& r) {
  reference_gradients<kind>(cell, nodes, r.reference);
  r.enhancement.prepare(c, nodes, cell, r.reference);
  deform<kind>(r.reference, q, r.elastic);
  r.enhancement.enhance(c, r.elastic.strain);
  elastic_stresses<kind>(c, r.elastic.strain, r.stress);
  if (c.beta == 0) return;
  deform_rate<kind>(r.reference, v, r.elastic, r.rate);
  r.enhancement.enhance_linear(c, r.rate.strain);
  PointVoigt<kind, Held> viscous;
  hooke_stresses<kind>(c, r.rate.strain, viscous);
  for (int k = 0; k < 6; ++k)
    for (int p = 0; p < Held::count; ++p) r.stress.value[k][p] += c.beta * viscous.value[k][p];
}

// Row b of S at a point, as a function of the column: its place in Voigt order.
MFS_INLINE int voigt_of(int row, int column) {
  static constexpr int component[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  return component[row][column];
}

/// Adds the internal force to force (nodes x 3).
template <ElementKind kind, class Held>
MFS_INLINE void add_force(const SolidConstants& c, const PointGradients<kind, Held>& cell,
                          const double* nodes, const double* q, const double* v, double* force) {
  constexpr int points = Held::count;
  Response<kind, Held> r;
  respond<kind>(c, cell, nodes, q, v, r);
  alignas(64) double first[3][3][points];  // F S, times the weight
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a)
      for (int p = 0; p < points; ++p)
        first[i][a][p] =
            r.reference.weight[p] * (r.elastic.f[3 * i][p] * r.stress.value[voigt_of(0, a)][p] +
                                     r.elastic.f[3 * i + 1][p] * r.stress.value[voigt_of(1, a)][p] +
                                     r.elastic.f[3 * i + 2][p] * r.stress.value[voigt_of(2, a)][p]);
  for (int node = 0; node < Sizes<kind>::nodes; ++node)
    for (int i = 0; i < 3; ++i) {
      double at_point[points], sum = 0;
      for (int p = 0; p < points; ++p)
        at_point[p] = first[i][0][p] * r.reference.gradient[0][node][p] +
                      first[i][1][p] * r.reference.gradient[1][node][p] +
                      first[i][2][p] * r.reference.gradient[2][node][p];
      for (int p = 0; p < points; ++p) sum += at_point[p];
      force[3 * node + i] += Held::sum(sum);
    }
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
