// A numeric factorization as the solver sees it: factors in the memory of some executor (kernels/factors.hpp)
// with the accuracy ladder over them. factor() allocates nothing, solve() only what its first use of several
// right-hand sides or of FGMRES needs.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "accuracy/solve_controls.hpp"
#include "kernels/factors.hpp"

namespace mfs {

/// The result of a solve in the memory where the factors lie.
enum class ResidentSolve { solved, missed, refused };

/// Perturbed pivots that the exact correction takes back at most. Each costs six solves and two residuals in
/// extended precision, so some tens of them cost more than a factorization that divides by such pivots.
constexpr std::size_t kMostCorrected = 32;

/// What perturbed pivots have left of a determinant: less than one digit, less than half of those of Value,
/// or as many as the condition of A allows.
enum class Digits { none, some, all };

/// phase * exp(log_abs)
template <class Value>
struct FoundDeterminant {
  Value phase{};
  double log_abs = 0;
  Digits digits = Digits::none;
};

template <class Value>
class Factorization {
 public:
  virtual ~Factorization() = default;

  virtual Factors<Value>& factors() = 0;

  /// As Factors::factor.
  virtual FactorStatus factor(const PivotPolicy& policy, const std::function<void(double)>& progress) = 0;

  /// Where the right-hand sides of a solve go and its solutions come out: n x columns, column-major, in the
  /// caller's numbering. There is room for one column from the start; more are made room for when first asked
  /// for (std::bad_alloc), and what was there stays. columns <= kSolveColumns.
  virtual Value* rhs(Vertex columns) = 0;
  virtual const Value* solution() const = 0;
  /// Solves for `columns` columns of rhs(columns); with A^T where its pattern is given. `tried`: what
  /// solve_resident has just left of the same right-hand sides, from where this goes on.
  virtual SolveOutcome solve(Vertex columns, const TransposedPattern* transposed,
                             const SolveControls& controls, const SolveOutcome* tried = nullptr) = 0;
  /// Solves for arrays in the memory of resident factors, with refinement there. The solution is written only
  /// if it reaches the tolerance. Where the tolerance is missed, because b is not finite or further rungs are
  /// needed, solve() goes on from `outcome`. Where pivots were perturbed, nothing is tried.
  virtual ResidentSolve solve_resident(const SolveBlock<Value>& block, const SolveControls& controls,
                                       void* stream, SolveOutcome& outcome) = 0;

  /// Estimate of |A|_1 |A^-1|_1, infinite for a singular matrix, NaN if too many pivots were perturbed to
  /// know it or a solve for it failed.
  virtual double condition_estimate(const TransposedPattern& transposed, const SolveControls& controls) = 0;
  virtual FoundDeterminant<Value> determinant() = 0;

  /// The row of A that came to a position.
  virtual Vertex pivot_row(Vertex position) const = 0;
  /// The positions of perturbed pivots, ascending.
  virtual std::vector<Vertex> failed_pivots() const = 0;

  /// Of the memory where the factors lie.
  virtual Offset bytes() const = 0;
};

/// Of factors in the memory of the host and the ladder over them (host_bytes has the arguments).
NumericBytes numeric_bytes(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes,
                           Vertex columns = 1);

/// Of the ladder's vectors in those.
Offset ladder_bytes(Vertex n, Offset value_bytes, Vertex columns);

/// The ladder over `factors` of that plan and pattern; its own vector operations, on the host, run on
/// `space`. Must be made and used inside Engine::run. Throws std::bad_alloc.
template <class Value>
std::unique_ptr<Factorization<Value>> make_factorization(HostSpace space,
                                                         std::unique_ptr<Factors<Value>> factors,
                                                         std::shared_ptr<const SymbolicPlan> plan,
                                                         std::shared_ptr<const Pattern> pattern);

}  // namespace mfs
