// The exact inverse in spite of perturbed pivots. Each perturbation added one number to one entry of A, so
// the factors belong to A' = A + U V^T with k columns, U = [amount_j e_row(j)], V = [e_column(j)], and
// (Woodbury)
//
//   A^-1 = A'^-1 + Z C^-1 V^T A'^-1,    Z = A'^-1 U,    C = I - V^T Z   (k x k, the capacitance matrix).
//
// A is singular exactly when C is, and of the same nullity: this is where "singular" is decided. With C q = 0
// the null vector of A is Z q, and it is judged as one: |A Z q| / | |A| |Z q| | is at least the reciprocal
// condition number of A. Its largest entry names a column that depends on the others. The singular
// values are those of C between scaled unknowns, D^-1 C D, with rows and columns of C that hold large entries
// scaled down to the identity's 1, so that they mean something. C is a difference of nearly equal numbers
// where A is singular, so the residuals that refine Z are summed in extended precision. For A^T the two ends
// of each perturbation change places.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "kernels/blas.hpp"
#include "kernels/factorization.hpp"
#include "kernels/residual.hpp"
#include "kernels/vector_ops.hpp"

namespace mfs {

/// `amount` was added to entry (row, column) of A.
template <class Scalar>
struct Perturbation {
  Vertex row, column;
  Scalar amount;
};

/// More perturbed pivots than this are not corrected: Z (n x k) must not outgrow the factors, and the
/// singular values of C cost k^3.
inline std::size_t most_corrected(const SymbolicPlan& plan) {
  constexpr Offset kAlways = 128, kNever = 512;
  return static_cast<std::size_t>(std::clamp(plan.factor_entries / plan.n, kAlways, kNever));
}

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

/// What a residual is summed in where cancellation must leave digits.
template <class Scalar>
using Extended =
    std::conditional_t<std::is_same_v<Scalar, RealOf<Scalar>>, long double, std::complex<long double>>;

template <class Scalar>
class Correction {
 public:
  /// `scale[u]` is the scale of unknown u, `row_scale[i]` that of row i; `inverse(x, columns)` puts A'^-1 X
  /// in the place of X, at most kSolveColumns at once; `rows` are those of A.
  template <class Inverse>
  Correction(Vertex n, std::vector<Perturbation<Scalar>> perturbations, const double* scale,
             const double* row_scale, const Inverse& inverse, const RowAccess<Scalar>& rows)
      : n_(n), perturbations_(std::move(perturbations)) {
    const std::size_t k = perturbations_.size();
    for (const Perturbation<Scalar>& p : perturbations_)
      scale_.push_back(static_cast<RealOf<Scalar>>(scale[p.column]));
    z_.assign(static_cast<std::size_t>(n) * k, Scalar(0));
    for (std::size_t first = 0; first < k; first += kSolveColumns) {
      solve_columns(first, std::min<std::size_t>(kSolveColumns, k - first), inverse, rows);
    }
    decompose(scale);
    while (usable_ && nullity_ < static_cast<Vertex>(k) && is_null(nullity_, rows, row_scale)) ++nullity_;
  }

  /// False where the numbers ran out of range: then there is no correction.
  bool usable() const { return usable_; }
  Vertex nullity() const { return nullity_; }
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
  void apply(Scalar* x) {
    const std::size_t k = perturbations_.size();
    for (std::size_t i = 0; i < k; ++i)
      at_columns_[i] = x[perturbations_[i].column] / scale_[i] * down_rows_[i];
    // C^-1 = columns V diag(1 / singular) U^H rows
    for (std::size_t i = 0; i < k; ++i) {
      Wide<Scalar> sum = 0;
      for (std::size_t j = 0; j < k; ++j)
        sum += Wide<Scalar>(conjugated(left_[j + i * k])) * Wide<Scalar>(at_columns_[j]);
      rotated_[i] = sum / singular_[i];
    }
    for (std::size_t i = 0; i < k; ++i) {
      Wide<Scalar> sum = 0;
      for (std::size_t j = 0; j < k; ++j) sum += Wide<Scalar>(conjugated(right_[j + i * k])) * rotated_[j];
      const Scalar factor = static_cast<Scalar>(sum) * (down_columns_[i] * scale_[i]);
      const Scalar* z = z_.data() + i * static_cast<std::size_t>(n_);
      for (Vertex row = 0; row < n_; ++row) x[row] += factor * z[row];
    }
  }

  /// The unknown with the largest entry, in scaled unknowns, of the null vector that belongs to the smallest
  /// singular value.
  Vertex dependent_unknown(const double* scale) const {
    return largest_unknown(n_, null_vector(0).data(), scale);
  }

  /// V p with C^T p = 0: A'^-T of it is the null vector of A^T.
  void left_null_source(Scalar* out) const {
    const std::size_t k = perturbations_.size();
    std::fill(out, out + n_, Scalar(0));
    for (std::size_t i = 0; i < k; ++i)
      out[perturbations_[i].column] = conjugated(left_[i + (k - 1) * k]) * (down_rows_[i] / scale_[i]);
  }

  std::size_t bytes() const { return z_.size() * sizeof(Scalar); }

 private:
  // Z q for the singular vector q of the smallest singular value (order 0), the next one, ...
  std::vector<Scalar> null_vector(Vertex order) const {
    const std::size_t k = perturbations_.size(), place = k - 1 - static_cast<std::size_t>(order);
    std::vector<Scalar> vector(static_cast<std::size_t>(n_), Scalar(0));
    for (std::size_t i = 0; i < k; ++i) {
      const Scalar factor = conjugated(right_[place + i * k]) * (down_columns_[i] * scale_[i]);
      const Scalar* z = z_.data() + i * static_cast<std::size_t>(n_);
      for (Vertex row = 0; row < n_; ++row) vector[row] += factor * z[row];
    }
    return vector;
  }

  // |A x| <= kSingular | |A| |x| | in scaled rows proves that the scaled A has a reciprocal condition number
  // of at most kSingular (maximum norm).
  bool is_null(Vertex order, const RowAccess<Scalar>& rows, const double* row_scale) const {
    constexpr double kSingular = 45 * std::numeric_limits<RealOf<Scalar>>::epsilon();  // double: 1e-14
    const std::vector<Scalar> x = null_vector(order);
    double product = 0, size = 0;
    for (Vertex i = 0; i < n_; ++i) {
      Extended<Scalar> sum = 0;
      double sizes = 0;
      for (Offset k = rows.offsets[i]; k < rows.offsets[i + 1]; ++k) {
        const Extended<Scalar> term = Extended<Scalar>(rows.values[rows.slots ? rows.slots[k] : k]) *
                                      Extended<Scalar>(x[rows.columns[k]]);
        sum += term;
        sizes += static_cast<double>(std::abs(term));
      }
      product = std::max(product, static_cast<double>(std::abs(sum)) * row_scale[i]);
      size = std::max(size, sizes * row_scale[i]);
    }
    return size > 0 && product <= kSingular * size;
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
    for (Vertex i = 0; i < n_; ++i) {
      for (Offset k = rows.offsets[i]; k < rows.offsets[i + 1]; ++k) {
        const Scalar value = rows.values[rows.slots ? rows.slots[k] : k];
        sum[i] -= Extended<Scalar>(value) * Extended<Scalar>(z[rows.columns[k]]);
      }
    }
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

  Vertex n_;
  std::vector<Perturbation<Scalar>> perturbations_;
  std::vector<RealOf<Scalar>> scale_;                     // of the unknown of each perturbation
  std::vector<Scalar> z_;                                 // n x k
  std::vector<Scalar> capacitance_;                       // C between scaled unknowns, k x k
  std::vector<RealOf<Scalar>> down_rows_, down_columns_;  // of C, k each
  std::vector<double> singular_;                          // of C as scaled down; k, descending
  std::vector<Scalar> left_, right_;                      // U and V^H of C, k x k
  std::vector<Scalar> at_columns_;                        // work
  std::vector<Wide<Scalar>> rotated_;                     // work
  Vertex nullity_ = 0;
  bool usable_ = false;
};

}  // namespace mfs
