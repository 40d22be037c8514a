// How a device solves with the factors: tiles and parts of tiles in the order in which they wait for each
// other, and where the rows of a front find what its children left.
#pragma once

#include <cstddef>
#include <vector>

#include "plan/device_plan.hpp"

namespace mfs {

/// Writes DevicePlan::tiny_fronts, wide_tiles, solve, forward, backward, row_begin, source_begin,
/// destination, solve_lower and solve_upper.
class SolveLists {
 public:
  SolveLists(const SymbolicPlan& plan, const DeviceLimits& limits, DevicePlan& made)
      : plan_(plan), limits_(limits), made_(made) {}
  /// Throws BackendError where borders have more rows than the lists can count.
  void run();

 private:
  // What the solve does with the fronts of a depth, or of a segment.
  struct SolveDepth {
    std::vector<Vertex> fronts;  // in tiles
    Range tiny;
    bool crowded;  // borders of the whole depth have more tiles than the device can hold
  };
  struct SortedFronts {
    std::vector<Vertex> tiny, in_tiles;
    bool crowded = false;
  };
  bool by_segments() const { return !made_.segments.empty(); }
  void place_factors();
  Offset lower_of(Vertex f) const { return by_segments() ? made_.solve_lower[f] : plan_.lower_begin[f]; }
  Offset upper_of(Vertex f) const { return by_segments() ? made_.solve_upper[f] : plan_.upper_begin[f]; }
  void number_rows();
  void list_solve();
  void list_sources();
  void list_wide_tiles();

  std::vector<SolveDepth> segments_of_depths();
  SortedFronts sort_depth(Vertex step) const;
  Range list_tiny(const std::vector<Vertex>& tiny);
  template <class List>
  void list_tiles(const SolveDepth& depth, std::vector<SolveLaunch>& launches, const List& list);
  void list_forward(const SolveDepth& depth);
  void list_backward(const std::vector<Vertex>& fronts);
  void list_parts_back(Vertex f, Vertex turn, Offset first_place);
  void list_tile_back(Vertex f, Vertex turn, Offset first_place);
  void add_part(SolvePart part);
  Vertex most_solve_tiles(const std::vector<Vertex>& fronts) const;
  Vertex solve_tiles(Vertex f) const;
  Vertex steps_of_border(Vertex f) const;
  Vertex parts_of_border(Vertex f) const;
  Vertex tile_of_turn(Vertex f, Vertex turn) const;

  void place_sources();
  std::vector<Offset> place_borders();
  void count_borders(Offset places);
  Offset border_rows_of(Vertex step) const;
  template <class Visit>
  void for_each_child_row(Vertex f, const Visit& visit) const;

  const SymbolicPlan& plan_;
  const DeviceLimits& limits_;
  DevicePlan& made_;
  std::vector<std::size_t> forward_launch_;  // of each depth
};

}  // namespace mfs
