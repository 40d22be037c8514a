// The numbers of a panel program (plan/panel_program.hpp): LU of one tiny system by one thread, without a
// call of BLAS. Pivots are searched as fronts search them, in all rows of the pivot block, and pass by the
// same rule (kernels/dense/pivot_rule.hpp). What is to become of a pivot that does not pass is left to the
// fronts.
#pragma once

#include "plan/panel_program.hpp"

namespace mfs::panels {

/// When a pivot does not pass. Sizes are absolute.
struct PivotBounds {
  double bound, tiny;
  double border_part;     // of its border that a pivot below `bound` must have
  double preference = 1;  // times its size the entry on the diagonal counts when a pivot is searched
};

/// Right-hand sides that substitute takes at the same time, side by side.
constexpr Vertex kSideBySide = 8;

/// One system: what is known of it, and memory for its numbers.
template <class Scalar>
struct System {
  const SymbolicPlan& plan;
  const Pattern& pattern;
  const PanelProgram& program;
  Scalar* numbers;    // program.numbers
  Vertex* local_row;  // n, by position: the row of its front's pivot block that came there
  Vertex* moved;      // num_fronts: whether one of them is not where it was
  Scalar* work;       // program.most_pivots * kSideBySide
};

/// numbers = the scaled values of A, by slot. Returns the largest of them, of a complex one the sum of its
/// parts' sizes.
template <class Value, class Scalar>
double take_values(const System<Scalar>& system, const Value* values, const double* row_scale,
                   const double* column_scale);

/// Factors what take_values left. The inverses of the pivots take their place. False where one does not pass.
template <class Scalar>
bool factor(const System<Scalar>& system, const PivotBounds& bounds);

/// y := A^-1 y between positions, or A^-T y. y [n], or with `side_by_side` [n x kSideBySide], the numbers of
/// a position together.
template <class Scalar>
void substitute(const System<Scalar>& system, bool transposed, bool side_by_side, Scalar* y);

}  // namespace mfs::panels
