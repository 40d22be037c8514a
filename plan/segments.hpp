// A factorization in less memory than the region of its plan takes. Its fronts are done in segments: runs of
// fronts of one depth, which a device takes as one, in an order in which no front comes before its children.
// The region is smaller than all factors: those of a segment leave it for the memory of the host while the
// next ones are made, and come back, segment by segment, in each pass of a solve. The last segments, whose
// factors need not leave, stay where they are. Contribution blocks leave only where nothing fits else, those
// that wait for their parents; a parent reads them in the memory of the host.
//
//   level 0            7          Sibling direction: a depth is cut where its factors would take too much of
//                   /     \       the region. Depth direction: below some level of the tree, here 1, the
//   level 1        3       6      subtrees are done one after the other, so that fewer contribution blocks
//                 / \     / \     wait at a time; above, a front is done as soon as its children are. Level
//                1   2   4   5    0 is the order of the plan itself.
//
//   the region in a factorization                             in a solve
//   | stay: 7 ... 6 | factors and contribution blocks ... |   | stay | vectors | segments that come and go |
//
// Each front has the operations of the same tiles as in a plan of one piece, and so the same factors, bit for
// bit.
#pragma once

#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Fronts order[begin] ... order[end - 1]; `step` is that of their depth. Places are entries of the region.
struct Segment {
  Vertex begin = 0, end = 0;
  Vertex step = 0;
  Offset entries = 0;      // of its factors
  Offset place = 0;        // of them in a factorization
  Offset solve_place = 0;  // and in a solve: the same if they stay
  Offset host = -1;        // in the memory of the host, in entries; -1 if they stay
  // What leaves of segments before this one must have left when it begins.
  Vertex leaves_first = 0;
  // In a solve: the segment that must be done with before the factors of this one may come, forward the last
  // one before it, backward the first one after it; -1 where there is none. Backward they are then still
  // there from the forward pass.
  Vertex forward_after = -1, backward_after = -1;

  bool stays() const { return host < 0; }
};

/// Contribution blocks of segment `from`, side by side, that leave the region when it is done: to `host`,
/// where segment `to` reads them.
struct LeavingBlocks {
  Vertex from, to;
  Offset place, entries, host;
};

struct SegmentPlan {
  std::vector<Segment> segments;
  std::vector<Vertex> order;                       // num_fronts
  std::vector<Vertex> segment;                     // num_fronts: the one that a front belongs to
  std::vector<Offset> lower, upper, contribution;  // num_fronts: in place of those of the symbolic plan
  Vertex level = 0;                                // below which subtrees are done one by one
  Offset region_entries = 0;                       // that it takes
  Offset host_entries = 0;                         // of factors in the memory of the host
  std::vector<LeavingBlocks> leaving;              // by `from`; they lie behind those factors
  Offset leaving_entries = 0;                      // that they take there
  // num_fronts: where the contribution block is read in the memory of the host, -1 for where it is made.
  std::vector<Offset> read_on_host;
  Offset spare_begin = 0, spare_entries = 0;  // of the region in a solve, where no factors come

  bool empty() const { return segments.empty(); }
  /// Entries of contribution blocks that one factorization sends to the host, and reads there.
  Offset blocks_out() const;
  /// Where a front's [P; L] and U lie in a solve.
  Offset solve_shift(Vertex f) const {
    const Segment& own = segments[segment[f]];
    return own.solve_place - own.place;
  }
  /// Entries that come back in one solve.
  Offset entries_back() const;
};

/// For at most `region` entries of which `spare` are free in a solve. Of the plans that fit, one that leaves
/// most on the device, the fewer levels the better, and no contribution blocks leave if that can be. Empty
/// where none fits.
SegmentPlan make_segments(const SymbolicPlan& plan, Offset region, Offset spare);
/// The least region for which make_segments finds a plan.
Offset least_region(const SymbolicPlan& plan, Offset spare);

/// The symbolic plan with the places that the segments give to factors and contribution blocks, and all of
/// these assembled in one turn.
SymbolicPlan placed_by(const SegmentPlan& segments, const SymbolicPlan& plan);

}  // namespace mfs
