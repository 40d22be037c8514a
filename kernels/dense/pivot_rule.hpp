// When a pivot is too small, and what becomes of it: one rule for the host and for every device.
#pragma once

#include <cmath>
#include <limits>

#include "kernels/runtime/scalars.hpp"

namespace mfs {

/// A suspect pivot is still accepted when it is at least this fraction of what lies below it in the border:
/// then dividing by it lets nothing grow.
constexpr double kBorderThreshold = 0.01;

/// A pivot of at most this many square roots of machine epsilon relative to the largest scaled entry may be a
/// rounded zero: rounding errors are divided by the small pivots before it, so no multiple of epsilon itself
/// is a bound. It is perturbed, and the exact correction of the solve (kernels/correction.hpp) finds out.
/// Accepting pivots from 5000 epsilons on let one singular matrix in 25 000 through.
constexpr double kTinyPivot = 1;

/// What tiny pivots are taken for. There may be too many for the exact correction where A is badly
/// conditioned as a whole: stiffness of very different size in one node, volume against shape, gradients
/// under a curl. Then they are divided by, as partial pivoting does, and a probe of the factors finds out
/// whether A is singular.
enum class TinyPivots {
  noise,  // perturbed
  data,   // accepted; a column that holds nothing gets a pivot of rounding's size, so that the probe sees it
};

/// Where tiny pivots are divided by, the entry on the diagonal counts so many times its size, a power of two,
/// when a pivot is searched: threshold pivoting that prefers the diagonal (Duff, Erisman and Reid, Direct
/// Methods for Sparse Matrices, 2017, section 5.2). Matrices with many tiny pivots are symmetric and
/// definite, or nearly so, as a rule. There nothing grows by pivots on the diagonal, however small they are,
/// while exchanges of rows mix what is large in A with what is small. Where A looks definite, rows are
/// exchanged for what rounding may have left alone. Factors between the two cost accuracy where blocks of L
/// are inverted (docs/experiments/accuracy.md).
constexpr double kDiagonalPreference = 8, kDefinitePreference = 1 << 20;

/// What the rule of a factorization is made of: `tolerance` relative to the largest scaled entry, and the
/// part of its border that a suspect pivot must have to be accepted.
struct PivotPolicy {
  PivotPolicy(double tolerance) : tolerance(tolerance) {}  // of noise, as nothing else is said
  PivotPolicy(double tolerance, TinyPivots tiny, double border_part)
      : tolerance(tolerance),
        tiny(tiny),
        border_part(border_part),
        preference(tiny == TinyPivots::data ? kDiagonalPreference : 1) {}
  double tolerance;
  TinyPivots tiny = TinyPivots::noise;
  double border_part = kBorderThreshold;
  double preference = 1;  // of the diagonal
  /// A = A^T but for rounding. Then factors that substitute with U and multiply by inverses of L solve with
  /// their transposes, where U comes first: what products lose before it, it makes larger where tiny pivots
  /// are divided by, and what they lose behind it stays small.
  bool symmetric = false;
  /// Factors with more perturbed pivots are of no use: they are not made again with fronts that are strict.
  unsigned long long most_perturbed = std::numeric_limits<unsigned long long>::max();

  /// Whether kernels that multiply by inverses of U's diagonal blocks substitute with them instead: the
  /// errors of such products grow with the condition of a block, which is large where its pivots are tiny.
  bool substitutes() const { return tiny == TinyPivots::data; }
  /// Not where pivots were perturbed: those are factors of another matrix, which need not be symmetric.
  bool solves_by_transposed(unsigned long long perturbed) const {
    return symmetric && substitutes() && perturbed == 0;
  }
  bool operator==(const PivotPolicy& other) const {
    return tolerance == other.tolerance && tiny == other.tiny && border_part == other.border_part &&
           preference == other.preference;
  }
};

/// When a pivot is too small, and what takes its place. All sizes are absolute.
struct PivotRule {
  double bound = 0;      // below it a pivot is suspect
  double tiny = 0;       // up to it a pivot may be nothing but rounding
  double dependent = 1;  // what it becomes where its column holds nothing but rounding
  double border_part = kBorderThreshold;
  double preference = 1;  // times its size the entry on the diagonal counts when a pivot is searched

  KOKKOS_INLINE_FUNCTION PivotRule times(double largest) const {
    return {bound * largest, tiny * largest, dependent * largest, border_part, preference};
  }
};

/// The rule for factors of Real.
template <class Real>
PivotRule pivot_rule(const PivotPolicy& policy, double largest) {
  const double epsilon = std::numeric_limits<Real>::epsilon();
  const bool noise = policy.tiny == TinyPivots::noise;
  const double tiny = noise ? kTinyPivot * std::sqrt(epsilon) : epsilon;
  return PivotRule{policy.tolerance, tiny, noise ? 1 : epsilon, policy.border_part, policy.preference}.times(
      largest);
}

/// A column whose border is below this many times `tiny` holds nothing but rounding there.
constexpr double kEmptyBorder = 10;

/// Whether a pivot of this size below the bound stays as it is. `border`: the largest entry of its column in
/// the border.
KOKKOS_INLINE_FUNCTION bool is_accepted(double size, double border, const PivotRule& rule) {
  return size > rule.tiny && size >= rule.border_part * border;
}
/// The size that it gets where it does not.
KOKKOS_INLINE_FUNCTION double size_instead(double size, double border, const PivotRule& rule) {
  const bool dependent = size <= rule.tiny && border <= kEmptyBorder * rule.tiny;
  return dependent ? rule.dependent : rule.bound;
}

template <class S>
KOKKOS_INLINE_FUNCTION S perturbed_pivot(S pivot, double wanted) {
  using Real = RealOf<S>;
  const double size = magnitude(pivot);
  return size > 0 ? pivot * static_cast<Real>(wanted / size) : S(static_cast<Real>(wanted));
}
/// What becomes of a pivot below the bound, as kernels compute it.
template <class S>
KOKKOS_INLINE_FUNCTION S replacement(S pivot, double border, const PivotRule& rule) {
  const double size = magnitude(pivot);
  return is_accepted(size, border, rule) ? pivot : perturbed_pivot(pivot, size_instead(size, border, rule));
}

}  // namespace mfs
