#include "dae/fem/solid_group.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <mfs/error.hpp>
#include <utility>

#include "dae/fem/device_force.hpp"
#include "dae/fem/element_mass.hpp"

namespace mfs::dae {

namespace {

constexpr int kMostNodes = 20;

Eigen::Matrix3d matrix(const std::array<Point3, 3>& rows) {
  Eigen::Matrix3d out;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) out(a, b) = rows[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
  return out;
}

void require(bool sound, const std::string& body, const std::string& field, const char* rule) {
  if (!sound) throw InvalidInput("body " + body + ", " + field, rule);
}

SolidInertia inertia_of(const SolidOptions& options) {
  const auto& g = options.gravity;
  return {options.mass == MassKind::lumped, options.damping_alpha, {g[0], g[1], g[2]}};
}

/// An element may be folded at a corner and nowhere else that is looked at. Corners that nodes share, as
/// those of a collapsed hexahedron, leave nothing there but rounding.
bool is_folded(ElementKind kind, const double* nodes) {
  constexpr double kRounding = 1e-9;
  double largest = 0;
  for (const QuadratureRule* rule : {&stiffness_rule(kind), &mass_rule(kind)}) {
    for (const Point3& point : rule->points) {
      const double size = determinant(jacobian(kind, point, nodes));
      if (!(size > 0)) return true;
      largest = std::max(largest, size);
    }
  }
  const std::vector<Point3>& corners = reference_nodes(kind);
  const auto end = corners.begin() + (kind == ElementKind::tet10 ? 4 : 8);
  return std::any_of(corners.begin(), end, [&](const Point3& corner) {
    return !(determinant(jacobian(kind, corner, nodes)) >= -kRounding * largest);
  });
}

}  // namespace

void check_material(const Material& material, const std::string& body) {
  require(std::isfinite(material.young) && material.young > 0, body, "young", "must be positive");
  require(material.poisson > -1 && material.poisson < 0.5, body, "poisson", "must lie between -1 and 0.5");
  require(std::isfinite(material.density) && material.density > 0, body, "density", "must be positive");
}

SolidGroup::SolidGroup(std::string body, std::shared_ptr<const Mesh> mesh, const Material& material,
                       const SolidOptions& options, int first_coordinate)
    : body_(std::move(body)),
      mesh_(std::move(mesh)),
      nodes_(nodes_per_element(mesh_->kind)),
      constants_{material.law, material.lame_lambda(), material.shear_modulus(), options.damping_beta},
      options_(options),
      first_coordinate_(first_coordinate) {
  check_material(material, body_);
  require(std::isfinite(options.damping_alpha) && options.damping_alpha >= 0, body_, "damping_alpha",
          "must not be negative");
  require(std::isfinite(options.damping_beta) && options.damping_beta >= 0, body_, "damping_beta",
          "must not be negative");
  check_elements();
  coordinates_.reserve(3 * mesh_->elements.size());
  for (const int node : mesh_->elements)
    for (int k = 0; k < 3; ++k) coordinates_.push_back(first_coordinate + 3 * node + k);
  fill_mass(material.density);
}

void SolidGroup::check_elements() const {
  require(!mesh_->elements.empty() && mesh_->elements.size() % static_cast<std::size_t>(nodes_) == 0, body_,
          "elements", "must be whole elements, one at least");
  for (const int node : mesh_->elements)
    require(node >= 0 && static_cast<std::size_t>(node) < mesh_->nodes.size(), body_, "elements",
            "must name nodes of the mesh");
  double nodes[3 * kMostNodes];
  for (int e = 0; e < size(); ++e) {
    gather_nodes(e, nodes);
    if (is_folded(mesh_->kind, nodes))
      throw InvalidInput(name(e) + ", shape",
                         "must have a positive Jacobian (is it turned inside out or folded, or are its nodes "
                         "in another order?)");
  }
}

int SolidGroup::mass_entries() const {
  return inertia_of(options_).entries(nodes_);
}

void SolidGroup::fill_mass(double density) {
  mass_.resize(place(size(), mass_entries()));
  const bool lumped = options_.mass == MassKind::lumped;
#pragma omp parallel for schedule(static)
  for (int e = 0; e < size(); ++e) {
    double nodes[3 * kMostNodes];
    gather_nodes(e, nodes);
    const std::vector<double> mass =
        lumped ? lumped_mass(mesh_->kind, nodes) : consistent_mass(mesh_->kind, nodes);
    double* out = &mass_[place(e, mass_entries())];
    for (int i = 0; i < nodes_; ++i)
      for (int j = lumped ? i : 0; j <= i; ++j)
        *out++ = density * mass[static_cast<std::size_t>(lumped ? i : i * nodes_ + j)];
  }
}

void SolidGroup::gather_nodes(int e, double* nodes) const {
  const int* element = &mesh_->elements[place(e, nodes_)];
  for (int i = 0; i < nodes_; ++i)
    for (std::size_t k = 0; k < 3; ++k) *nodes++ = mesh_->nodes[static_cast<std::size_t>(element[i])][k];
}

LocalStructure SolidGroup::structure() const {
  using Kind = LocalStructure::Kind;
  LocalStructure s;
  s.force_q = Kind::dense;
  s.force_a = options_.mass == MassKind::lumped ? Kind::diagonal : Kind::dense;
  s.force_v = options_.damping_beta > 0 ? Kind::dense : options_.damping_alpha > 0 ? s.force_a : Kind::zero;
  s.constant_force_a = true;
  s.constant_force_v = options_.damping_beta == 0;
  return s;
}

void SolidGroup::residual(int e, const LocalState& state, LocalResidual& residual) const {
  double nodes[3 * kMostNodes], acceleration[3 * kMostNodes];
  gather_nodes(e, nodes);
  add_internal_force(mesh_->kind, constants_, nodes, state.q, state.v, residual.force);
  const SolidInertia inertia = inertia_of(options_);
  for (int n = 0; n < 3 * nodes_; ++n) acceleration[n] = inertia.acceleration(state.a[n], state.v[n], n % 3);
  for (int i = 0; i < nodes_; ++i)
    inertia.add_row(
        i, nodes_, &mass_[place(e, mass_entries())], [&](int j, int k) { return acceleration[3 * j + k]; },
        residual.force + 3 * i);
}

std::unique_ptr<DeviceForce> SolidGroup::device_force(int coordinates, int threads) const {
  return make_device_force({*mesh_, constants_, inertia_of(options_), mass_, first_coordinate_}, coordinates,
                           threads);
}

// matrix (3 nodes x 3 nodes) += factor * mass
void SolidGroup::add_mass(int e, double factor, double* matrix) const {
  const int n = 3 * nodes_;
  for_each_mass(e, [&](int i, int j, double mass) {
    for (int k = 0; k < 3; ++k) {
      matrix[(3 * i + k) * n + 3 * j + k] += factor * mass;
      if (j < i) matrix[(3 * j + k) * n + 3 * i + k] += factor * mass;
    }
  });
}

void SolidGroup::tangent(int e, const LocalState& state, LocalTangent& tangent) const {
  const bool by_q = tangent.asked.has(Block::force_q), by_v = tangent.asked.has(Block::force_v);
  if (tangent.asked.has(Block::force_a)) add_mass(e, 1.0, tangent.force_a);
  if (by_v && options_.damping_alpha > 0) add_mass(e, options_.damping_alpha, tangent.force_v);
  const bool viscous = by_v && constants_.beta > 0;
  if (!by_q && !viscous) return;
  double nodes[3 * kMostNodes];
  gather_nodes(e, nodes);
  add_internal_tangent(mesh_->kind, constants_, nodes, state.q, state.v, by_q ? tangent.force_q : nullptr,
                       viscous ? tangent.force_v : nullptr);
}

Energy SolidGroup::energy(int e, const LocalState& state) const {
  double nodes[3 * kMostNodes];
  gather_nodes(e, nodes);
  Energy energy;
  energy.elastic = stored_energy(mesh_->kind, constants_, nodes, state.q);
  for_each_mass(e, [&](int i, int j, double mass) {
    for (int k = 0; k < 3; ++k) {
      const double twice = j < i ? 2 : 1, g = options_.gravity[static_cast<std::size_t>(k)];
      energy.kinetic += 0.5 * twice * mass * state.v[3 * i + k] * state.v[3 * j + k];
      energy.potential -= 0.5 * twice * mass * g * (state.q[3 * i + k] + state.q[3 * j + k]);
    }
  });
  return energy;
}

Power SolidGroup::power(int e, const LocalState& state) const {
  Power power;
  if (options_.damping_alpha > 0)
    for_each_mass(e, [&](int i, int j, double mass) {
      for (int k = 0; k < 3; ++k)
        power.dissipated +=
            (j < i ? 2 : 1) * options_.damping_alpha * mass * state.v[3 * i + k] * state.v[3 * j + k];
    });
  if (!(constants_.beta > 0)) return power;
  const double rest[3 * kMostNodes] = {};
  double nodes[3 * kMostNodes], moving[3 * kMostNodes] = {}, resting[3 * kMostNodes] = {};
  gather_nodes(e, nodes);
  add_internal_force(mesh_->kind, constants_, nodes, state.q, state.v, moving);
  add_internal_force(mesh_->kind, constants_, nodes, state.q, rest, resting);
  for (int n = 0; n < 3 * nodes_; ++n) power.dissipated += (moving[n] - resting[n]) * state.v[n];
  return power;
}

double SolidGroup::least_stretch(int e, const double* q) const {
  std::vector<double> nodes(static_cast<std::size_t>(3 * nodes_));
  gather_nodes(e, nodes.data());
  double least = 1.0;
  for (const Point3& point : stiffness_rule(mesh_->kind).points) {
    const Eigen::Matrix3d f = matrix(jacobian(mesh_->kind, point, q)) *
                              matrix(jacobian(mesh_->kind, point, nodes.data())).inverse();
    least = std::min(least, f.jacobiSvd().singularValues()[2]);
  }
  return least;
}

/// Of a bar with S = E (l^2 - 1) / 2 the force l S is largest where 3 l^2 = 1.
std::string SolidGroup::pressed_note() const {
  if (constants_.law != MaterialLaw::st_venant_kirchhoff) return {};
  return "; st_venant_kirchhoff is for small strains, and gives way below 0.577";
}

std::string SolidGroup::name(int e) const {
  return "body " + body_ + ", element " + std::to_string(e);
}

double SolidGroup::mass() const {
  double sum = 0;
  for (int e = 0; e < size(); ++e)
    for_each_mass(e, [&](int i, int j, double mass) { sum += (j < i ? 2 : 1) * mass; });
  return sum;
}

}  // namespace mfs::dae
