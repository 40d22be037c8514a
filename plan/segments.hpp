// A factorization in less memory than the region of its plan takes. Its fronts are done in segments: runs of
// fronts of one depth, which a device takes as one, in an order in which no front comes before its children.
// The region is smaller than all factors: those of a segment leave it for the memory of the host while the
// next ones are made, and come back, segment by segment, in each pass of a solve. The last segments, whose
// factors need not leave, stay where they are. Contribution blocks leave only where nothing fits else, those
// that wait for their parents; a parent reads them in the memory of the host, beside what the segments before
// it compute. Where a front does not fit, it is divided: [P; L] is factored first and stays until columns
// [U; C], as many as fit beside it, have been assembled, solved for, updated and sent to the host, one group
// of columns after the other. So all moves once, and what must fit is [P; L] and two groups.
//
//   level 0            7          Sibling direction: a depth is cut where its factors would take too much of
//                   /     \       the region. Depth direction: below some level of the tree, here 1, the
//   level 1        3       6      subtrees are done one after the other, so that fewer contribution blocks
//                 / \     / \     wait at a time; above, a front is done as soon as its children are. Level
//                1   2   4   5    0 is the order of the plan itself.
//
// A pass of a solve reads one triangle of the pivot blocks, and L or U. So all [P; L] of a segment lie before
// all U, and of large fronts what a pass does not read stays outside.
//
//   the region in a factorization                             in a solve
//   | stay: 7 ... 6 | factors and contribution blocks ... |   | stay | vectors | segments that come and go |
//
// Each front has the operations of the same tiles as in a plan of one piece, and so the same factors, bit for
// bit. The host does the same with a file in place of its memory (kernels/stages/segment_moves.hpp).
#pragma once

#include <utility>
#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Fronts order[begin] ... order[end - 1]; `step` is that of their depth. Places are entries of the region.
/// Border columns of a divided front have segments without fronts, right after its own.
struct Segment {
  Vertex begin = 0, end = 0;
  Vertex step = 0;
  Offset entries = 0;      // of its factors, in a divided front those of all its segments
  Offset place = 0;        // of them in a factorization, in a divided front of [P; L]
  Offset solve_place = 0;  // and in a solve: the same if they stay
  Offset host = -1;        // in the memory of the host, in entries; -1 if they stay
  bool divided = false;
  bool solved_on_host = false;  // a solve reads them where they lie there
  // What leaves of segments before this one must have left when it begins.
  Vertex leaves_first = 0;
  // When so many segments are done, its fronts may be assembled beside the next ones: of segments that read
  // in the memory of the host, else its own number.
  Vertex assembled_after = 0;
  // In a solve: the segment that must be done with before the factors of this one may come, forward the last
  // one before it, backward the first one after it; -1 where there is none. Backward they are then still
  // there from the forward pass.
  Vertex forward_after = -1, backward_after = -1;

  bool stays() const { return host < 0; }
  bool comes() const { return !stays() && !solved_on_host; }
};

/// What leaves the region when segment `from` is done: factors, or contribution blocks, side by side, which
/// segment `to` is the first to read in the memory of the host (-1: factors).
struct LeavingBlock {
  Vertex from, to;
  Offset place, entries, host;
};

/// Columns [begin, end) of a divided front, all right of its pivots, whose [U; C] `segment` makes. `upper`
/// and `contribution` are where U and C would begin if the columns before these lay there, too.
struct BorderColumns {
  Vertex front, begin, end;
  Vertex segment;
  Offset upper, contribution;
};

/// What a pass reads of fronts: the lower triangles of P, and L; or the upper ones, and U.
enum class Side { lower, upper };

/// `columns` of `rows` entries, `ld` apart, from `begin` on, counted from the first entry of a segment.
struct SegmentBlock {
  Offset begin, rows, ld, columns;
};

/// What comes of one side, segment by segment: those of segment t from begin[t] to begin[t + 1]. It covers
/// what a pass reads, the tiles of 64 rows and columns on the diagonal as a whole.
struct SideBlocks {
  std::vector<std::size_t> begin;
  std::vector<SegmentBlock> blocks;

  bool empty() const { return begin.empty(); }
  Offset entries(Vertex t) const;
};

struct SegmentPlan {
  std::vector<Segment> segments;
  std::vector<Vertex> order;    // num_fronts
  std::vector<Vertex> segment;  // num_fronts: the (first) one that a front belongs to
  // num_fronts, in place of those of the symbolic plan; in a divided front U and C lie as border_columns say.
  std::vector<Offset> lower, upper, contribution;
  // num_fronts: where a solve finds [P; L] and U, in the memory of the host if Segment::solved_on_host.
  std::vector<Offset> solve_lower, solve_upper;
  std::vector<BorderColumns> border_columns;  // of divided fronts, ascending
  Vertex level = 0;                           // below which subtrees are done one by one
  Offset region_entries = 0;                  // that it takes
  Offset host_entries = 0;                    // of factors in the memory of the host
  std::vector<LeavingBlock> leaving;          // by `from`, contribution blocks first
  Offset leaving_entries = 0;                 // that those take in the memory of the host, behind the factors
  // num_fronts: where the contribution block is read in the memory of the host, -1 for where it is made.
  std::vector<Offset> read_on_host;
  Offset spare_begin = 0, spare_entries = 0;  // of the region in a solve, where no factors come
  SideBlocks lower_side, upper_side;          // without any, whole segments come

  bool empty() const { return segments.empty(); }
  bool has_divided() const { return !border_columns.empty(); }
  /// Whether its fronts may be assembled beside segments before it.
  bool is_assembled_early(Vertex t) const { return !empty() && segments[t].assembled_after < t; }
  bool solved_on_host(Vertex f) const { return segments[segment[f]].solved_on_host; }
  const SideBlocks& side(Side side) const { return side == Side::lower ? lower_side : upper_side; }
  /// Entries of contribution blocks that one factorization sends to the host, and reads there.
  Offset blocks_out() const;
  /// Entries that come back in one solve, or are read on the host.
  Offset entries_back() const;
  /// Of one front, ascending: two ends of a range, which is empty unless it is divided.
  std::pair<const BorderColumns*, const BorderColumns*> columns_of(Vertex f) const;
  /// The one that makes this column of a front.
  Vertex segment_of(Vertex f, Vertex column) const;
  /// The last one of a front.
  Vertex last_segment_of(Vertex f) const;
};

/// Where that goes which leaves the region: to memory, where segments may read it, or to a file, from where
/// it must come back first. Then factors alone leave, and no front is divided.
enum class Outside { memory, file };

/// For at most `region` entries of which `spare` are free in a solve. Of the plans that fit, one by which a
/// refactorization and a solve take least time, as plan/segment_clock.hpp foresees it; contribution blocks
/// leave, and fronts of more than `small_rows` rows are divided, only if that must be. Empty where none fits.
SegmentPlan make_segments(const SymbolicPlan& plan, Offset region, Offset spare, Vertex small_rows,
                          Outside outside = Outside::memory);
/// The least region for which make_segments finds a plan, to a few percent.
Offset least_region(const SymbolicPlan& plan, Offset spare, Vertex small_rows,
                    Outside outside = Outside::memory);

/// The symbolic plan with the places that the segments give to factors and contribution blocks, and all of
/// these assembled in one turn.
SymbolicPlan placed_by(const SegmentPlan& segments, const SymbolicPlan& plan);

}  // namespace mfs
