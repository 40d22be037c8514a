// A flexible body: the elements of one mesh, of one material, as a group of a multibody system. The
// coordinates are the positions of the nodes in the inertial frame (q[3 i + k] of node i), so the mesh is the
// undeformed shape in a frame of the body's own, and wherever q is a rigid motion of the mesh there is no
// stress.
//
//   F = M (a + alpha v - g) + f(q, v),   M consistent or lumped, f of solid_kernels.hpp.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dae/fem/material.hpp"
#include "dae/fem/mesh.hpp"
#include "dae/fem/solid_kernels.hpp"
#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

enum class MassKind { consistent, lumped };

struct SolidOptions {
  MassKind mass = MassKind::consistent;
  /// Mass-proportional damping, 1/s. It resists rigid motion too, as a drag would.
  double damping_alpha = 0.0;
  /// Viscosity, s: stiffness-proportional damping that no rigid motion feels.
  double damping_beta = 0.0;
  std::array<double, 3> gravity = {0, 0, 0};  ///< m/s^2, inertial frame
};

class SolidGroup : public ElementGroup {
 public:
  /// `first_coordinate`: that of node 0 in the system. Throws InvalidInput that names `body` and, where an
  /// element is at fault (a node number out of range, a Jacobian that is not positive), the element.
  SolidGroup(std::string body, std::shared_ptr<const Mesh> mesh, const Material& material,
             const SolidOptions& options, int first_coordinate);

  int size() const override { return mesh_->element_count(); }
  int local_coordinates() const override { return 3 * nodes_; }
  const int* coordinates(int e) const override { return &coordinates_[place(e, 3 * nodes_)]; }
  LocalStructure structure() const override;
  void residual(int e, const LocalState& state, LocalResidual& residual) const override;
  void tangent(int e, const LocalState& state, LocalTangent& tangent) const override;
  Energy energy(int e, const LocalState& state) const override;
  Power power(int e, const LocalState& state) const override;
  std::unique_ptr<DeviceForce> device_force(int coordinates, int threads) const override;
  double least_stretch(int e, const double* q) const override;
  std::string pressed_note() const override;
  std::string name(int e) const override;

  const std::string& body() const { return body_; }
  const Mesh& mesh() const { return *mesh_; }
  const SolidConstants& constants() const { return constants_; }
  bool is_damped() const { return options_.damping_alpha > 0 || options_.damping_beta > 0; }
  /// kg
  double mass() const;
  /// visit(i, j, m) for the entries of the mass matrix of element e on its diagonal and below, j <= i: m of
  /// its nodes i and j, kg, for each direction.
  template <class Visit>
  void for_each_mass(int e, const Visit& visit) const {
    const double* mass = &mass_[place(e, mass_entries())];
    for (int i = 0; i < nodes_; ++i)
      for (int j = options_.mass == MassKind::lumped ? i : 0; j <= i; ++j) visit(i, j, *mass++);
  }
  /// The nodes' reference positions of element e, nodes x 3, into `nodes`.
  void gather_nodes(int e, double* nodes) const;

 private:
  static std::size_t place(int e, int entries) {
    return static_cast<std::size_t>(e) * static_cast<std::size_t>(entries);
  }
  int mass_entries() const;  // of one element: nodes if lumped, else its lower triangle
  void check_elements() const;
  void fill_mass(double density);
  void add_mass(int e, double factor, double* matrix) const;

  std::string body_;
  std::shared_ptr<const Mesh> mesh_;
  int nodes_;  // of an element
  SolidConstants constants_;
  SolidOptions options_;
  int first_coordinate_;
  std::vector<int> coordinates_;
  std::vector<double> mass_;
};

}  // namespace mfs::dae
