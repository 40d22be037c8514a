// A scalar program with the pattern and the scales of the matrices that it is for, and the same as arrays in
// the memory of whoever executes it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "plan/scalar_program.hpp"

namespace mfs::lanes {

/// `slots` and `values` count the entries of the pattern and of the caller's matrix.
struct ProgramView {
  Vertex n;
  Offset slots, values, entries;
  const Vertex *row_of, *column_of, *column_begin, *pivot, *row, *place, *fill, *target;
  const std::uint8_t* width;
  Vertex fills;
  const Offset* slot_of_value;                          // null: value k is slot k
  const Offset* matrix_begin;                           // n + 1, of rows of A
  const Vertex* matrix_column;                          // by slot
  const double *slot_scale, *row_scale, *column_scale;  // by slot, row of A, column of A
};

struct LaneProgram {
  LaneProgram(ScalarProgram program, std::shared_ptr<const Pattern> pattern, const MatchedScaling& matched);

  ScalarProgram program;
  std::shared_ptr<const Pattern> pattern;
  std::vector<double> row_scale, column_scale, slot_scale;  // slot_scale: of its row times of its column

  /// Of arrays of this object.
  ProgramView view() const;
};

}  // namespace mfs::lanes
