#include "dae/fem/solid_kernels.hpp"

#include "dae/fem/row_product.hpp"
#include "dae/fem/solid_force.hpp"
#include "kernels/simd_clones.hpp"

namespace mfs::dae {

namespace {

template <ElementKind kind>
MFS_INLINE void force_of(const SolidConstants& c, const double* nodes, const double* q, const double* v,
                         double* force) {
  add_force<kind>(c, cell_gradients<kind>(), nodes, q, v, force);
}

// The rows whose products are the material parts of the derivatives: force_q += left^T by_q over `count_q`
// rows, force_v += left^T by_v over `count_v` rows. Six rows of every point come first, those of the modes
// follow.
template <ElementKind kind>
struct TangentRows {
  static constexpr int stride = Sizes<kind>::stride;
  static constexpr int strains = 6 * Sizes<kind>::points;
  static constexpr int most = strains + 2 * Enhancement<kind>::modes;
  int count_q = strains, count_v = strains;
  alignas(64) double left[most * stride], by_q[most * stride], by_v[most * stride];
};

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
    scale_rows<1, stride>(-scale / factors.l[m][m], rows + m * stride, out + m * stride);
}

// Stresses of each point by the unknowns, and their moments for the modes.
template <ElementKind kind>
struct StressRows {
  static constexpr int stride = Sizes<kind>::stride;
  alignas(64) double value[6 * stride];
  RowMoments<kind> moments;

  MFS_INLINE void add_moments(const Enhancement<kind>& enhancement, int p) {
    if constexpr (Enhancement<kind>::modes > 0) enhancement.add_moments(p, value, moments);
  }
  MFS_INLINE void set(const double* d, const double* strain_rows, const Enhancement<kind>& enhancement,
                      int p) {
    stiffness_times<stride>(d, strain_rows, value);
    add_moments(enhancement, p);
  }
  MFS_INLINE void set_by_hooke(const SolidConstants& c, const double* strain_rows,
                               const Enhancement<kind>& enhancement, int p) {
    hooke_times<stride>(c, strain_rows, value);
    add_moments(enhancement, p);
  }
  // L^-1 int M^T (rows) dV: the modes' coupling with the unknowns, half eliminated.
  MFS_INLINE void couple(const ModeFactors& factors, const Enhancement<kind>& enhancement,
                         double* out) const {
    enhancement.mode_rows(moments, out);
    factors.template forward<stride>(out);
  }
};

// What the rows are made of. Where the law is Hooke's, stresses by the positions are those by the velocities,
// but for beta, and `by_velocity` is not used.
template <ElementKind kind>
struct TangentStress {
  bool linear;
  PointStiffness<kind> stiffness;
  StressRows<kind> elastic, by_velocity, by_position;  ///< the last two: viscous

  MFS_INLINE const StressRows<kind>& viscous() const { return linear ? elastic : by_velocity; }
};

// by_q += the viscous stress by the positions, by_v = the same by the velocities, at point p.
template <ElementKind kind>
MFS_INLINE void add_viscous_rows(const SolidConstants& c, const Response<kind>& r, int p,
                                 TangentStress<kind>& stress, TangentRows<kind>& t) {
  constexpr int stride = Sizes<kind>::stride;
  const int row = 6 * p * stride;
  const double weight = c.beta * r.reference.weight[p];
  alignas(64) double rate_rows[6 * stride];
  strain_rows<kind>(r.reference, r.rate, p, rate_rows);
  stress.by_position.set_by_hooke(c, rate_rows, r.enhancement, p);
  for (int n = 0; n < 6 * stride; ++n) t.by_q[row + n] += weight * stress.by_position.value[n];
  if (!stress.linear) stress.by_velocity.set_by_hooke(c, t.left + row, r.enhancement, p);
  scale_rows<6, stride>(weight, stress.viscous().value, t.by_v + row);
}

// The rows of the modes that Hooke's law, and that of the elastic stress, condense into.
template <ElementKind kind>
MFS_INLINE void add_mode_rows(const SolidConstants& c, const Response<kind>& r,
                              const TangentStress<kind>& stress, TangentRows<kind>& t) {
  constexpr int stride = Sizes<kind>::stride;
  const ModeFactors& hooke = r.enhancement.linear;
  if (c.beta > 0) {
    double *left = t.left + t.count_v * stride, *by_q = t.by_q + t.count_v * stride;
    stress.viscous().couple(hooke, r.enhancement, left);
    divide_modes<stride>(hooke, c.beta, left, t.by_v + t.count_v * stride);
    stress.by_position.couple(hooke, r.enhancement, by_q);
    if (stress.linear)
      for (int n = 0; n < kModes * stride; ++n) by_q[n] = c.beta * by_q[n] + left[n];
    divide_modes<stride>(hooke, stress.linear ? 1.0 : c.beta, by_q, by_q);
    t.count_q = t.count_v += kModes;
    if (stress.linear) return;
  }
  ModeFactors factors = hooke;
  if (!stress.linear) r.enhancement.factor(stress.stiffness, factors);
  double* left = t.left + t.count_q * stride;
  stress.elastic.couple(factors, r.enhancement, left);
  divide_modes<stride>(factors, 1.0, left, t.by_q + t.count_q * stride);
  t.count_q += kModes;
}

template <ElementKind kind>
MFS_INLINE void material_rows(const SolidConstants& c, const Response<kind>& r, TangentRows<kind>& t) {
  constexpr int stride = Sizes<kind>::stride;
  TangentStress<kind> stress;
  stiffnesses<kind>(c, r.elastic.strain, stress.stiffness);
  stress.linear = stress.stiffness.same;
  for (int p = 0; p < Sizes<kind>::points; ++p) {
    double* left = t.left + 6 * p * stride;
    strain_rows<kind>(r.reference, r.elastic, p, left);
    if (stress.linear)
      stress.elastic.set_by_hooke(c, left, r.enhancement, p);
    else
      stress.elastic.set(stress.stiffness.at(p), left, r.enhancement, p);
    scale_rows<6, stride>(r.reference.weight[p], stress.elastic.value, t.by_q + 6 * p * stride);
    if (c.beta > 0) add_viscous_rows<kind>(c, r, p, stress, t);
  }
  if constexpr (Enhancement<kind>::modes > 0) add_mode_rows<kind>(c, r, stress, t);
}

// The share of the stress in force_q: int grad N_i . S grad N_j dV in each direction.
template <ElementKind kind>
MFS_INLINE void add_initial_stress(const Response<kind>& r, double* force_q) {
  constexpr int nodes = Sizes<kind>::nodes, points = Sizes<kind>::points, stride = Sizes<kind>::node_stride;
  alignas(64) double left[3 * points * stride] = {}, right[3 * points * stride] = {};
  for (int p = 0; p < points; ++p)
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < nodes; ++i) {
        double sum = 0;
        for (int b = 0; b < 3; ++b) sum += r.stress.value[voigt_of(a, b)][p] * r.reference.gradient[b][i][p];
        left[(3 * p + a) * stride + i] = r.reference.gradient[a][i][p];
        right[(3 * p + a) * stride + i] = r.reference.weight[p] * sum;
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
  Response<kind> r;
  TangentRows<kind> rows;
  alignas(64) double product[n * stride];
  respond<kind>(c, cell_gradients<kind>(), nodes, q, v, r);
  material_rows<kind>(c, r, rows);

  if (force_q != nullptr) {
    const bool symmetric = c.beta == 0;
    row_product<6, n, stride>(rows.count_q, rows.left, rows.by_q, symmetric, product);
    add_matrix<n, stride>(product, symmetric, force_q);
    add_initial_stress<kind>(r, force_q);
  }
  if (c.beta == 0 || force_v == nullptr) return;
  row_product<6, n, stride>(rows.count_v, rows.left, rows.by_v, true, product);
  add_matrix<n, stride>(product, true, force_v);
}

template <ElementKind kind>
MFS_INLINE void cauchy_of(SolidConstants c, const double* nodes, const double* q, double* stress) {
  c.beta = 0;
  Response<kind> r;
  respond<kind>(c, cell_gradients<kind>(), nodes, q, nullptr, r);
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

MFS_SIMD_CLONES void point_stress(ElementKind kind, const SolidConstants& constants, const double* nodes,
                                  const double* q, double* stress) {
  MFS_FOR_EACH_KIND(cauchy_of, constants, nodes, q, stress)
}

}  // namespace mfs::dae
