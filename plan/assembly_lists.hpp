// Who assembles what of the larger fronts on a device: parts of a few columns each, the original entries that
// lie there, and the rows of children that a front's rows take.
#pragma once

#include <vector>

#include "plan/device_plan.hpp"
#include "plan/spans.hpp"

namespace mfs {

/// Writes DevicePlan::assemble, child_row and entry_place; one use, depth after depth.
class AssemblyLists {
 public:
  AssemblyLists(const SymbolicPlan& plan, DevicePlan& made) : plan_(plan), made_(made) {}

  /// The parts of the larger fronts of the next depth.
  void add_depth(const std::vector<Vertex>& large, DepthLaunches& depth);
  /// After the last depth and all small fronts.
  void finish();

 private:
  // Its parts have `columns` columns each.
  struct AssemblyBlock {
    Vertex front;
    Span down, right;
    Vertex columns;
    bool has_entries;  // of the matrix
    Offset place;      // as in their parts
    Offset first_part;
  };

  void add_block(Vertex f, Span down, Span right, bool has_entries, Offset place);
  void add_border_columns(Vertex f, bool of_pivots);
  void list_parts();
  void list_child_rows();
  void place_entries();
  Offset first_entry_from(Vertex f, Offset entry, Vertex end) const;
  Vertex column_of_entry(Vertex f, Offset entry) const;
  Offset column_begin(Vertex f, Vertex column) const;

  const SymbolicPlan& plan_;
  DevicePlan& made_;
  std::vector<AssemblyBlock> blocks_;
  Offset parts_ = 0;  // of them all
};

}  // namespace mfs
