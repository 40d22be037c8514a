// From an approximate inverse to a solution whose componentwise backward error is known, by vectors on the
// host: iterative refinement (accuracy/iterative_refinement.hpp), and, for a column where that stalls,
// refinement in twice the precision, then FGMRES with the factors as preconditioner.
//
// Unknowns that are tiny beside the others, as what a planar mechanism has across its plane, get from each
// correction an error that is small beside the correction, and corrections end at the rounding of the large
// unknowns. With residual and solution of twice the precision they go on to nothing, and the tiny unknowns
// become right.
//
// Unknowns that are zero by the pattern of A and b alone (accuracy/solution_support.hpp) are set to zero, and
// stay so, before anything else is tried.
//
// Refinement also stalls where pivots were perturbed (with k of them A differs from the factored matrix by a
// matrix of rank k, so FGMRES needs about k + 1 steps), and where |A| |x| + |b| differs by many decades
// between rows: small rows then drown in what large entries of x leave there. FGMRES therefore measures row i
// of the residual by (|A| |x| + |b|)_i: what it makes small is the backward error itself.
//
// Sources: Demmel, Hida, Kahan, Li, Mukherjee and Riedy 2006 (residual and solution of twice the precision);
// Saad 1993 (FGMRES); Arioli, Duff, Gratton, Pralet 2007 (FGMRES on factors with static pivoting).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "accuracy/iterative_refinement.hpp"
#include "accuracy/solve_controls.hpp"
#include "kernels/factors.hpp"
#include "kernels/stages/residual_columns.hpp"
#include "kernels/stages/vector_ops.hpp"

namespace mfs {

/// Vectors of a solve in the caller's numbering, n x kSolveColumns each.
template <class Scalar>
struct RefinementVectors {
  Scalar *b, *x, *best, *r, *d;
  double* size;                // n: what the residual of each row is measured by
  std::vector<Scalar>* space;  // of refinement in twice the precision and of FGMRES, taken when first needed
};

/// FGMRES keeps this many directions before it restarts, and restarts this often at most.
constexpr Vertex kKrylovDirections = 40;
constexpr int kKrylovRestarts = 3;
/// A cycle ends when the weighted residual, an upper bound of the backward error, is below this part of the
/// tolerance.
constexpr double kEnough = 0.1;

/// One block of right-hand sides and its solutions in the memory of the host, where Exec works on them. Each
/// column is a part, as IterativeRefinement calls it. `Inverse` is called as inverse(from, to, columns),
/// `Residual` as residual(b or null, x, r, sizes of rows or null) and returns the componentwise backward
/// error, `DoubledResidual` as doubled(b, x, low, r) for r = b - A (x + low), `Support` as support(b) for
/// which unknowns may differ from zero (std::vector<char>; empty: all). `rows` are those of A; where its
/// `offsets` is null, columns are measured one by one, by `residual`.
template <class Exec, class Scalar, class Inverse, class Residual, class DoubledResidual, class Support>
class HostVectors {
 public:
  using Value = Scalar;
  HostVectors(const Exec& exec, Vertex n, Vertex columns, const RefinementVectors<Scalar>& vectors,
              const RowAccess<Scalar>& rows, const Inverse& inverse, const Residual& residual,
              const DoubledResidual& doubled, const Support& support)
      : n(n),
        columns(columns),
        inverse(inverse),
        residual(residual),
        doubled(doubled),
        support(support),
        exec_(exec),
        rows_(rows),
        at_(vectors) {}

  Vertex parts() const { return columns; }
  void measure(double* errors) const {
    Vertex j = 0;
    if (rows_.offsets && n >= kResidualColumns) {
      for (; j + kResidualColumns <= columns; j += kResidualColumns) measure_together(j, errors + j);
    }
    for (; j < columns; ++j) errors[j] = measure(j);
  }
  double measure(Vertex j) const { return residual(b(j), x(j), r(j), nullptr); }
  void correct(const Vertex* parts, Vertex count) const {
    for (Vertex place = 0; place < count; ++place) copy(r(parts[place]), d(place));
    inverse(d(0), d(0), count);
  }
  double add_correction(Vertex j, Vertex place) const {
    copy(x(j), best(j));
    add(Scalar(1), d(place), x(j));
    return measure(j);
  }
  // Where entries of the solution are zero, as those across the plane of a symmetric mechanism, steps make
  // them smaller and smaller, but a row that meets only such entries measures rounding by rounding: its error
  // stays near 1. Zeros in their place end that, if zeros they are.
  double drop_remainders(Vertex j, Vertex place, double error) const {
    mfs::drop_remainders(exec_, n, best(j), x(j));
    const double dropped = measure(j);
    if (dropped < error) return dropped;
    take_back(j);
    add(Scalar(1), d(place), x(j));
    return error;
  }
  void take_back(Vertex j) const { copy(best(j), x(j)); }

  /// As measure; keeps what the residual of each row is measured by, for weigh.
  void measure_rows(Vertex j) const { residual(b(j), x(j), r(j), at_.size); }

  // Column j of each vector.
  Scalar* b(Vertex j) const { return column(at_.b, j); }
  Scalar* x(Vertex j) const { return column(at_.x, j); }
  Scalar* best(Vertex j) const { return column(at_.best, j); }
  Scalar* r(Vertex j) const { return column(at_.r, j); }
  Scalar* d(Vertex j) const { return column(at_.d, j); }
  /// A vector of zeros, and so many vectors: until the other is asked for.
  Scalar* zeros() const {
    at_.space->assign(static_cast<std::size_t>(n), Scalar(0));
    return at_.space->data();
  }
  Scalar* more(Vertex count) const {
    at_.space->resize(static_cast<std::size_t>(n) * count);
    return at_.space->data();
  }

  void copy(const Scalar* from, Scalar* to) const { copy_vector(exec_, n, from, to); }
  void add(Scalar factor, const Scalar* from, Scalar* to) const { add_vector(exec_, n, factor, from, to); }
  void add_doubled(const Scalar* d, Scalar* x, Scalar* low) const { mfs::add_doubled(exec_, n, d, x, low); }
  void drop_noise(const Scalar* d, Scalar* x) const { mfs::drop_noise(exec_, n, d, x); }
  void keep(const std::vector<char>& kept, Scalar* x) const { keep_entries(exec_, n, kept.data(), x); }
  void scale(Scalar factor, Scalar* x) const { scale_vector(exec_, n, factor, x); }
  void weigh(const Scalar* from, Scalar* to, bool inverse) const {
    weigh_vector(exec_, n, at_.size, !inverse, from, to);
  }
  Scalar dot(const Scalar* a, const Scalar* b) const { return dot_product(exec_, n, a, b); }
  double norm2(const Scalar* a) const { return std::sqrt(std::abs(dot(a, a))); }

  const Vertex n, columns;
  const Inverse& inverse;
  const Residual& residual;
  const DoubledResidual& doubled;
  const Support& support;

 private:
  Scalar* column(Scalar* block, Vertex j) const { return block + static_cast<Offset>(j) * n; }

  // Columns [first, first + kResidualColumns). They lie side by side where corrections come later, and what
  // is found of groups of rows where the sizes of rows do.
  void measure_together(Vertex first, double* errors) const {
    constexpr Offset kGroup = 128;
    constexpr Vertex K = kResidualColumns;
    const Offset rows = n, groups = (rows + kGroup - 1) / kGroup;
    const Scalar *const from = x(first), *const b_first = b(first);
    Scalar *const together = at_.d, *const r_first = r(first);
    double* const worst = at_.size;
    for_each_index(exec_, "mfs::together", groups, [=](Offset group) {
      for (Offset i = group * kGroup; i < std::min(rows, (group + 1) * kGroup); ++i) {
        for (Vertex c = 0; c < K; ++c) together[i * K + c] = from[i + c * rows];
      }
    });
    for_each_index(exec_, "mfs::residuals", groups, [=, a = rows_](Offset group) {
      residual_rows(a, group * kGroup, std::min(rows, (group + 1) * kGroup), rows, b_first, together, r_first,
                    worst + group * K);
    });
    exec_.fence();
    std::fill_n(errors, K, 0.0);
    for (Offset group = 0; group < groups; ++group) {
      for (Vertex c = 0; c < K; ++c) errors[c] = std::max(errors[c], worst[group * K + c]);
    }
  }

  Exec exec_;
  RowAccess<Scalar> rows_;
  RefinementVectors<Scalar> at_;
};

/// One use: one block of right-hand sides. All that depends on where the vectors lie is done by `Vectors`.
template <class Vectors>
class Refinement {
  using Scalar = typename Vectors::Value;

 public:
  Refinement(const Vectors& vectors, const SolveControls& controls)
      : controls_(controls), vectors_(vectors), refinement_(vectors_, controls) {}

  /// Leaves the best solution found in vectors.x; adds to `outcome` what it took. Goes on from what is in
  /// vectors.x where that has been `begun`.
  void run(SolveOutcome& outcome, bool begun = false) {
    if (!begun) vectors_.inverse(vectors_.b(0), vectors_.x(0), vectors_.columns);
    refinement_.measure();
    refinement_.run();
    for (Vertex j = 0; j < vectors_.columns; ++j) {
      if (controls_.max_steps == 0) break;
      if (fails(j)) refine_in_support(j);
      if (fails(j)) refine_doubled(j);
      if (fails(j)) accelerate(j);
    }
    outcome.backward_error = refinement_.worst_error();
    outcome.refinement_steps = refinement_.steps() + further_steps_;
    outcome.krylov_steps = krylov_steps_;
    if (outcome.refinement_steps + krylov_steps_ > 0) outcome.time_ladder += refinement_.seconds();
  }

 private:
  bool misses(Vertex j) { return error(j) > controls_.tolerance; }
  bool fails(Vertex j) { return misses(j) && std::isfinite(error(j)); }
  double& error(Vertex j) { return refinement_.error(j); }

  // By entries that may differ from zero, as long as the error halves. The others are zero in each solution
  // of a regular A; where that is not better, it may not be one.
  void refine_in_support(Vertex j) {
    support_ = vectors_.support(vectors_.b(j));
    if (support_.empty()) return;
    Scalar* const x = vectors_.x(j);
    const std::vector<Scalar> as_it_was(x, x + vectors_.n);
    const double before = error(j);
    vectors_.keep(support_, x);
    error(j) = vectors_.measure(j);
    for (int step = 0; step < controls_.max_steps && misses(j); ++step) {
      const double last = error(j);
      correct(j);
      if (!(error(j) < 0.5 * last)) break;
    }
    if (error(j) < before) return;
    std::copy(as_it_was.begin(), as_it_was.end(), x);
    error(j) = before;
    support_.clear();
  }

  // One column, in the support of its solution.
  void invert(const Scalar* from, Scalar* to) {
    vectors_.inverse(from, to, 1);
    if (!support_.empty()) vectors_.keep(support_, to);
  }
  // A step of refinement, from the residual that was measured last.
  void correct(Vertex j) {
    invert(vectors_.r(j), vectors_.d(0));
    ++further_steps_;
    refinement_.improve(j, 0);
  }

  // As long as each correction is less than half of the one before.
  void refine_doubled(Vertex j) {
    Scalar *const x = vectors_.x(j), *const d = vectors_.d(0), *const low = vectors_.zeros();
    const double before = error(j);
    vectors_.copy(x, vectors_.best(j));
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < controls_.max_steps && misses(j); ++step) {
      vectors_.doubled(vectors_.b(j), x, low, d);
      invert(d, d);
      ++further_steps_;
      const double length = vectors_.norm2(d);
      if (!(length < 0.5 * last)) {
        vectors_.drop_noise(d, x);
        error(j) = vectors_.measure(j);
        break;
      }
      last = length;
      vectors_.add_doubled(d, x, low);
      error(j) = vectors_.measure(j);
    }
    if (error(j) < before) return;
    vectors_.copy(vectors_.best(j), x);
    error(j) = before;
  }

  // FGMRES for one column, each row of the residual measured by its size for the x at hand.
  void accelerate(Vertex j) {
    Scalar* const basis = vectors_.more(2 * kKrylovDirections + 1);
    Scalar* const directions = basis + static_cast<Offset>(vectors_.n) * (kKrylovDirections + 1);
    for (int restart = 0; restart < kKrylovRestarts && misses(j); ++restart) {
      const double before = error(j);
      vectors_.measure_rows(j);
      krylov_cycle(j, basis, directions);
      for (int step = 0; step < 2 && misses(j); ++step) {
        vectors_.measure(j);
        correct(j);
      }
      if (!(error(j) < 0.5 * before)) break;
    }
  }

  void krylov_cycle(Vertex j, Scalar* basis, Scalar* directions) {
    std::vector<std::vector<Scalar>> h;  // columns of the Hessenberg matrix, already rotated
    std::vector<std::array<Scalar, 2>> rotations;
    std::vector<Scalar> rhs;
    vectors_.weigh(vectors_.r(j), basis, false);
    const double norm = vectors_.norm2(basis);
    if (!(norm > 0) || !std::isfinite(norm)) return;
    vectors_.scale(real(1 / norm), basis);
    rhs.push_back(real(norm));
    while (static_cast<Vertex>(h.size()) < kKrylovDirections) {
      const Offset k = static_cast<Offset>(h.size());
      Scalar *v = basis + k * vectors_.n, *z = directions + k * vectors_.n, *w = v + vectors_.n;
      vectors_.weigh(v, vectors_.d(0), true);
      invert(vectors_.d(0), z);
      ++krylov_steps_;
      vectors_.residual(nullptr, z, vectors_.d(0), nullptr);  // -A z
      vectors_.weigh(vectors_.d(0), w, false);
      vectors_.scale(Scalar(-1), w);
      std::vector<Scalar> hessenberg(k + 2);
      for (int pass = 0; pass < 2; ++pass) {  // twice is enough (Giraud et al. 2005)
        for (Offset i = 0; i <= k; ++i) {
          const Scalar product = vectors_.dot(basis + i * vectors_.n, w);
          hessenberg[i] += product;
          vectors_.add(-product, basis + i * vectors_.n, w);
        }
      }
      const double length = vectors_.norm2(w);
      if (!std::isfinite(length)) break;
      hessenberg[k + 1] = real(length);
      rotate(hessenberg, rotations, rhs);
      h.push_back(hessenberg);
      if (length == 0 || std::abs(rhs.back()) < kEnough * controls_.tolerance) break;
      vectors_.scale(real(1 / length), w);
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
    const double before = error(j);
    vectors_.copy(vectors_.x(j), vectors_.best(j));
    for (Offset k = 0; k < m; ++k) vectors_.add(y[k], directions + k * vectors_.n, vectors_.x(j));
    error(j) = vectors_.measure(j);
    if (!(error(j) < before)) {
      vectors_.copy(vectors_.best(j), vectors_.x(j));
      error(j) = before;
    }
  }

  static Scalar real(double value) { return Scalar(static_cast<RealOf<Scalar>>(value)); }

  SolveControls controls_;
  Vectors vectors_;
  IterativeRefinement<Vectors> refinement_;
  std::vector<char> support_;  // of the solution of the column at hand; empty: all unknowns, or not asked
  int further_steps_ = 0, krylov_steps_ = 0;
};

}  // namespace mfs
