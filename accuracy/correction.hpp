// The exact inverse in spite of perturbed pivots. Each perturbation added one number to one entry of A, so
// the factors belong to A' = A + U V^T with k columns, U = [amount_j e_row(j)], V = [e_column(j)], and
// (Woodbury)
//
//   A^-1 = A'^-1 + Z C^-1 V^T A'^-1,    Z = A'^-1 U,    C = I - V^T Z   (k x k, the capacitance matrix).
//
// A is singular exactly when C is, and of the same nullity: this is where "singular" is decided. With C q = 0
// the null vector of A is Z q, and it is tested as one: |A Z q| / | |A| |Z q| | is at least the reciprocal
// condition number of A. Its largest entry names a column that depends on the others. The singular
// values are those of C between scaled unknowns, D^-1 C D, with rows and columns of C that hold large entries
// scaled down to the identity's 1, so that they mean something. C is a difference of nearly equal numbers
// where A is singular, so the residuals that refine Z are summed in extended precision. For A^T the two ends
// of each perturbation change places.
//
// Z q is only as good as what cancels in the sum of Z's columns leaves, and where A is singular but for
// rounding, as good as the part that the null vector has of the perturbed unknowns. So it is made better on A
// itself before it is tested, which proves no less for that: by x - A^-1 A x, where C q is zero but for
// rounding, and where it is more (then that leaves nothing of x), by inverse iteration.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
#include <vector>

#include "accuracy/null_vectors.hpp"
#include "kernels/dense/blas.hpp"
#include "kernels/factors.hpp"

namespace mfs {

/// `amount` was added to entry (row, column) of A.
template <class Scalar>
struct Perturbation {
  Vertex row, column;
  Scalar amount;
};

/// The entry of x that is largest in scaled unknowns.
template <class Scalar>
Vertex largest_unknown(Vertex n, const Scalar* x, const double* scale) {
  Vertex best = 0;
  double most = -1;
  for (Vertex i = 0; i < n; ++i) {
    const double size = std::abs(x[i]) / scale[i];
    if (size > most) {
      most = size;
      best = i;
    }
  }
  return best;
}

template <class Exec, class Scalar>
class Correction {
 public:
  /// `inverse(x, columns)` puts A'^-1 X in the place of X, `at_once` columns at most,
  /// `inverse_of_transposed(x)` A'^-T x in the place of x.
  template <class Inverse, class InverseOfTransposed>
  Correction(const Exec& exec, Vertex n, std::vector<Perturbation<Scalar>> perturbations,
             const ScaledRows<Scalar>& a, Vertex at_once, const Inverse& inverse,
             const InverseOfTransposed& inverse_of_transposed)
      : exec_(exec), n_(n), perturbations_(std::move(perturbations)) {
    const std::size_t k = perturbations_.size(), block = static_cast<std::size_t>(at_once);
    for (const Perturbation<Scalar>& p : perturbations_)
      scale_.push_back(static_cast<RealOf<Scalar>>(a.scale[p.column]));
    z_.assign(static_cast<std::size_t>(n) * k, Scalar(0));
    for (std::size_t first = 0; first < k; first += block)
      solve_columns(first, std::min(block, k - first), inverse, a.rows);
    decompose(a.scale);
    if (usable_) find_null_vectors(a, inverse, inverse_of_transposed);
  }

  /// False where the numbers ran out of range: then there is no correction.
  bool usable() const { return usable_; }
  Vertex nullity() const { return nullity_; }
  /// |A z| / | |A||z| | of the first null vector.
  double singularity() const { return singularity_; }
  /// No null vector was found, but one that A makes so small that there may be.
  bool doubtful() const { return doubtful_; }
  int rank() const { return static_cast<int>(perturbations_.size()); }

  /// det C = phase * exp(log_abs): det A = det A' det C.
  void determinant(std::complex<double>& phase, double& log_abs) const {
    std::vector<std::complex<double>> c(capacitance_.begin(), capacitance_.end());
    const std::size_t k = perturbations_.size();
    phase = 1;
    log_abs = 0;
    for (std::size_t j = 0; j < k; ++j) {  // elimination with row interchanges: k is small
      std::size_t pivot = j;
      for (std::size_t i = j; i < k; ++i) {
        if (std::abs(c[i + j * k]) > std::abs(c[pivot + j * k])) pivot = i;
      }
      if (pivot != j) {
        for (std::size_t i = 0; i < k; ++i) std::swap(c[j + i * k], c[pivot + i * k]);
        phase = -phase;
      }
      const std::complex<double> value = c[j + j * k];
      log_abs += std::log(std::abs(value));
      phase *= value / std::abs(value);
      for (std::size_t i = j + 1; i < k; ++i) {
        const std::complex<double> factor = c[i + j * k] / value;
        for (std::size_t l = j + 1; l < k; ++l) c[i + l * k] -= factor * c[j + l * k];
      }
    }
  }

  /// x := A^-1 b, given x = A'^-1 b.
  void apply(Scalar* x) { correct(x, singular_, perturbations_.size()); }

  /// The unknown with the largest entry, in scaled unknowns, of the first null vector.
  Vertex dependent_unknown() const { return dependent_unknown_; }

  /// V p with C^T p = 0: A'^-T of it is the null vector of A^T.
  void left_null_source(Scalar* out) const { left_null_source(0, out); }

  std::size_t bytes() const { return z_.size() * sizeof(Scalar); }

 private:
  // x += Z C^-1 V^T x, of C^-1 the part that belongs to so many of the largest singular values.
  void correct(Scalar* x, const std::vector<double>& singular, std::size_t count) {
    const std::size_t k = perturbations_.size();
    for (std::size_t i = 0; i < k; ++i)
      at_columns_[i] = x[perturbations_[i].column] / scale_[i] * down_rows_[i];
    // C^-1 = columns V diag(1 / singular) U^H rows
    for (std::size_t i = 0; i < count; ++i) {
      Wide<Scalar> sum = 0;
      for (std::size_t j = 0; j < k; ++j)
        sum += Wide<Scalar>(conjugated(left_[j + i * k])) * Wide<Scalar>(at_columns_[j]);
      rotated_[i] = sum / singular[i];
    }
    for (std::size_t i = 0; i < k; ++i) {
      Wide<Scalar> sum = 0;
      for (std::size_t j = 0; j < count; ++j)
        sum += Wide<Scalar>(conjugated(right_[j + i * k])) * rotated_[j];
      add_column(i, static_cast<Scalar>(sum), x);
    }
  }

  // x += part of the column i of Z, as it is scaled in C.
  void add_column(std::size_t i, Scalar part, Scalar* x) const {
    const Scalar factor = part * (down_columns_[i] * scale_[i]);
    const Scalar* z = z_.data() + i * static_cast<std::size_t>(n_);
    for (Vertex row = 0; row < n_; ++row) x[row] += factor * z[row];
  }

  std::size_t place(Vertex order) const {
    return perturbations_.size() - 1 - static_cast<std::size_t>(order);
  }

  // One vector after another, each orthogonal to those before, so that each shows one dependent row more.
  template <class Inverse, class InverseOfTransposed>
  void find_null_vectors(const ScaledRows<Scalar>& a, const Inverse& inverse,
                         const InverseOfTransposed& inverse_of_transposed) {
    std::vector<std::vector<Scalar>> found;
    while (nullity_ < rank()) {
      std::vector<Scalar> x = null_candidate(a);
      if (!refine_null_vector(a, inverse, inverse_of_transposed, found, x)) return;
      const auto smaller = [](const Scalar& one, const Scalar& other) {
        return std::abs(one) < std::abs(other);
      };
      if (nullity_ == 0) {
        dependent_unknown_ = static_cast<Vertex>(std::max_element(x.begin(), x.end(), smaller) - x.begin());
        singularity_ = smallness_;
      }
      doubtful_ = false;
      found.push_back(std::move(x));
      ++nullity_;
    }
  }

  // Z q for the singular vector q of the smallest singular value whose null vector has not been found.
  std::vector<Scalar> null_candidate(const ScaledRows<Scalar>& a) const {
    const std::size_t k = perturbations_.size();
    std::vector<Scalar> x(static_cast<std::size_t>(n_), Scalar(0));
    for (std::size_t i = 0; i < k; ++i) add_column(i, conjugated(right_[place(nullity_) + i * k]), x.data());
    for (std::size_t u = 0; u < x.size(); ++u) x[u] /= static_cast<RealOf<Scalar>>(a.scale[u]);
    return x;
  }

  // |A x| <= kSingular | |A| |x| | in scaled rows proves that the scaled A has a reciprocal condition number
  // of at most kSingular (maximum norm), and so in balanced rows. True if x comes to that; a refined x must
  // come to rounding, because other scales may give a somewhat better condition. Refinement gains less than
  // the condition of A', so A is regular beyond doubt where x is above kDoubt.
  template <class Inverse, class InverseOfTransposed>
  bool refine_null_vector(const ScaledRows<Scalar>& a, const Inverse& inverse,
                          const InverseOfTransposed& inverse_of_transposed,
                          const std::vector<std::vector<Scalar>>& found, std::vector<Scalar>& x) {
    constexpr double kEpsilon = std::numeric_limits<RealOf<Scalar>>::epsilon();
    constexpr double kSingular = singular_below<Scalar>(), kRefined = kSingular / 10;  // double: 1e-14, 1e-15
    constexpr int kSteps = 3;
    const double kDoubt = std::sqrt(kEpsilon);
    std::vector<Scalar> d(x.size());
    bool iterated = false;
    for (int step = 0; step <= kSteps; ++step) {
      normalize(x);
      for (const std::vector<Scalar>& other : found) subtract_projection(other, x);
      if (!(normalize(x) > kDoubt)) return false;  // rounding of what was found before
      const double bound = step == 0 ? kSingular : kRefined;
      smallness_ = null_measure(exec_, a, bound, x, d);
      if (smallness_ <= bound) return true;
      if (!(smallness_ <= kDoubt)) return false;
      doubtful_ = nullity_ == 0;
      solve_scaled(a, inverse, d);
      if (largest_size(d) <= 0.5 * largest_size(x)) {
        add(d, x);
      } else if (!std::exchange(iterated, true)) {
        x = inverse_iterate(a, inverse, inverse_of_transposed);
      } else {
        return false;  // it would find the same
      }
    }
    return false;
  }

  // A^-1 l, refined once, for the left null vector l: a vector of the other space that is as orthogonal to
  // A's image as can be had.
  template <class Inverse, class InverseOfTransposed>
  std::vector<Scalar> inverse_iterate(const ScaledRows<Scalar>& a, const Inverse& inverse,
                                      const InverseOfTransposed& inverse_of_transposed) {
    std::vector<Scalar> left(static_cast<std::size_t>(n_)), r(left.size());
    left_null_source(nullity_, left.data());
    inverse_of_transposed(left.data());
    for (Scalar& entry : left) entry = conjugated(entry);
    const auto unscale_rows = [&] {
      for (std::size_t i = 0; i < left.size(); ++i) left[i] /= static_cast<RealOf<Scalar>>(a.row_scale[i]);
    };
    unscale_rows();  // l of scaled rows,
    normalize(left);
    unscale_rows();  // and the same as a right-hand side of A
    std::vector<Scalar> x = left;
    solve_scaled(a, inverse, x);
    scaled_residual(exec_, a, left, x, r);
    solve_scaled(a, inverse, r);
    add(r, x);
    return x;
  }

  // x := A^-1 x in scaled unknowns, without the null vectors that were found.
  template <class Inverse>
  void solve_scaled(const ScaledRows<Scalar>& a, const Inverse& inverse, std::vector<Scalar>& x) {
    inverse(x.data(), 1);
    correct(x.data(), bounded_, place(nullity_) + 1);
    for (std::size_t u = 0; u < x.size(); ++u) x[u] /= static_cast<RealOf<Scalar>>(a.scale[u]);
  }

  static void add(const std::vector<Scalar>& d, std::vector<Scalar>& x) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += d[i];
  }

  void left_null_source(Vertex order, Scalar* out) const {
    const std::size_t k = perturbations_.size();
    std::fill(out, out + n_, Scalar(0));
    for (std::size_t i = 0; i < k; ++i)
      out[perturbations_[i].column] = conjugated(left_[i + place(order) * k]) * (down_rows_[i] / scale_[i]);
  }

  // Columns of Z, refined.
  template <class Inverse>
  void solve_columns(std::size_t first, std::size_t columns, const Inverse& inverse,
                     const RowAccess<Scalar>& rows) {
    constexpr int kSteps = 2;
    const std::size_t n = static_cast<std::size_t>(n_);
    Scalar* z = z_.data() + first * n;
    for (std::size_t j = 0; j < columns; ++j)
      z[perturbations_[first + j].row + j * n] = perturbations_[first + j].amount;
    inverse(z, static_cast<Vertex>(columns));
    std::vector<Scalar> residual(n * columns);
    for (int step = 0; step < kSteps; ++step) {
      for (std::size_t j = 0; j < columns; ++j) residual_of_column(rows, first + j, residual.data() + j * n);
      inverse(residual.data(), static_cast<Vertex>(columns));
      for (std::size_t i = 0; i < residual.size(); ++i) z[i] += residual[i];
    }
  }

  // r = U - A' Z for one column, A' = A + sum of the perturbations.
  void residual_of_column(const RowAccess<Scalar>& rows, std::size_t column, Scalar* r) const {
    const Scalar* z = z_.data() + column * static_cast<std::size_t>(n_);
    std::vector<Extended<Scalar>> sum(static_cast<std::size_t>(n_));
    for_each_index(exec_, "correction", n_, [&](Offset i) {
      for (Offset k = rows.offsets[i]; k < rows.offsets[i + 1]; ++k) {
        const Scalar value = rows.values[rows.slots ? rows.slots[k] : k];
        sum[i] -= Extended<Scalar>(value) * Extended<Scalar>(z[rows.columns[k]]);
      }
    });
    const Perturbation<Scalar>& own = perturbations_[column];
    sum[own.row] += Extended<Scalar>(own.amount);
    for (const Perturbation<Scalar>& p : perturbations_)
      sum[p.row] -= Extended<Scalar>(p.amount) * Extended<Scalar>(z[p.column]);
    for (Vertex i = 0; i < n_; ++i) r[i] = static_cast<Scalar>(sum[i]);
  }

  void decompose(const double* scale) {
    const std::size_t k = perturbations_.size();
    std::vector<Scalar> c(k * k);
    for (std::size_t j = 0; j < k; ++j) {
      for (std::size_t i = 0; i < k; ++i) {
        const Scalar entry = z_[j * static_cast<std::size_t>(n_) + perturbations_[i].column];
        c[i + j * k] = Scalar(i == j ? 1 : 0) - entry * (scale_[j] / scale_[i]);
      }
    }
    singular_.resize(k);
    left_.resize(k * k);
    right_.resize(k * k);
    at_columns_.resize(k);
    rotated_.resize(k);
    capacitance_ = c;
    usable_ =
        std::all_of(c.begin(), c.end(), [](const Scalar& entry) { return std::isfinite(std::abs(entry)); });
    if (!usable_) return;  // LAPACK does not come back from NaN
    scale_down(c, scale);
    const int info = blas::singular_values(static_cast<Vertex>(k), c.data(), singular_.data(), left_.data(),
                                           right_.data());
    usable_ = info == 0;
    if (usable_) bound_singular_values();
  }

  // From below by their rounding, which is that of the columns of C, scaled to entries of at most 1: the
  // inverse of anything smaller is noise.
  void bound_singular_values() {
    constexpr double kEpsilon = std::numeric_limits<RealOf<Scalar>>::epsilon();
    const std::size_t k = perturbations_.size();
    bounded_ = singular_;
    for (std::size_t j = 0; j < k; ++j) {
      double sum = 0;
      for (std::size_t i = 0; i < k; ++i)
        sum += std::norm(std::complex<double>(left_[i + j * k]) * double(down_rows_[i]));
      bounded_[j] = std::max(singular_[j], static_cast<double>(k) * kEpsilon * std::sqrt(sum));
    }
  }

  // Rows, then columns, whose largest entry is above 1 are brought down to it, columns with that of Z (both
  // in scaled unknowns). Smaller ones may hold nothing but rounding.
  void scale_down(std::vector<Scalar>& c, const double* scale) {
    const std::size_t k = perturbations_.size();
    const auto brought_down = [](double largest) {
      return static_cast<RealOf<Scalar>>(largest > 1 ? std::ldexp(1.0, -std::ilogb(largest)) : 1.0);
    };
    for (const bool by_rows : {true, false}) {
      std::vector<RealOf<Scalar>>& down = by_rows ? down_rows_ : down_columns_;
      std::vector<double> largest(k, 0.0);
      for (std::size_t i = 0; i < k * k; ++i) {
        double& most = largest[by_rows ? i % k : i / k];
        most = std::max<double>(most, std::abs(c[i]));
      }
      for (std::size_t j = 0; j < k && !by_rows; ++j) {
        const Scalar* z = z_.data() + j * static_cast<std::size_t>(n_);
        for (Vertex row = 0; row < n_; ++row)
          largest[j] = std::max(largest[j], std::abs(z[row]) / scale[row] * scale_[j]);
      }
      down.resize(k);
      std::transform(largest.begin(), largest.end(), down.begin(), brought_down);
      for (std::size_t i = 0; i < k * k; ++i) c[i] *= down[by_rows ? i % k : i / k];
    }
  }

  Exec exec_;
  Vertex n_;
  std::vector<Perturbation<Scalar>> perturbations_;
  std::vector<RealOf<Scalar>> scale_;                     // of the unknown of each perturbation
  std::vector<Scalar> z_;                                 // n x k
  std::vector<Scalar> capacitance_;                       // C between scaled unknowns, k x k
  std::vector<RealOf<Scalar>> down_rows_, down_columns_;  // of C, k each
  std::vector<double> singular_;                          // of C as scaled down; k, descending
  std::vector<double> bounded_;                           // the same, at least their rounding
  std::vector<Scalar> left_, right_;                      // U and V^H of C, k x k
  std::vector<Scalar> at_columns_;                        // work
  std::vector<Wide<Scalar>> rotated_;                     // work
  Vertex nullity_ = 0, dependent_unknown_ = -1;
  double smallness_ = 0, singularity_ = 0;
  bool usable_ = false, doubtful_ = false;
};

}  // namespace mfs
