// A scalar program executed on the host, by the thread that calls, for kHostLanes systems at the same time.
#pragma once

#include <vector>

#include "kernels/lanes/lane_outcome.hpp"
#include "kernels/lanes/lane_program.hpp"
#include "kernels/runtime/arena.hpp"
#include "ordering/number_parts.hpp"

namespace mfs::lanes {

constexpr int kHostLanes = 8;

/// Arrays of lanes of one thread. `open`: 1 for lanes that are still refined, else 0.
template <class Scalar>
struct LaneArrays {
  using Real = typename NumberParts<Scalar>::type;
  ProgramView program;
  Real *values, *factors, *b, *r, *y, *failed, *open;
  double* errors;
};

/// Bytes of the arrays of one thread.
Offset lane_bytes(const ProgramView& program, Offset number_bytes, Offset nrhs);

/// The memory of one thread, and what it does. `program` must outlive this.
template <class Scalar>
class HostLanes {
 public:
  /// Throws std::bad_alloc.
  HostLanes(const ProgramView& program, const LaneRules& rules, Offset nrhs);

  Offset nrhs() const { return nrhs_; }
  /// Of at most kHostLanes systems. Writes the solutions of the lanes that reach the tolerance in all
  /// columns; those of others stay as they are. outcome [systems.count].
  void solve(const LaneSystems<Scalar>& systems, LaneOutcome* outcome);

 private:
  using Real = typename NumberParts<Scalar>::type;

  void solve_column(const LaneSystems<Scalar>& systems, Offset column, LaneOutcome* outcome);

  const LaneRules rules_;
  const Offset nrhs_;
  HostArena arena_;
  LaneArrays<Scalar> at_;
  Real* x_;  // n x nrhs
};

}  // namespace mfs::lanes
