// Systems of a batch on the host: by lanes where there is a program for them, and by fronts, with the common
// plan or by themselves, where there is none or where a lane has failed.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include <mfs/batch_solver.hpp>
#include <mfs/solver.hpp>

#include "kernels/lanes/host_lanes.hpp"
#include "solver/common_plan.hpp"
#include "solver/phases.hpp"

namespace mfs {

/// Systems `first` and those after it, as lanes have them.
template <class Scalar>
lanes::LaneSystems<Scalar> lane_systems(const Batch<Scalar>& batch, Offset first, Offset count) {
  return {count,
          batch.values + first * batch.values_stride,
          batch.values_stride,
          batch.b + first * batch.b_stride,
          batch.x + first * batch.x_stride,
          batch.nrhs,
          batch.ldb,
          batch.ldx,
          batch.b_stride,
          batch.x_stride};
}

/// Whether the lane has solved its system, of which the report then says so.
inline bool take_outcome(const lanes::LaneOutcome& outcome, SystemReport& report) {
  if (!outcome.solved) return false;
  report.backward_error = outcome.backward_error;
  report.rung = outcome.steps > 0 ? Rung::refinement : Rung::factors;
  return true;
}

template <class Scalar>
class HostBatch {
 public:
  /// All must outlive this; `program` may be null.
  HostBatch(const Options& options, Phases& phases, bool single_precision, const Analysis& analysis,
            const lanes::LaneProgram* program);

  /// All systems, each by one thread; numbers of the batch must be complete. Throws OutOfMemory,
  /// std::bad_alloc and what Phases::run does.
  void solve(const Batch<Scalar>& batch, std::vector<SystemReport>& reports);
  /// Those of `which`, by fronts.
  void solve(const Batch<Scalar>& batch, const std::vector<Offset>& which,
             std::vector<SystemReport>& reports);

 private:
  int threads() const;
  void make_fronts(int count);
  void make_lanes(int count, Offset nrhs);
  template <class Prepare>
  void share_out(Offset count, Offset piece, const Prepare& prepare);
  void solve_piece(std::size_t thread, const Batch<Scalar>& batch, Offset first, Offset count,
                   std::vector<SystemReport>& reports);
  void solve_one(std::size_t thread, const Batch<Scalar>& batch, Offset k, SystemReport& report);

  const Options& options_;
  const Options alone_;
  Phases& phases_;
  const bool single_precision_;
  const Analysis& analysis_;
  const lanes::LaneProgram* const program_;
  std::vector<std::unique_ptr<CommonPlan<Scalar>>> fronts_;  // one for each thread
  std::vector<std::unique_ptr<lanes::HostLanes<Scalar>>> lanes_;
  std::atomic<Offset> next_{0};  // system
};

}  // namespace mfs
