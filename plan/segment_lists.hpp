// The launches of depths divided among their segments, as the last step in which a device plan is made.
#pragma once

#include <vector>

#include "plan/device_plan.hpp"

namespace mfs {

/// Writes DevicePlan::depths anew, one for each segment, and the lists that they refer to; one use.
class SegmentLists {
 public:
  SegmentLists(const SymbolicPlan& plan, const DeviceLimits& limits, DevicePlan& made)
      : plan_(plan), limits_(limits), made_(made) {}
  void run();

 private:
  void divide_fronts();
  void divide_parts();
  void divide_launches(std::vector<Launch> DepthLaunches::*launches);
  template <class Task>
  void divide(const Launch& launch, const std::vector<Task>& tasks, Vertex Task::*first,
              std::vector<Task>& divided, std::vector<Launch> DepthLaunches::*launches);
  template <class Take>
  void for_each_piece(const StepTask& task, const Take& take) const;
  template <class Take>
  void for_each_piece(const ProductTask& task, const Take& take) const;
  Vertex blocks_of(const StepTask& task, const Launch& launch) const;
  Vertex blocks_of(const ProductTask& task, const Launch& launch) const;
  void divide_blocks();
  void divide_wide_tiles();

  const SymbolicPlan& plan_;
  const DeviceLimits& limits_;
  DevicePlan& made_;
  std::vector<DepthLaunches> segments_;
  std::vector<StepTask> steps_;
  std::vector<ProductTask> products_;
};

}  // namespace mfs
