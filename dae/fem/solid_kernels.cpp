#include "dae/fem/solid_kernels.hpp"

#include "dae/fem/row_product.hpp"
#include "dae/fem/solid_tangent.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs::dae {

namespace {

template <ElementKind kind>
MFS_INLINE void force_of(const SolidConstants& c, const double* nodes, const double* q, const double* v,
                         double* force) {
  Undeformed<kind> undeformed;
  undeform<kind>(c, cell_gradients<kind>(), nodes, undeformed);
  add_force<kind>(c, cell_gradients<kind>(), undeformed.map, undeformed.modes, q, v,
                  [&](int node, int i, double sum) { force[3 * node + i] += sum; });
}

// Rows of solid_tangent.hpp, kept until all are there: force_q += left^T by_q over `count_q` of them, force_v
// += left^T by_v over `count_v`.
template <ElementKind kind>
struct KeptRows {
  static constexpr int stride = Sizes<kind>::stride;
  static constexpr int most = 6 * Sizes<kind>::points + 2 * Modes<kind>::count;
  int count_q = 0, count_v = 0;
  alignas(64) double kept_left[most * stride], kept_by_q[most * stride], kept_by_v[most * stride];

  MFS_INLINE double* left() { return kept_left + count_q * stride; }
  MFS_INLINE double* by_q() { return kept_by_q + count_q * stride; }
  MFS_INLINE double* by_v() { return kept_by_v + count_q * stride; }
  template <int count>
  MFS_INLINE void take(bool with_by_v) {
    count_q += count;
    if (with_by_v) count_v = count_q;
  }
};

// The share of the stress in force_q: int grad N_i . S grad N_j dV in each direction.
template <ElementKind kind>
MFS_INLINE void add_initial_stress(const TangentState<kind>& s, double* force_q) {
  constexpr int nodes = Sizes<kind>::nodes, points = Sizes<kind>::points, stride = Sizes<kind>::node_stride;
  alignas(64) double left[3 * points * stride] = {}, right[3 * points * stride] = {};
  for (int p = 0; p < points; ++p)
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < nodes; ++i) {
        left[(3 * p + a) * stride + i] = s.reference.gradient[a][i][p];
        right[(3 * p + a) * stride + i] = stressed_gradient<kind>(s, p, a, i);
      }
  alignas(64) double product[nodes * stride];
  row_product<nodes % 4 == 0 ? 4 : 5, nodes, stride>(3 * points, left, right, true, product);
  for (int i = 0; i < nodes; ++i)
    for (int j = 0; j < nodes; ++j)
      for (int k = 0; k < 3; ++k)
        force_q[(3 * i + k) * 3 * nodes + 3 * j + k] += product[i <= j ? i * stride + j : j * stride + i];
}

// matrix (by rows, no padding) += product, of which only the upper triangle may be there.
template <int n, int stride>
MFS_INLINE void add_matrix(const double* product, bool symmetric, double* matrix) {
  for (int i = 0; i < n; ++i) {
    for (int j = symmetric ? i : 0; j < n; ++j) matrix[i * n + j] += product[i * stride + j];
    if (symmetric)
      for (int j = 0; j < i; ++j) matrix[i * n + j] += product[j * stride + i];
  }
}

template <ElementKind kind>
MFS_INLINE void tangent_of(const SolidConstants& c, const double* nodes, const double* q, const double* v,
                           double* force_q, double* force_v) {
  constexpr int n = Sizes<kind>::unknowns, stride = Sizes<kind>::stride;
  Undeformed<kind> undeformed;
  TangentState<kind> state;
  KeptRows<kind> rows;
  alignas(64) double product[n * stride];
  undeform<kind>(c, cell_gradients<kind>(), nodes, undeformed);
  prepare_tangent<kind>(c, cell_gradients<kind>(), undeformed.map, undeformed.modes, q, v, state);
  tangent_rows<kind, AllColumns<kind>>(c, undeformed.modes, state, rows);

  if (force_q != nullptr) {
    const bool symmetric = c.beta == 0;
    row_product<6, n, stride>(rows.count_q, rows.kept_left, rows.kept_by_q, symmetric, product);
    add_matrix<n, stride>(product, symmetric, force_q);
    add_initial_stress<kind>(state, force_q);
  }
  if (c.beta == 0 || force_v == nullptr) return;
  row_product<6, n, stride>(rows.count_v, rows.kept_left, rows.kept_by_v, true, product);
  add_matrix<n, stride>(product, true, force_v);
}

template <ElementKind kind>
MFS_INLINE void cauchy_of(SolidConstants c, const double* nodes, const double* q, double* stress) {
  c.beta = 0;
  Undeformed<kind> undeformed;
  Response<kind> r;
  undeform<kind>(c, cell_gradients<kind>(), nodes, undeformed);
  respond<kind>(c, cell_gradients<kind>(), undeformed.map, undeformed.modes, q, nullptr, r);
  const auto& f = r.elastic.f;
  for (int p = 0; p < Sizes<kind>::points; ++p)
    for (int k = 0; k < 6; ++k) {
      double sum = 0;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          sum += f[3 * voigt(k, 0) + a][p] * r.stress.value[voigt_of(a, b)][p] * f[3 * voigt(k, 1) + b][p];
      stress[6 * p + k] = sum / determinant_at(f, p);
    }
}

template <ElementKind kind>
MFS_INLINE double energy_of(SolidConstants c, const double* nodes, const double* q) {
  c.beta = 0;
  Undeformed<kind> undeformed;
  Response<kind> r;
  undeform<kind>(c, cell_gradients<kind>(), nodes, undeformed);
  respond<kind>(c, cell_gradients<kind>(), undeformed.map, undeformed.modes, q, nullptr, r);
  double sum = 0;
  for (int p = 0; p < Sizes<kind>::points; ++p) {
    double strain[6], density = 0;
    for (int k = 0; k < 6; ++k) {
      strain[k] = r.elastic.strain[k][p];
      // The linear law's strains are here without their enhancement, which does no work on the stress.
      density += 0.5 * strain[k] * r.stress.value[k][p];
    }
    if (c.law == MaterialLaw::neo_hookean) density = neo_hookean_energy(c, strain);
    sum += undeformed.map.weight[p] * density;
  }
  return sum;
}

}  // namespace

// The three kinds of one operation, each compiled for several levels of the processor.
#define MFS_FOR_EACH_KIND(operation, ...)                \
  switch (kind) {                                        \
    case ElementKind::hex8:                              \
      return operation<ElementKind::hex8>(__VA_ARGS__);  \
    case ElementKind::hex20:                             \
      return operation<ElementKind::hex20>(__VA_ARGS__); \
    case ElementKind::tet10:                             \
      return operation<ElementKind::tet10>(__VA_ARGS__); \
  }

MFS_SIMD_CLONES void add_internal_force(ElementKind kind, const SolidConstants& constants,
                                        const double* nodes, const double* q, const double* v, double* force){
    MFS_FOR_EACH_KIND(force_of, constants, nodes, q, v, force)}

MFS_SIMD_CLONES
    void add_internal_tangent(ElementKind kind, const SolidConstants& constants, const double* nodes,
                              const double* q, const double* v, double* force_q, double* force_v){
        MFS_FOR_EACH_KIND(tangent_of, constants, nodes, q, v, force_q, force_v)}

MFS_SIMD_CLONES double stored_energy(ElementKind kind, const SolidConstants& constants, const double* nodes,
                                     const double* q) {
  MFS_FOR_EACH_KIND(energy_of, constants, nodes, q)
  return kNaN;
}

MFS_SIMD_CLONES void point_stress(ElementKind kind, const SolidConstants& constants, const double* nodes,
                                  const double* q, double* stress) {
  MFS_FOR_EACH_KIND(cauchy_of, constants, nodes, q, stress)
}

}  // namespace mfs::dae
