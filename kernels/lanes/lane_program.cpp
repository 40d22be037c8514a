#include "kernels/lanes/lane_program.hpp"

#include <utility>

namespace mfs::lanes {

LaneProgram::LaneProgram(ScalarProgram made, std::shared_ptr<const Pattern> of, const MatchedScaling& matched)
    : program(std::move(made)),
      pattern(std::move(of)),
      row_scale(matched.row_scale),
      column_scale(matched.column_scale),
      slot_scale(static_cast<std::size_t>(pattern->nnz())) {
  for (Vertex i = 0; i < pattern->n; ++i) {
    for (Offset slot = pattern->offsets[i]; slot < pattern->offsets[i + 1]; ++slot)
      slot_scale[slot] = row_scale[i] * column_scale[pattern->columns[slot]];
  }
}

ProgramView LaneProgram::view() const {
  const auto vertices = [](const std::vector<Vertex>& array) { return array.data(); };
  return {program.n,
          pattern->nnz(),
          pattern->num_entries,
          program.entries(),
          vertices(program.row_of),
          vertices(program.column_of),
          vertices(program.column_begin),
          vertices(program.pivot),
          vertices(program.row),
          vertices(program.place),
          vertices(program.fill),
          vertices(program.target),
          program.width.data(),
          static_cast<Vertex>(program.fill.size()),
          pattern->slot_of_entry.empty() ? nullptr : pattern->slot_of_entry.data(),
          pattern->offsets.data(),
          pattern->columns.data(),
          slot_scale.data(),
          row_scale.data(),
          column_scale.data()};
}

}  // namespace mfs::lanes
