// A scalar program executed in Kokkos' default space, whichever that is, with a team of threads for a system.
#pragma once

#include <memory>
#include <vector>

#include "kernels/lanes/lane_outcome.hpp"
#include "kernels/lanes/lane_program.hpp"
#include "plan/level_schedule.hpp"

namespace mfs::lanes {

template <class Scalar>
class SpaceLanes {
 public:
  virtual ~SpaceLanes() = default;
  /// Systems for which there is room at a time; more are solved one part after the other.
  virtual Offset capacity() const = 0;
  virtual Offset nrhs() const = 0;
  virtual Offset bytes() const = 0;
  /// Writes the solutions of the lanes that reach the tolerance in all columns; those of others stay as they
  /// are. The arrays lie in the memory of the space where they are `resident`, else in that of the host. What
  /// was put into `stream`, a cudaStream_t of the caller, before is waited for. outcome [systems.count].
  /// Throws BackendError, OutOfMemory, std::bad_alloc.
  virtual void solve(const LaneSystems<Scalar>& systems, bool resident, void* stream,
                     LaneOutcome* outcome) = 0;
};

/// With room for at most `count` systems, and fewer where `most_bytes` of its memory, or what is free, are
/// too few for all. `levels`: of the same program; it is copied. Must be made and used inside Engine::run.
/// Throws OutOfMemory(device) where there is no room for one team and one system, std::bad_alloc.
template <class Scalar>
std::unique_ptr<SpaceLanes<Scalar>> make_space_lanes(const LaneProgram& program, const LevelSchedule& levels,
                                                     const LaneRules& rules, Offset nrhs, Offset count,
                                                     Offset most_bytes);

/// Copies of bytes between the memory of the host and that of the space, after what was put into `stream`;
/// inside Engine::run.
struct SpaceCopy {
  const void* from;
  void* to;
  Offset bytes;
};
void copy_to_host(const std::vector<SpaceCopy>& copies, void* stream);
void copy_to_space(const std::vector<SpaceCopy>& copies, void* stream);

}  // namespace mfs::lanes
