// The residuals of those elements that the host evaluates, summed by all threads in an order that does not
// depend on how many these are.
#pragma once

#include <memory>
#include <vector>

#include "dae/mechanics/colouring.hpp"
#include "dae/mechanics/element_group.hpp"
#include "dae/mechanics/element_work.hpp"
#include "dae/mechanics/shared_forces.hpp"
#include "dae/mechanics/whole_group.hpp"

namespace mfs::dae {

class ElementResiduals {
 public:
  using Groups = std::vector<std::shared_ptr<const ElementGroup>>;

  /// Of the elements of `colouring` and of the groups `whole`; all groups have their constraints from
  /// `constraint_start` on. `place`: where each coordinate is in the vectors of states and forces, of which
  /// there are `coordinates`; empty: where the system has it.
  ElementResiduals(const Groups& groups, const Colouring& colouring, const std::vector<NumberedWhole>& whole,
                   std::vector<int> constraint_start, int coordinates, int threads,
                   const std::vector<int>& place = {});

  /// Adds to forces and sets constraints.
  void add(const StateView& state, const ResidualView& residual) const;

 private:
  const int* coordinates_of(ElementId id) const;
  void compute(ElementId id, const StateView& state, const ResidualView& residual, Workspace& work) const;
  void add_shared(const StateView& state, const ResidualView& residual) const;
  void add_whole(const StateView& state, const ResidualView& residual) const;

  const Groups& groups_;
  const Colouring& colouring_;
  std::vector<NumberedWhole> whole_;
  std::vector<int> constraint_start_;
  int threads_;
  std::vector<std::vector<int>> placed_;  ///< of each group: the places of its elements' coordinates
  mutable SharedForces shared_forces_;
  mutable std::vector<Workspace> workspaces_;  ///< of each thread
};

}  // namespace mfs::dae
