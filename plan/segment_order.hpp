// In which order the fronts of a plan are done where they are done in segments (drawing in
// plan/segments.hpp).
#pragma once

#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Segment t has fronts[begin[t]] ... fronts[begin[t + 1] - 1], ascending, of the depth of step[t].
struct SegmentOrder {
  Vertex level = 0;
  std::vector<Vertex> fronts;
  std::vector<Vertex> begin{0};  // segments + 1
  std::vector<Vertex> step;
};

/// Subtrees below `level` (0: none) one after the other, each depth by depth, and a front above as soon as
/// its children are done. A segment with more than one front has at most `most` entries of factors. All roots
/// are the last segment, whatever they have.
SegmentOrder order_segments(const SymbolicPlan& plan, Vertex level, Offset most);

}  // namespace mfs
