// The system that MultibodyBuilder makes: which blocks each group fills, where an element's shares go, and
// the loops over elements, by colours. What groups have a device for is left to it: their forces are added
// when the host has done with the others', their derivatives are remote tangents.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dae/mechanics/colouring.hpp"
#include "dae/mechanics/element_residuals.hpp"
#include "dae/mechanics/element_work.hpp"
#include "dae/mechanics/force_blocks.hpp"
#include "dae/mechanics/multibody.hpp"
#include "dae/mechanics/turning_bodies.hpp"

namespace mfs::dae {

/// Of points x y z: the longest edge of their box; 0 where there are none.
double extent(const std::vector<double>& points);

class Multibody final : public ConstrainedSystem, public TurningBodies {
 public:
  Multibody(Groups groups, std::vector<BodyCoordinates> bodies, double length_unit, double largest_body,
            int coordinates, int threads, Backend backend);

  int coordinates() const override { return n_; }
  int constraints() const override { return m_; }
  const TangentPattern& tangent_pattern() const override { return pattern_; }
  void evaluate(const StateView& state, Residual& residual) const override;
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override;
  void evaluate_gradient(const StateView& state, const std::vector<int>& rows,
                         Tangent& tangent) const override;
  std::unique_ptr<RemoteResidual> remote_residual(const Executor& executor) const override;
  /// Puts what devices evaluate between what `executor` marked last and what it begins from now on; see
  /// DeviceForce::write.
  void write_device_forces(const Executor& executor, const StateView& state, double* force) const {
    for (const auto& device : device_forces_) device->write(executor, state, force);
  }
  /// The coordinates of all elements that the host evaluates, ascending.
  std::vector<int> host_coordinates() const;
  /// What the host evaluates, for vectors of these coordinates only.
  ElementResiduals host_residuals(const std::vector<int>& coordinates) const;
  std::string coordinate_name(int coordinate) const override;
  std::string constraint_name(int row) const override;
  std::string constraint_owner(int row) const override;
  bool is_normalization(int row) const override { return place_of(row).group.normalizes(); }
  bool is_nonholonomic(int row) const override { return place_of(row).group.is_nonholonomic(); }
  double coordinate_scale(int coordinate) const override;
  std::vector<double> ranges(const double* q) const override;
  std::string most_pressed(const double* q) const override;
  bool is_measure(int coordinate) const override { return body_of(coordinate).is_measure; }
  std::vector<PointRange> turning_bodies() const override;
  bool is_length(int coordinate) const override;
  double largest_body() const override { return largest_body_; }
  std::vector<double> marks(const TimeSpan& span) const override;
  std::unique_ptr<ChangeWatch> change_watch() const override;
  std::vector<RemoteTangent*> remote_tangents() const override {
    std::vector<RemoteTangent*> remotes;
    for (const auto& force : device_forces_) remotes.push_back(force.get());
    return remotes;
  }

 private:
  std::set<int> make_device_forces();
  void number_constraints();
  void find_constraint_blocks();
  const BodyCoordinates& body_of(int coordinate) const;
  struct ConstraintPlace {
    const ElementGroup& group;
    int element, row;
  };
  std::size_t group_of(int constraint) const;
  ConstraintPlace place_of(int constraint) const;
  int first_constraint(int g, int e) const {
    return constraint_start_[g] + e * groups_[g]->local_constraints();
  }

  void find_constant_shares();
  const std::vector<double>& constant_share(Block block, const StateView& state) const;
  void add_elements(const StateView& state, const std::vector<BlockSet>& blocks, Tangent& tangent) const;
  void add_whole_groups(const StateView& state, const std::vector<BlockSet>& blocks, Tangent& tangent) const;
  void make_workspaces();
  template <class Compute, class Add>
  void for_each_uncoloured(const std::vector<char>& group_takes_part, const Compute& compute,
                           const Add& add) const;
  void compute_tangent(const NumberedWhole& whole, const StateView& state, BlockSet asked, Tangent& tangent,
                       Workspace& work) const;
  void compute_tangent(ElementId id, const StateView& state, Tangent& tangent, BlockSet blocks,
                       Workspace& work) const;
  void add_force_blocks(ElementId id, BlockSet blocks, Tangent& tangent, Workspace& work) const;
  void set_constraint_block(Block block, ElementId id, const double* local, Tangent& tangent) const;

  Groups groups_;
  std::vector<LocalStructure> structure_;  // of each group
  std::vector<BlockSet> blocks_;           // of each group: those that the host evaluates for each state
  std::vector<BlockSet> constant_blocks_;  // those that it evaluates once, for constant_shares_
  // Of blocks that some groups change with the state and others do not: what the others add; made when it is
  // first asked for.
  mutable std::array<std::vector<double>, kBlocks> constant_shares_;
  std::vector<BodyCoordinates> bodies_;
  double length_unit_, largest_body_;
  int n_, m_ = 0, threads_;
  std::vector<int> constraint_start_;  // of each group, and m
  TangentPattern pattern_;
  std::array<ForceBlock, 3> force_blocks_;  // as kForceBlocks
  std::vector<std::vector<int>>
      column_rank_;                   // of each group with constraints: where each coordinate is in its rows
  std::vector<NumberedWhole> whole_;  // groups that are evaluated so, and not on a device
  Colouring colouring_;               // of the others that no device has
  std::optional<ElementResiduals> residuals_;  // of both
  std::vector<std::unique_ptr<DeviceForce>> device_forces_;
  mutable std::vector<Workspace> workspaces_;        // of each thread
  mutable std::vector<Workspace> waiting_;           // of elements without a colour, until their turn
  mutable std::vector<Workspace> whole_workspaces_;  // of each group in `whole_`
  bool uncoloured_are_worth_threads_ = false;
};

}  // namespace mfs::dae
