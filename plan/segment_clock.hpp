// How long a refactorization and a solve by segments (plan/segments.hpp) take, for plans to be compared by:
// one after the other, a segment begins when what lies in its way has left, and its factors begin to leave
// when it is done and what left before has gone.
#pragma once

#include <vector>

#include "plan/segments.hpp"

namespace mfs {

/// Seconds, and entries or operations of real double precision per second.
struct SegmentRates {
  double segment;           // to launch and end one
  double tile;              // for each 128 pivots of its longest front, one tile after the other
  double flops, half_size;  // of large fronts, and the equivalent size of those that reach half of it
  double memory;            // entries
  double copy;              // to begin one
  double out, in;           // entries over the link
};

class SegmentClock {
 public:
  SegmentClock(const SymbolicPlan& plan, Outside outside);

  /// Of one refactorization, s. `segments` needs its segments, their order, what leaves, and border columns.
  double refactor_seconds(const SegmentPlan& segments) const;
  /// Of one where all fits, depth by depth, s.
  double whole_refactor_seconds() const;
  /// Of the copies of one solve, s.
  double solve_seconds(const SegmentPlan& segments) const;
  /// Of both.
  double seconds(const SegmentPlan& segments) const {
    return refactor_seconds(segments) + solve_seconds(segments);
  }
  /// Of both at least, wherever these segments lie in a region of so many entries.
  double least_seconds(const SegmentPlan& segments, Offset region) const;
  /// How much longer both take, s, where the matrix is in the memory of the host.
  double seconds_of_matrix() const;

 private:
  template <class FrontAt>
  double seconds_together(Vertex begin, Vertex end, const FrontAt& front) const;
  std::vector<double> busy_seconds(const SegmentPlan& segments) const;
  std::vector<double> reading_seconds(const SegmentPlan& segments) const;
  double tiles_seconds(Vertex f) const;

  const SymbolicPlan& plan_;
  const SegmentRates rates_;
  std::vector<double> front_;  // num_fronts: s of its operations and its traffic
};

}  // namespace mfs
