// Places for the segments of one order of a plan (plan/segments.hpp): what lies in the region at the same
// time, what a schedule has to wait for, and where things go in the memory of the host.
#pragma once

#include <vector>

#include "plan/segment_order.hpp"
#include "plan/segments.hpp"

namespace mfs {

/// Entries of the region from segment `from` to segment `to`, both included. If it lay there from `first` to
/// `last` alone, no segment and no copy would have to wait for another one.
struct Block {
  Offset entries;
  Vertex from, to;
  Offset place;
  Vertex first = from, last = to;

  bool meets(const Block& other) const { return from <= other.to && other.from <= to; }
  bool waits_for(const Block& other) const { return first <= other.last && other.first <= last; }
  bool overlaps(const Block& other) const {
    return place < other.place + other.entries && other.place < place + entries;
  }
};

/// How many segments may be on their way to the host while another is made, if there is room, and how many on
/// their way back. Blocks of more than a quarter of the region leave beside `large_out` segments. Fronts that
/// read in the memory of the host are assembled beside so many segments before theirs.
struct Ahead {
  Vertex out, back, large_out, assembled;
};

/// What is done where factors alone must not leave. Contribution blocks leave if as many segments are done
/// until they are read. Fronts that take more than one of `fronts` parts of the region are divided (0: none),
/// their border into columns of which `groups` fit beside [P; L]. The contribution block of the child before
/// stays all the while, if it and [P; L] have at most `beside` eighths of the region; those of other children
/// leave.
struct Way {
  Vertex leaving_distance;
  Offset fronts, groups, beside;
};

/// Contribution blocks that lie side by side, or those columns of one: from when on, and until when a segment
/// reads them.
struct Contributions {
  Block made;
  Vertex first_reader;
  bool leave;
  Vertex divided;  // the front, if there are columns of one
};

/// Places the segments of one order; one use for each place().
class SegmentPlaces {
 public:
  SegmentPlaces(const SymbolicPlan& plan, const SegmentOrder& order, const Way& way, Offset region,
                Vertex small_rows, Outside outside)
      : plan_(plan), way_(way), region_(region), small_rows_(small_rows), outside_(outside) {
    list_segments(order);
    group_contributions();
  }

  Vertex count() const { return static_cast<Vertex>(made_.segments.size()); }
  /// The segments and their fronts, before they have places.
  const SegmentPlan& segments() const { return made_; }
  /// Divided fronts leave, and all before them.
  Vertex first_that_may_stay() const;

  /// Where segments from `first_staying` on stay. Returns the entries of the region that it takes.
  Offset place(Vertex first_staying, const Ahead& ahead, Offset spare);

  /// As it was placed last: what leaves, and what a segment waits for; not where its fronts lie.
  const SegmentPlan& schedule();
  /// The plan as it was placed last.
  SegmentPlan finish();

 private:
  Offset lower_entries(Vertex f) const {
    return aligned(static_cast<Offset>(plan_.pivots(f)) * plan_.lower_ld(f));
  }
  Offset upper_entries(Vertex f) const {
    return aligned(static_cast<Offset>(plan_.pivots(f)) * plan_.border_rows(f));
  }
  Offset contribution_entries(Vertex f) const {
    return aligned(static_cast<Offset>(plan_.border_rows(f)) * plan_.contribution_ld(f));
  }
  Offset upper_entries(const BorderColumns& columns) const {
    return aligned(static_cast<Offset>(plan_.pivots(columns.front)) * (columns.end - columns.begin));
  }
  Offset contribution_entries(const BorderColumns& columns) const {
    return static_cast<Offset>(plan_.contribution_ld(columns.front)) * (columns.end - columns.begin);
  }
  // Entries of U and of C left of some columns.
  Offset upper_before(const BorderColumns& columns) const {
    const Vertex p = plan_.pivots(columns.front);
    return static_cast<Offset>(columns.begin - p) * p;
  }
  Offset contribution_before(const BorderColumns& columns) const {
    return static_cast<Offset>(columns.begin - plan_.pivots(columns.front)) *
           plan_.contribution_ld(columns.front);
  }

  void list_segments(const SegmentOrder& order);
  void divide(Vertex f);
  bool stays_beside(Vertex f, Offset parent) const;
  Offset last_child_beside(Vertex f, Offset lower) const;
  void group_contributions();
  void place_in_factorization(const Ahead& ahead);
  bool writes_over(Vertex t, const Block& block) const;
  Vertex leaves_first(Vertex t) const;
  Vertex assembled_after(Vertex t) const;
  void place_in_solve(Vertex back);
  void find_orders();
  SideBlocks blocks_of(Side side) const;
  void add_lower_part(Vertex f, Side side, Offset begin, std::vector<SegmentBlock>& blocks) const;
  void list_leaving();
  void place_contributions_on_host();
  void place_fronts();
  void place_border_columns();

  const SymbolicPlan& plan_;
  SegmentPlan made_;
  const Way way_;
  const Offset region_;
  const Vertex small_rows_;
  const Outside outside_;
  std::vector<Contributions> contributions_;  // one for each pair of segments, by the first
  std::vector<Block> blocks_;                 // all that lies in the region in a factorization, by `from`
  std::vector<Vertex> blocks_begin_;          // segments + 1: of those
  std::vector<char> reads_outside_;           // of segments: contribution blocks that have left
  std::vector<Offset> on_host_;               // of them: where they lie there, -1 if they do not leave
  std::vector<Offset> group_of_;              // of fronts: the (first) one in contributions_, -1 for none
  std::vector<Offset> upper_place_;           // of SegmentPlan::border_columns: where these columns of U lie
  Vertex stay_ = 0;                           // the first segment that stays
};

}  // namespace mfs
