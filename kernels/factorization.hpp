// One numeric factorization: a plan, an arena sized by it, and the stages run over all depths. Everything
// that the numeric phases need is allocated when it is made; factor() allocates nothing, solve() only what
// its first use of several right-hand sides or of FGMRES needs.
#pragma once

#include <functional>
#include <memory>

#include "kernels/front_store.hpp"
#include "ordering/transpose.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Bytes that a factorization of `plan` takes, by purpose; the sum is exactly what it allocates.
struct NumericBytes {
  Offset factor = 0;        // L and U
  Offset contribution = 0;  // what contribution blocks need beyond the factors
  Offset other = 0;         // matrix values, scaling, pivots
  Offset solve = 0;         // vectors of a solve
  Offset total() const { return factor + contribution + other + solve; }
};
/// `scalar_bytes` of an entry of the factors, `value_bytes` of one of the matrix and the vectors; `columns`
/// right-hand sides that there is room for.
NumericBytes numeric_bytes(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes,
                           Vertex columns = 1);

struct SolveControls {
  double tolerance = 1e-12;  // componentwise backward error
  int max_steps = 10;        // of refinement; 0: none, and no FGMRES either
  double row_floor = 0;      // SolveOptions::row_floor
};

struct SolveOutcome {
  int refinement_steps = 0;
  int krylov_steps = 0;
  double backward_error = 0;     // the worst of all columns
  double time_ladder = 0;        // s, for correction, refinement and FGMRES
  int corrected_pivots = 0;      // perturbed pivots that an exact low-rank correction took back
  Vertex dependent_rows = 0;     // > 0: A is singular to working precision, and this row and this column
  Vertex row = -1, column = -1;  // of A depend on the others
};

/// Right-hand sides that one pass over the factors serves at most.
constexpr Vertex kSolveColumns = 16;

enum class HostSpace { serial, openmp };

/// What a factorization whose memory is a device's can do beside: take and give arrays of that memory.
/// `stream` is a stream of the caller; what was put into it before is waited for on the device. Each call
/// returns when its work is done.
template <class Scalar>
class DeviceFactors {
 public:
  virtual ~DeviceFactors() = default;
  /// Takes the values, by slot of the pattern, for the next factor(); false if one of them is not finite.
  virtual bool take_values(const Scalar* values, void* stream) = 0;
  /// Solves on the device alone; false, and nothing is written, where that misses the tolerance: where b is
  /// not finite, pivots were perturbed, or the ladder must be climbed.
  virtual bool solve_resident(const Scalar* b, Offset ldb, Scalar* x, Offset ldx, Vertex columns,
                              const TransposedPattern* transposed, const SolveControls& controls,
                              void* stream, SolveOutcome& outcome) = 0;
  /// Copies of `columns` columns of `rows` entries, device to host and back.
  virtual void download(const Scalar* from, Offset ld, Offset rows, Vertex columns, Scalar* to,
                        void* stream) = 0;
  virtual void upload(const Scalar* from, Offset rows, Vertex columns, Scalar* to, Offset ld,
                      void* stream) = 0;
};

template <class Scalar>
class Factorization {
 public:
  virtual ~Factorization() = default;

  /// A's values in the order of the pattern's slots and its scales, to be filled before factor().
  virtual Scalar* matrix_values() = 0;
  virtual double* row_scale() = 0;
  virtual double* column_scale() = 0;

  /// Factors matrix_values(); a pivot below tolerance times the largest scaled entry is perturbed.
  /// `progress` (may be empty) is told the fraction of the operations done after each depth.
  virtual FactorStatus factor(double tolerance, const std::function<void(double)>& progress) = 0;

  /// Where the right-hand sides of a solve go and its solutions come out: n x columns, column-major, in the
  /// caller's numbering. There is room for one column from the start; more are made room for when first asked
  /// for (std::bad_alloc), and what was there stays. columns <= kSolveColumns.
  virtual Scalar* rhs(Vertex columns) = 0;
  virtual const Scalar* solution() const = 0;
  /// Columns that many right-hand sides are best taken by: fewer than kSolveColumns where the vectors of so
  /// many would need much memory beside the factors.
  virtual Vertex columns_at_once() const { return kSolveColumns; }
  /// Solves for `columns` columns of rhs(columns); with A^T where its pattern is given.
  virtual SolveOutcome solve(Vertex columns, const TransposedPattern* transposed,
                             const SolveControls& controls) = 0;

  /// Estimate of |A|_1 |A^-1|_1, infinite for a singular matrix, NaN if too many pivots were perturbed to
  /// know it.
  virtual double condition_estimate(const TransposedPattern& transposed) = 0;
  /// The determinant of A as phase * exp(log_abs); false if too many pivots were perturbed to know it.
  virtual bool determinant(Scalar& phase, double& log_abs) = 0;

  /// What factor() did to the pivots, by position: the row of A that came there, and what was added.
  virtual Vertex pivot_row(Vertex position) const = 0;
  virtual Scalar pivot_shift(Vertex position) const = 0;
  /// By front of the plan: whether any of its pivots was perturbed.
  std::vector<char> failed_fronts(const SymbolicPlan& plan) const {
    std::vector<char> failed(static_cast<size_t>(plan.num_fronts), 0);
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      for (Vertex p = plan.pivot_begin[f]; p < plan.pivot_begin[f + 1]; ++p) {
        if (pivot_shift(p) != Scalar(0)) failed[f] = 1;
      }
    }
    return failed;
  }

  virtual Offset bytes() const = 0;
  /// Null where the factors are in the memory of the host.
  virtual DeviceFactors<Scalar>* device() { return nullptr; }
};

/// With single_precision the factors are float or complex<float>, whatever Scalar is. Must be made and used
/// inside Engine::run, with `threads` the number given there. Throws std::bad_alloc.
template <class Scalar>
std::unique_ptr<Factorization<Scalar>> make_factorization(HostSpace space, bool single_precision,
                                                          std::shared_ptr<const SymbolicPlan> plan,
                                                          std::shared_ptr<const Pattern> pattern,
                                                          int threads);

}  // namespace mfs
