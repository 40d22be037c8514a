#include "dae/mechanics/element_residuals.hpp"

#include <algorithm>
#include <utility>

namespace mfs::dae {

ElementResiduals::ElementResiduals(const Groups& groups, const Colouring& colouring,
                                   const std::vector<NumberedWhole>& whole, std::vector<int> constraint_start,
                                   int coordinates, int threads, const std::vector<int>& place)
    : groups_(groups),
      colouring_(colouring),
      whole_(whole),
      constraint_start_(std::move(constraint_start)),
      threads_(threads) {
  std::size_t nq = 0, nc = 0;
  for (const ElementId id : colouring.order) {
    nq = std::max(nq, static_cast<std::size_t>(groups[id.group]->local_coordinates()));
    nc = std::max(nc, static_cast<std::size_t>(groups[id.group]->local_constraints()));
  }
  workspaces_.reserve(static_cast<std::size_t>(threads));
  for (int thread = 0; thread < threads; ++thread) workspaces_.emplace_back(nq, nc);
  if (!place.empty()) {
    placed_.resize(groups.size());
    std::vector<ElementId> here = colouring.order;
    for (const auto& [number, group] : whole)
      for (int e = 0; e < group->size(); ++e) here.push_back({number, e});
    for (const ElementId id : here) {
      const int count = groups[id.group]->local_coordinates();
      std::vector<int>& placed = placed_[id.group];
      placed.resize(static_cast<std::size_t>(groups[id.group]->size() * count));
      const int* const coordinates = groups[id.group]->coordinates(id.element);
      std::transform(coordinates, coordinates + count, placed.begin() + id.element * count,
                     [&](int i) { return place[i]; });
    }
  }
  shared_forces_ =
      SharedForces(groups, colouring, coordinates, [&](ElementId id) { return coordinates_of(id); });
}

const int* ElementResiduals::coordinates_of(ElementId id) const {
  const ElementGroup& group = *groups_[id.group];
  return placed_.empty() ? group.coordinates(id.element)
                         : placed_[id.group].data() + id.element * group.local_coordinates();
}

void ElementResiduals::add(const StateView& state, const ResidualView& residual) const {
  for_each_coloured(colouring_, std::vector<char>(groups_.size(), 1), threads_, workspaces_,
                    [&](ElementId id, Workspace& work) {
                      compute(id, state, residual, work);
                      const int* coordinates = coordinates_of(id);
                      for (int k = 0; k < groups_[id.group]->local_coordinates(); ++k)
                        residual.force[coordinates[k]] += work.force[k];
                    });
  add_shared(state, residual);
  add_whole(state, residual);
}

void ElementResiduals::add_whole(const StateView& state, const ResidualView& residual) const {
  for (const auto& [number, group] : whole_)
    group->residual_of_all(state, coordinates_of({number, 0}), constraint_start_[number], residual);
}

void ElementResiduals::add_shared(const StateView& state, const ResidualView& residual) const {
  FirstFailure failure;
  const std::size_t first = colouring_.colour_start.back(), count = shared_forces_.elements();
#pragma omp parallel for num_threads(threads_) schedule(static) if (shared_forces_.are_worth_threads())
  for (std::size_t k = 0; k < count; ++k)
    failure.watch(k, [&] {
      const ElementId id = colouring_.order[first + k];
      Workspace& work = workspaces_[static_cast<std::size_t>(omp_get_thread_num())];
      compute(id, state, residual, work);
      std::copy_n(work.force.begin(), groups_[id.group]->local_coordinates(), shared_forces_.share(k));
    });
  failure.rethrow();
  shared_forces_.add_to(residual.force, threads_);
}

/// The share of F to `work`, the rows of constraints, which are the element's own, to where they belong.
void ElementResiduals::compute(ElementId id, const StateView& state, const ResidualView& residual,
                               Workspace& work) const {
  const ElementGroup& group = *groups_[id.group];
  const int nq = group.local_coordinates(), nc = group.local_constraints();
  const int row = constraint_start_[id.group] + id.element * nc;
  const LocalState local_state = work.gather(state, coordinates_of(id), nq, row);
  std::fill_n(work.force.begin(), nq, 0.0);
  std::fill_n(work.position.begin(), nc, 0.0);
  std::fill_n(work.velocity.begin(), nc, 0.0);
  std::fill_n(work.acceleration.begin(), nc, 0.0);
  LocalResidual local{work.force.data(), work.position.data(), work.velocity.data(),
                      work.acceleration.data()};
  group.residual(id.element, local_state, local);
  std::copy_n(local.position, nc, residual.position + row);
  std::copy_n(local.velocity, nc, residual.velocity + row);
  std::copy_n(local.acceleration, nc, residual.acceleration + row);
}

}  // namespace mfs::dae
