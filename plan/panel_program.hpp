// A plan as panels, for fronts so small that looking after them costs more than their numbers do. A *panel*
// is up to kMostTogether neighbouring pivot columns of a front. Panels are made from left to right, each with
// all of its rows before the next, so that no contribution block is made, kept or assembled.
//
//   rows of a panel, by number     source D   pivots of a front that the panel's columns are in the border of
//                                  source E   (all of its pivots; by their planned rows until they are used)
//                                  ...
//     pivot_row                    pivots of the panel's own front
//                                  border of that front
//
// A source is a front whose columns of L, times what the panel has in its pivots' rows, are subtracted from
// the panel: from the rows of the source's border, which are *runs* of neighbouring rows of the panel.
//
// Rows are exchanged inside the pivot blocks of fronts only. So all of this is known before any number is.
#pragma once

#include <memory>
#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

constexpr Vertex kMostTogether = 4;

struct PanelProgram {
  struct Source {
    Vertex front;
    Vertex row;                 // of the panel, that of the front's first pivot
    Vertex run_begin, run_end;  // of the front's border
  };
  struct Run {
    Vertex row, rows;
  };
  struct Panel {
    Vertex first, columns;  // positions
    Vertex front, before;   // and its pivots before the panel's
    Vertex rows, pivot_row;
    Vertex source_begin, source_end;
    Offset numbers;  // where those of the first column begin; columns follow each other without gaps
  };
  std::vector<Panel> panels;
  std::vector<Vertex> panel_begin;  // num_fronts + 1
  std::vector<Source> sources;
  std::vector<Run> runs;
  std::vector<Vertex> place;                          // by slot of the pattern: number
  std::vector<Vertex> row_position, column_position;  // of A -> position
  Offset couplings = 0;                               // number of the first one of a triangle
  Offset numbers = 0;
  Vertex most_pivots = 0;  // of a front
};

PanelProgram plan_panels(const SymbolicPlan& plan, const Pattern& pattern);
/// The same, or null where fronts are expected to be faster, by so many threads: panels are one's work.
std::shared_ptr<const PanelProgram> make_panel_program(const SymbolicPlan& plan, const Pattern& pattern,
                                                       int threads);

/// Whether the work of a plan is so little that waking other threads costs more than they save.
bool is_for_one_thread(const SymbolicPlan& plan);

}  // namespace mfs
