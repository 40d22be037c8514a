// What a solve must reach, and what became of it.
#pragma once

#include "ordering/types.hpp"

namespace mfs {

struct SolveControls {
  double tolerance = 1e-12;     // componentwise backward error
  int max_steps = 10;           // of refinement; 0: none, and no FGMRES either
  double row_floor = 0;         // SolveOptions::row_floor
  bool solve_singular = false;  // SolveOptions::solve_singular
};

struct SolveOutcome {
  int refinement_steps = 0;
  int krylov_steps = 0;
  double backward_error = 0;     // the worst of all columns
  double time_ladder = 0;        // s, for correction, refinement and FGMRES
  int corrected_pivots = 0;      // perturbed pivots that an exact low-rank correction took back
  Vertex dependent_rows = 0;     // > 0: A is singular to working precision, and this row and this column
  Vertex row = -1, column = -1;  // of A depend on the others
  double singularity = 0;        // the proof of it: |A z| / | |A||z| | in scaled rows for some z
  bool doubtful = false;         // whether A is singular could not be found out with these factors
};

}  // namespace mfs
