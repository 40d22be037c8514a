// Groups whose elements have most of their work in common, as the links of a rigid interface have the frame's
// rotation: they are evaluated as a whole, by one thread, which takes a fraction of what the elements would
// take one by one with all threads.
#pragma once

#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

/// Where residuals of a system go: as Residual.
struct ResidualView {
  double *force, *position, *velocity, *acceleration;
};

/// Shares of all elements to be filled. Null: not asked for.
struct TangentOfAll {
  /// Of coordinates that all elements have, nq x nq as those of element 0; they come zeroed.
  double *force_q, *force_v, *force_a;
  /// Rows of constraints, element by element, nq values of each: that of coordinate k of element e at place
  /// rank[nq e + k].
  double *position_q, *velocity_q, *acceleration_q, *acceleration_v;
  const int* rank;
};

class WholeGroup : public ElementGroup {
 public:
  /// ElementGroup::residual of all elements, in vectors of a system: adds to forces and sets constraints,
  /// those of element 0 from `row` on, from where its multipliers are in the state. `coordinates`: where
  /// those of the elements are in the vectors, nq of each, one element after the other.
  virtual void residual_of_all(const StateView& state, const int* coordinates, int row,
                               const ResidualView& residual) const = 0;
  /// ElementGroup::tangent of all elements; `row` as above.
  virtual void tangent_of_all(const StateView& state, int row, const TangentOfAll& tangent) const = 0;

  void tangent(int /*e*/, const LocalState& /*state*/, LocalTangent& /*tangent*/) const final {}
};

/// One among the groups of a system.
struct NumberedWhole {
  int number;
  const WholeGroup* group;
};

}  // namespace mfs::dae
