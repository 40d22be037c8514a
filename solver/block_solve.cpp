#include "solver/block_solve.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <limits>
#include <new>
#include <vector>

#include <mfs/error.hpp>

#include "accuracy/null_vectors.hpp"
#include "ordering/stopwatch.hpp"
#include "solver/memory_limit.hpp"
#include "solver/orthogonal_solver.hpp"
#include "solver/solve_rules.hpp"

namespace mfs {

namespace {

/// Whether solutions would be written over right-hand sides that may not have been read yet. All of b in the
/// place of x is no harm: each block is read before it is written.
template <class Scalar>
bool overlap(Vertex n, const Columns<Scalar>& all) {
  if (all.b == all.x && (all.ldb == all.ldx || all.count == 1)) return false;
  for (Offset j = 0, k = 0; j < all.count && k < all.count;) {
    const Scalar *b = all.b + j * all.ldb, *x = all.x + k * all.ldx;
    if (b + n <= x) {
      ++j;
    } else if (x + n <= b) {
      ++k;
    } else {
      return true;
    }
  }
  return false;
}

/// The row of the first entry that is not finite, or -1.
template <class Scalar>
Offset first_overflowed(Vertex n, Offset columns, const std::vector<Scalar>& x) {
  for (Offset k = 0; k < columns * n; ++k) {
    if (!std::isfinite(std::abs(x[static_cast<std::size_t>(k)]))) return k % n;
  }
  return -1;
}

}  // namespace

template <class Scalar>
BlockSolve<Scalar>::BlockSolve(const Options& options, Phases& phases, MatrixFactors<Scalar>& factors,
                               Report& report)
    : options_(options),
      phases_(phases),
      factors_(factors),
      report_(report),
      controls_(controls_of<Scalar>(options.solve)),
      host_(options, factors) {}

template <class Scalar>
void BlockSolve<Scalar>::solve(Columns<Scalar> all) {
  factors_.numeric("solve");
  all = checked(all);
  with_threads(all.count, [&](int threads) { check_finite(rows(), all.count, all.b, all.ldb, 0, threads); });
  solve_parts(all, [&](const Columns<Scalar>& part) { solve_part(part); });
}

template <class Scalar>
void BlockSolve<Scalar>::solve_device(Columns<Scalar> all, void* stream) {
  factors_.numeric("solve_device");
  factors_.resident("solve_device");
  solve_parts(checked(all), [&](const Columns<Scalar>& part) { solve_part_on_device(part, stream); });
}

template <class Scalar>
Columns<Scalar> BlockSolve<Scalar>::checked(Columns<Scalar> all) const {
  if (all.ldb == 0) all.ldb = rows();
  if (all.ldx == 0) all.ldx = rows();
  if (all.count < 1) throw InvalidInput("nrhs", "must be at least 1");
  if (!all.b) throw InvalidInput("b", "null pointer");
  if (!all.x) throw InvalidInput("x", "null pointer");
  if (all.ldb < rows()) throw InvalidInput("ldb", "must be at least the number of rows");
  if (all.ldx < rows()) throw InvalidInput("ldx", "must be at least the number of rows");
  addressed("ldb", all.count, all.ldb, sizeof(Scalar));
  addressed("ldx", all.count, all.ldx, sizeof(Scalar));
  if (overlap(rows(), all)) throw InvalidInput("x", "overlaps b, but is not the same array");
  return all;
}

// Calls solve_part for one block of columns after another, and reports on all of them together.
template <class Scalar>
template <class SolvePart>
void BlockSolve<Scalar>::solve_parts(const Columns<Scalar>& all, const SolvePart& solve_part) {
  const Stopwatch watch;
  report_.rung = Rung::factors;
  report_.time_ladder = 0;
  report_.refinement_steps = 0;
  report_.krylov_steps = 0;
  report_.corrected_pivots = 0;
  report_.backward_error = 0;
  report_.singularity = 0;
  report_.dependent_rows = 0;
  const Offset block = factors_.numeric().factors().columns_at_once();
  for (Offset first = 0; first < all.count; first += block) {
    Columns<Scalar> part = all;
    part.b += first * all.ldb;
    part.x += first * all.ldx;
    part.count = std::min(block, all.count - first);
    part.before = first;
    solve_part(part);
    phases_.tell("solve", static_cast<double>(first + part.count) / static_cast<double>(all.count));
  }
  factors_.watch_effort();
  report_.time_solve = watch.seconds();
}

// A failing block is left with its own right-hand sides: those before it may lie under their solutions.
template <class Scalar>
void BlockSolve<Scalar>::solve_part(const Columns<Scalar>& part, const SolveOutcome* tried) {
  run_phase(
      options_.dump_prefix, [&] { climb_until_solved(part, tried); },
      [&] {
        return System<Scalar>{factors_.factored_matrix(), part.b, part.count, part.ldb, part.transposed};
      });
}

// On the device, or where that is not enough by way of the host, which goes on from what the device has
// found.
template <class Scalar>
void BlockSolve<Scalar>::solve_part_on_device(const Columns<Scalar>& part, void* stream) {
  const Vertex columns = static_cast<Vertex>(part.count);
  SolveOutcome outcome;
  ResidentSolve found = ResidentSolve::refused;
  const auto require_reachable = [&] {
    const ResidentFactors<Scalar>& factors = factors_.resident("solve_device");
    factors.require_reachable(part.b, "b");
    factors.require_reachable(part.x, "x");
  };
  if (!host_.serves()) {
    phases_.run("solve", [&] {
      require_reachable();
      const SolveBlock<Scalar> block{part.b, part.ldb, part.x, part.ldx, columns, pattern_for(part)};
      found = factors_.numeric("solve_device").solve_resident(block, controls_, stream, outcome);
    });
  }
  if (found == ResidentSolve::solved) {
    note_outcome(outcome);
    report_.bytes_used = factors_.numeric("solve_device").bytes();
    report_.time_ladder += outcome.time_ladder;
    report_.backward_error = std::max(report_.backward_error, outcome.backward_error);
    return;
  }
  const Offset n = rows();
  std::vector<Scalar> held(static_cast<std::size_t>(n) * columns);
  const Columns<Scalar> on_host{held.data(), held.data(), part.count, n, n, part.transposed};
  phases_.run("solve", [&] {
    require_reachable();
    factors_.resident("solve_device").download(part.b, part.ldb, n, columns, held.data(), stream);
  });
  check_finite<Scalar>(n, columns, held.data(), n, part.before);
  solve_part(on_host, found == ResidentSolve::missed ? &outcome : nullptr);
  phases_.run("solve", [&] {
    factors_.resident("solve_device").upload(held.data(), n, columns, part.x, part.ldx, stream);
  });
}

template <class Scalar>
void BlockSolve<Scalar>::climb_until_solved(const Columns<Scalar>& part, const SolveOutcome* tried) {
  if (host_.serves()) return solve_on_host(part);
  SolveOutcome outcome = solve_with_factors(part, tried);
  report_.time_ladder += outcome.time_ladder;
  if (settled(outcome)) return write_solution(part, factors_.numeric("solve").solution(), outcome);
  bool doubtful = outcome.doubtful;
  const Stopwatch other_factors;
  while (!settled(outcome) && factors_.climb(outcome.dependent_rows > 0)) {
    outcome = solve_with_factors(part);
    doubtful |= outcome.doubtful;
  }
  const Scalar* found = factors_.numeric("solve").solution();
  std::vector<Scalar> solution(found, found + rows() * part.count);
  const Offset overflowed = first_overflowed(rows(), part.count, solution);
  const auto missed = [&] { return !reached(outcome) && outcome.dependent_rows == 0; };
  if (missed() && !factors_.host_is_better()) outcome = solve_rescaled(part, solution.data());
  if (missed() && !factors_.on_device()) try_orthogonal(part, solution.data(), outcome);
  report_.time_ladder += other_factors.seconds();
  const bool singular_for_sure = outcome.dependent_rows > 0 && !factors_.host_is_better();
  if (!reached(outcome) && factors_.on_device() && !singular_for_sure) {
    try {
      return solve_on_host(part);
    } catch (const OutOfMemory&) {  // what the device has found is told instead
    }
  }
  if (!reached(outcome)) refuse(outcome, doubtful, overflowed);
  write_solution(part, solution.data(), outcome);
}

// The solver on the host has checks, a ladder and refusals of its own.
template <class Scalar>
void BlockSolve<Scalar>::solve_on_host(const Columns<Scalar>& part) {
  const Stopwatch watch;
  report_.rung = Rung::host;
  BasicSolver<Scalar>& host = host_.solver();
  part.transposed ? host.solve_transpose(part.b, part.x, part.count, part.ldb, part.ldx)
                  : host.solve(part.b, part.x, part.count, part.ldb, part.ldx);
  host_.note_solved();
  const Report& found = host.report();
  report_.refinement_steps = std::max(report_.refinement_steps, found.refinement_steps);
  report_.krylov_steps = std::max(report_.krylov_steps, found.krylov_steps);
  report_.corrected_pivots = std::max(report_.corrected_pivots, found.corrected_pivots);
  report_.backward_error = std::max(report_.backward_error, found.backward_error);
  report_.singularity = std::max(report_.singularity, found.singularity);
  report_.dependent_rows = std::max(report_.dependent_rows, found.dependent_rows);
  report_.time_ladder += watch.seconds();
}

// Each column by factors of its own, with rows scaled for it.
template <class Scalar>
SolveOutcome BlockSolve<Scalar>::solve_rescaled(const Columns<Scalar>& part, Scalar* solution) {
  SolveOutcome worst;
  for (Offset j = 0; j < part.count && reached(worst); ++j) {
    Columns<Scalar> column = part;
    column.b += j * part.ldb;
    column.count = 1;
    factors_.rescale(column.b, part.transposed);
    const SolveOutcome outcome = solve_with_factors(column);
    if (!(outcome.backward_error <= worst.backward_error)) worst = outcome;
    const Scalar* found = factors_.numeric("solve").solution();
    std::copy(found, found + rows(), solution + j * rows());
  }
  worst.dependent_rows = 0;  // nothing that was singular comes here
  return worst;
}

// Bytes that the last resort may take.
template <class Scalar>
double BlockSolve<Scalar>::room_left() const {
  const auto held = static_cast<double>(factors_.numeric("solve").bytes());
  return options_.memory_limit > 0 ? static_cast<double>(options_.memory_limit) - held
                                   : static_cast<double>(available_host_memory()) / 2;
}

// Leaves `outcome` where that would take too much, or reaches no more.
template <class Scalar>
void BlockSolve<Scalar>::try_orthogonal(const Columns<Scalar>& part, Scalar* solution,
                                        SolveOutcome& outcome) {
  constexpr double kRounding = 64 * std::numeric_limits<RealOf<Scalar>>::epsilon();
  if (outcome.backward_error <= kRounding) return;  // nothing has grown
  const SymbolicPlan& plan = *factors_.analysis().plan;
  SolveOutcome worst;
  std::vector<Scalar> found(static_cast<std::size_t>(rows() * part.count));
  const auto solve_all = [&] {
    const auto solver = OrthogonalSolver<Scalar>::make(
        factors_.factored_matrix(), part.transposed, factors_.analysis().matched,
        part.transposed ? plan.row_of : plan.column_of, room_left());
    if (!solver) return false;
    report_.rung = Rung::orthogonal;
    for (Offset j = 0; j < part.count && reached(worst); ++j) {
      const SolveOutcome column = solver->solve(part.b + j * part.ldb, found.data() + j * rows(), controls_);
      if (!(column.backward_error <= worst.backward_error)) worst = column;
    }
    if (solver->smallness() <= singular_below<Scalar>()) {
      worst.dependent_rows = 1;
      worst.singularity = solver->smallness();
      (part.transposed ? worst.row : worst.column) = solver->dependent_column();
      if (!controls_.solve_singular) worst.backward_error = std::numeric_limits<double>::infinity();
      return true;
    }
    return reached(worst);
  };
  bool better = false;
  phases_.run("solve", [&] {
    try {
      better = solve_all();
    } catch (const std::bad_alloc&) {  // what the factors have reached is told instead
    }
  });
  if (!better) return;
  std::copy(found.begin(), found.end(), solution);
  outcome = worst;
}

template <class Scalar>
void BlockSolve<Scalar>::write_solution(const Columns<Scalar>& part, const Scalar* solution,
                                        const SolveOutcome& outcome) {
  report_.bytes_used = factors_.numeric("solve").bytes();
  report_.backward_error = std::max(report_.backward_error, outcome.backward_error);
  if (outcome.dependent_rows > 0) {
    report_.singularity = outcome.singularity;
    report_.dependent_rows = outcome.dependent_rows;
  }
  with_threads(part.count, [&](int threads) {
    copy_columns<Scalar>(rows(), part.count, solution, rows(), part.x, part.ldx, threads);
  });
}

// work(threads) for so many columns; few entries are not worth the team of a phase.
template <class Scalar>
template <class Work>
void BlockSolve<Scalar>::with_threads(Offset columns, const Work& work) {
  constexpr Offset kMany = 1 << 16;
  if (rows() * columns < kMany) return work(1);
  phases_.run("solve", [&] { work(phases_.threads_at_work()); });
}

// One pass over the present factors, and what can be made of it with them; `tried`: what solve_resident left
// of it.
template <class Scalar>
SolveOutcome BlockSolve<Scalar>::solve_with_factors(const Columns<Scalar>& part, const SolveOutcome* tried) {
  const Vertex columns = static_cast<Vertex>(part.count);
  Factorization<Scalar>& numeric = factors_.numeric("solve");
  SolveOutcome outcome;
  phases_.run("solve", [&] {
    const TransposedPattern* pattern = pattern_for(part);
    Scalar* rhs = numeric.rhs(columns);
    copy_columns(rows(), part.count, part.b, part.ldb, rhs, rows(), phases_.threads_at_work());
    outcome = numeric.solve(columns, pattern, controls_, tried);
  });
  note_outcome(outcome);
  return outcome;
}

template <class Scalar>
const TransposedPattern* BlockSolve<Scalar>::pattern_for(const Columns<Scalar>& part) {
  return part.transposed ? &factors_.transposed_pattern() : nullptr;
}

template <class Scalar>
void BlockSolve<Scalar>::note_outcome(const SolveOutcome& outcome) {
  report_.refinement_steps = std::max(report_.refinement_steps, outcome.refinement_steps);
  report_.krylov_steps = std::max(report_.krylov_steps, outcome.krylov_steps);
  report_.corrected_pivots = std::max<std::int64_t>(report_.corrected_pivots, outcome.corrected_pivots);
  report_.rung = std::max(report_.rung, rung_of(outcome));
  if (phases_.logs(2) && outcome.doubtful) phases_.log(2, "whether the matrix is singular is not known");
}

// The tolerance was missed: because A is singular, or in spite of a regular A.
template <class Scalar>
void BlockSolve<Scalar>::refuse(const SolveOutcome& outcome, bool doubtful, Offset overflowed) const {
  if (outcome.dependent_rows == 0 || !factors_.within_range()) {
    AccuracyNotReached error(outcome.backward_error, controls_.tolerance);
    if (overflowed >= 0)
      error.append("; entry " + std::to_string(overflowed) +
                   " of the solution (counted from 0) is beyond the range of its numbers");
    if (!factors_.within_range())
      error.append("; scales or factors are beyond the range of their numbers");
    else if (doubtful)
      error.append("; whether the matrix is singular to working precision is not known");
    throw error;
  }
  char text[200];
  std::snprintf(text, sizeof text,
                "the matrix is singular to working precision: some z has |A z| = %.1e | |A||z| |%s",
                outcome.singularity,
                controls_.solve_singular ? "" : "; solve_singular asks for a solution all the same");
  throw SingularMatrix(SingularMatrix::Kind::numerical, outcome.row, outcome.column, outcome.dependent_rows,
                       text);
}

template class BlockSolve<float>;
template class BlockSolve<double>;
template class BlockSolve<std::complex<float>>;
template class BlockSolve<std::complex<double>>;

}  // namespace mfs
