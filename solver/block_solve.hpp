// Solutions for given factors: right-hand sides are checked, then solved for in blocks; a block whose
// backward error misses the tolerance makes the factors climb the ladder (MatrixFactors::climb) until it does
// not, or is refused. Nothing is written before its backward error is known to be good enough.
#pragma once

#include <mfs/options.hpp>
#include <mfs/report.hpp>

#include "solver/failing_system.hpp"
#include "solver/host_solver.hpp"
#include "solver/matrix_factors.hpp"

namespace mfs {

/// Right-hand sides and the place of their solutions: n x count each, column-major; leading dimensions of 0
/// stand for n.
template <class Scalar>
struct Columns {
  const Scalar* b;
  Scalar* x;
  Offset count, ldb, ldx;
  bool transposed;    // solve with A^T
  Offset before = 0;  // columns of the same call that come before these
};

template <class Scalar>
class BlockSolve {
 public:
  /// All four must outlive this; `report` is told what each solve took.
  BlockSolve(const Options& options, Phases& phases, MatrixFactors<Scalar>& factors, Report& report);

  /// As BasicSolver::solve and solve_transpose.
  void solve(Columns<Scalar> all);
  /// As BasicSolver::solve_device and solve_transpose_device.
  void solve_device(Columns<Scalar> all, void* stream);

 private:
  Vertex rows() const { return factors_.analysis().pattern->n; }
  Columns<Scalar> checked(Columns<Scalar> all) const;
  template <class SolvePart>
  void solve_parts(const Columns<Scalar>& all, const SolvePart& solve_part);

  void solve_part(const Columns<Scalar>& part, const SolveOutcome* tried = nullptr);
  void solve_part_on_device(const Columns<Scalar>& part, void* stream);
  bool reached(const SolveOutcome& outcome) const { return outcome.backward_error <= controls_.tolerance; }
  // What leaves in doubt whether A is singular is no solution as long as there are other factors to try.
  bool settled(const SolveOutcome& outcome) const { return reached(outcome) && !outcome.doubtful; }
  void climb_until_solved(const Columns<Scalar>& part, const SolveOutcome* tried);
  void solve_on_host(const Columns<Scalar>& part);
  SolveOutcome solve_rescaled(const Columns<Scalar>& part, Scalar* solution);
  double room_left() const;
  void try_orthogonal(const Columns<Scalar>& part, Scalar* solution, SolveOutcome& outcome);
  template <class Work>
  void with_threads(Offset columns, const Work& work);
  void write_solution(const Columns<Scalar>& part, const Scalar* solution, const SolveOutcome& outcome);
  SolveOutcome solve_with_factors(const Columns<Scalar>& part, const SolveOutcome* tried = nullptr);
  const TransposedPattern* pattern_for(const Columns<Scalar>& part);
  void note_outcome(const SolveOutcome& outcome);
  [[noreturn]] void refuse(const SolveOutcome& outcome, bool doubtful, Offset overflowed) const;

  const Options& options_;
  Phases& phases_;
  MatrixFactors<Scalar>& factors_;
  Report& report_;
  SolveControls controls_;
  HostSolver<Scalar> host_;
};

}  // namespace mfs
