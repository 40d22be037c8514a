// From an approximate inverse to a solution whose componentwise backward error is known: iterative
// refinement, and, for a column where that stalls, refinement in twice the precision, then FGMRES with the
// factors as preconditioner.
//
// Unknowns that are tiny beside the others, as what a planar mechanism has across its plane, get from each
// correction an error that is small beside the correction, and corrections end at the rounding of the large
// unknowns. With residual and solution of twice the precision they go on to nothing, and the tiny unknowns
// become right.
//
// Else refinement stalls where pivots were perturbed (with k of them A differs from the factored matrix by a
// matrix of rank k, so FGMRES needs about k + 1 steps), and where |A| |x| + |b| differs by many decades
// between rows: then small rows drown in what large entries of x leave there. FGMRES therefore measures row i
// of the residual by
// (|A| |x| + |b|)_i: what it makes small is the backward error itself.
//
// Sources: Skeel 1979, 1980; Arioli, Demmel, Duff 1989 (refinement and its stopping); Demmel, Hida, Kahan,
// Li, Mukherjee and Riedy 2006 (residual and solution of twice the precision); Saad 1993 (FGMRES); Arioli,
// Duff, Gratton, Pralet 2007 (FGMRES on factors with static pivoting).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "accuracy/solve_controls.hpp"
#include "kernels/factors.hpp"
#include "kernels/stages/residual.hpp"
#include "kernels/stages/vector_ops.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs {

/// Vectors of a solve in the caller's numbering, n x kSolveColumns each.
template <class Scalar>
struct RefinementVectors {
  Scalar *b, *x, *best, *r, *d;
  double* size;  // n: what the residual of each row is measured by
};

/// FGMRES keeps this many directions before it restarts, and restarts this often at most.
constexpr Vertex kKrylovDirections = 40;
constexpr int kKrylovRestarts = 3;
/// A cycle ends when the weighted residual, an upper bound of the backward error, is below this part of the
/// tolerance.
constexpr double kEnough = 0.1;

/// One use: one block of right-hand sides. `Inverse` is called as inverse(from, to, columns), `Residual` as
/// residual(b or null, x, r, sizes of rows or null) and returns the componentwise backward error,
/// `DoubledResidual` as doubled(b, x, low, r) for r = b - A (x + low).
template <class Exec, class Scalar, class Inverse, class Residual, class DoubledResidual>
class Refinement {
 public:
  Refinement(const Exec& exec, Vertex n, Vertex columns, const SolveControls& controls,
             const RefinementVectors<Scalar>& vectors, const Inverse& inverse, const Residual& residual,
             const DoubledResidual& doubled)
      : exec_(exec),
        n_(n),
        columns_(columns),
        controls_(controls),
        at_(vectors),
        inverse_(inverse),
        residual_(residual),
        doubled_(doubled) {}

  /// Leaves the best solution found in vectors.x; adds to `outcome` what it took. Goes on from what is in
  /// vectors.x where that has been `begun`.
  void run(std::vector<Scalar>& krylov_space, SolveOutcome& outcome, bool begun = false) {
    if (!begun) inverse_(at_.b, at_.x, columns_);
    for (Vertex j = 0; j < columns_; ++j) {
      error_[j] = measure(j);
      open_[j] = error_[j] > controls_.tolerance;
    }
    const Stopwatch beyond_the_factors;
    refine();
    for (Vertex j = 0; j < columns_; ++j) {
      if (controls_.max_steps == 0) break;
      if (fails(j)) refine_doubled(j, krylov_space);
      if (fails(j)) accelerate(j, krylov_space);
    }
    outcome.backward_error = *std::max_element(error_.begin(), error_.begin() + columns_);
    outcome.refinement_steps = refinement_steps_;
    outcome.krylov_steps = krylov_steps_;
    if (refinement_steps_ + krylov_steps_ > 0) outcome.time_ladder += beyond_the_factors.seconds();
  }

 private:
  bool fails(Vertex j) const { return error_[j] > controls_.tolerance && std::isfinite(error_[j]); }

  // Refines all open columns together; a column is closed when it is good enough or no longer halves its
  // error.
  void refine() {
    for (int step = 0; step < controls_.max_steps; ++step) {
      Vertex open = 0;
      for (Vertex j = 0; j < columns_; ++j) {
        if (open_[j]) copy(column(at_.r, j), column(at_.d, open++));
      }
      if (open == 0) return;
      ++refinement_steps_;
      inverse_(at_.d, at_.d, open);
      open = 0;
      for (Vertex j = 0; j < columns_; ++j) {
        if (open_[j]) improve(j, column(at_.d, open++));
      }
    }
  }

  // The residual of column j, and its backward error.
  double measure(Vertex j) const {
    return residual_(column(at_.b, j), column(at_.x, j), column(at_.r, j), nullptr);
  }

  // x += d, kept only if it is better.
  void improve(Vertex j, const Scalar* correction) {
    const double before = error_[j];
    copy(column(at_.x, j), column(at_.best, j));
    add(Scalar(1), correction, column(at_.x, j));
    double after = measure(j);
    if (stalls(before, after)) after = without_remainders(j, correction, after);
    if (after < before) {
      error_[j] = after;
    } else {
      copy(column(at_.best, j), column(at_.x, j));
    }
    open_[j] = after > controls_.tolerance && !stalls(before, after);
  }

  bool stalls(double before, double after) const {
    return after > controls_.tolerance && !(after < 0.5 * before);
  }

  // Where entries of the solution are zero, as those across the plane of a symmetric mechanism, steps make
  // them smaller and smaller, but a row that meets only such entries measures rounding by rounding: its error
  // stays near 1. Zeros in their place end that, if zeros they are.
  double without_remainders(Vertex j, const Scalar* correction, double after) {
    drop_remainders(exec_, n_, column(at_.best, j), column(at_.x, j));
    const double dropped = measure(j);
    if (dropped < after) return dropped;
    copy(column(at_.best, j), column(at_.x, j));
    add(Scalar(1), correction, column(at_.x, j));
    return after;
  }

  // As long as each correction is less than half of the one before.
  void refine_doubled(Vertex j, std::vector<Scalar>& space) {
    space.assign(static_cast<size_t>(n_), Scalar(0));
    Scalar *const x = column(at_.x, j), *const d = column(at_.d, 0), *const low = space.data();
    const double before = error_[j];
    copy(x, column(at_.best, j));
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < controls_.max_steps && error_[j] > controls_.tolerance; ++step) {
      doubled_(column(at_.b, j), x, low, d);
      inverse_(d, d, 1);
      ++refinement_steps_;
      const double length = norm2(d);
      if (!(length < 0.5 * last)) {
        drop_noise(exec_, n_, d, x);
        error_[j] = measure(j);
        break;
      }
      last = length;
      add_doubled(exec_, n_, d, x, low);
      error_[j] = measure(j);
    }
    if (error_[j] < before) return;
    copy(column(at_.best, j), x);
    error_[j] = before;
  }

  // FGMRES for one column, each row of the residual measured by its size for the x at hand.
  void accelerate(Vertex j, std::vector<Scalar>& space) {
    space.resize(static_cast<size_t>(n_) * (2 * kKrylovDirections + 1));
    Scalar* const basis = space.data();
    Scalar* const directions = basis + static_cast<Offset>(n_) * (kKrylovDirections + 1);
    for (int restart = 0; restart < kKrylovRestarts && error_[j] > controls_.tolerance; ++restart) {
      const double before = error_[j];
      residual_(column(at_.b, j), column(at_.x, j), column(at_.r, j), at_.size);
      krylov_cycle(j, basis, directions);
      for (int step = 0; step < 2 && error_[j] > controls_.tolerance; ++step) {
        measure(j);
        inverse_(column(at_.r, j), column(at_.d, 0), 1);
        ++refinement_steps_;
        improve(j, column(at_.d, 0));
      }
      if (!(error_[j] < 0.5 * before)) break;
    }
  }

  void krylov_cycle(Vertex j, Scalar* basis, Scalar* directions) {
    std::vector<std::vector<Scalar>> h;  // columns of the Hessenberg matrix, already rotated
    std::vector<std::array<Scalar, 2>> rotations;
    std::vector<Scalar> rhs;
    weigh(column(at_.r, j), basis, false);
    const double norm = norm2(basis);
    if (!(norm > 0) || !std::isfinite(norm)) return;
    scale(real(1 / norm), basis);
    rhs.push_back(real(norm));
    while (static_cast<Vertex>(h.size()) < kKrylovDirections) {
      const Offset k = static_cast<Offset>(h.size());
      Scalar *v = basis + k * n_, *z = directions + k * n_, *w = v + n_;
      weigh(v, column(at_.d, 0), true);
      inverse_(column(at_.d, 0), z, 1);
      ++krylov_steps_;
      residual_(nullptr, z, column(at_.d, 0), nullptr);  // -A z
      weigh(column(at_.d, 0), w, false);
      scale(Scalar(-1), w);
      std::vector<Scalar> hessenberg(k + 2);
      for (int pass = 0; pass < 2; ++pass) {  // twice is enough (Giraud et al. 2005)
        for (Offset i = 0; i <= k; ++i) {
          const Scalar product = dot(basis + i * n_, w);
          hessenberg[i] += product;
          add(-product, basis + i * n_, w);
        }
      }
      const double length = norm2(w);
      if (!std::isfinite(length)) break;
      hessenberg[k + 1] = real(length);
      rotate(hessenberg, rotations, rhs);
      h.push_back(hessenberg);
      if (length == 0 || std::abs(rhs.back()) < kEnough * controls_.tolerance) break;
      scale(real(1 / length), w);
    }
    apply_directions(j, h, rhs, directions);
  }

  // Givens rotations turn the new column upper triangular (Saad 2003, section 6.5.3).
  static void rotate(std::vector<Scalar>& column, std::vector<std::array<Scalar, 2>>& rotations,
                     std::vector<Scalar>& rhs) {
    const size_t k = column.size() - 2;
    for (size_t i = 0; i < k; ++i) {
      const auto [c, s] = rotations[i];
      const Scalar upper = column[i];
      column[i] = conjugated(c) * upper + conjugated(s) * column[i + 1];
      column[i + 1] = -s * upper + c * column[i + 1];
    }
    const Scalar size = real(std::hypot(std::abs(column[k]), std::abs(column[k + 1])));
    if (size == Scalar(0)) {
      rotations.push_back({Scalar(1), Scalar(0)});
    } else {
      rotations.push_back({column[k] / size, column[k + 1] / size});
    }
    const auto [c, s] = rotations.back();
    column[k] = size;
    column[k + 1] = Scalar(0);
    rhs.push_back(-s * rhs[k]);
    rhs[k] = conjugated(c) * rhs[k];
  }

  void apply_directions(Vertex j, const std::vector<std::vector<Scalar>>& h, std::vector<Scalar> y,
                        const Scalar* directions) {
    const Offset m = static_cast<Offset>(h.size());
    for (Offset i = m - 1; i >= 0; --i) {
      for (Offset k = i + 1; k < m; ++k) y[i] -= h[k][i] * y[k];
      y[i] = h[i][i] == Scalar(0) ? Scalar(0) : y[i] / h[i][i];
    }
    const double before = error_[j];
    copy(column(at_.x, j), column(at_.best, j));
    for (Offset k = 0; k < m; ++k) add(y[k], directions + k * n_, column(at_.x, j));
    error_[j] = measure(j);
    if (!(error_[j] < before)) {
      copy(column(at_.best, j), column(at_.x, j));
      error_[j] = before;
    }
  }

  static Scalar real(double value) { return Scalar(static_cast<RealOf<Scalar>>(value)); }

  Scalar* column(Scalar* block, Vertex j) const { return block + static_cast<Offset>(j) * n_; }

  void copy(const Scalar* from, Scalar* to) const { copy_vector(exec_, n_, from, to); }
  void add(Scalar factor, const Scalar* from, Scalar* to) const { add_vector(exec_, n_, factor, from, to); }
  void scale(Scalar factor, Scalar* x) const { scale_vector(exec_, n_, factor, x); }
  void weigh(const Scalar* from, Scalar* to, bool inverse) const {
    weigh_vector(exec_, n_, at_.size, !inverse, from, to);
  }
  Scalar dot(const Scalar* a, const Scalar* b) const { return dot_product(exec_, n_, a, b); }
  double norm2(const Scalar* a) const { return std::sqrt(std::abs(dot(a, a))); }

  Exec exec_;
  Vertex n_, columns_;
  SolveControls controls_;
  RefinementVectors<Scalar> at_;
  const Inverse& inverse_;
  const Residual& residual_;
  const DoubledResidual& doubled_;
  std::array<double, kSolveColumns> error_{};
  std::array<bool, kSolveColumns> open_{};
  int refinement_steps_ = 0, krylov_steps_ = 0;
};

}  // namespace mfs
