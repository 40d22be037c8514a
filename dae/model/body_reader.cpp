// Materials, bodies and points of a model file.
#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>

#include <mfs/error.hpp>

#include "dae/fem/gmsh.hpp"
#include "dae/mechanics/number_text.hpp"
#include "dae/mechanics/rigid_body.hpp"
#include "dae/model/mesh_generators.hpp"
#include "dae/model/model_parts.hpp"

namespace mfs::dae {
namespace {

// Where a body is and how it moves when time begins.
Placement read_placement(JsonObject& object) {
  Placement placement;
  placement.position = object.vector("position", placement.position);
  placement.velocity = object.vector("velocity", placement.velocity);
  placement.angular_velocity = object.vector("angular_velocity", placement.angular_velocity);
  if (!object.has("rotation")) return placement;
  JsonObject rotation = object.object("rotation");
  const Eigen::Vector3d axis = rotation.vector("axis");
  if (axis.isZero(0.0)) rotation.refuse("axis", "must not be zero");
  placement.rotation =
      Eigen::AngleAxisd(rotation.number("angle"), axes_along(axis).col(2)).toRotationMatrix();
  rotation.finish();
  return placement;
}

// Three moments about the axes, or all of xx, yy, zz, xy, yz, zx.
Eigen::Matrix3d read_inertia(JsonObject& object) {
  const std::vector<double> j = object.numbers("inertia");
  if (j.size() != 3 && j.size() != 6)
    object.refuse("inertia", "must have 3 numbers (xx, yy, zz) or 6 (and xy, yz, zx)");
  Eigen::Matrix3d inertia = Eigen::Vector3d(j[0], j[1], j[2]).asDiagonal();
  if (j.size() == 6) {
    inertia(0, 1) = inertia(1, 0) = j[3];
    inertia(1, 2) = inertia(2, 1) = j[4];
    inertia(2, 0) = inertia(0, 2) = j[5];
  }
  return inertia;
}

void read_rigid_body(JsonObject& object, const std::string& name, ModelParts& parts) {
  const RigidBody body{name, object.positive("mass"), read_inertia(object), read_placement(object)};
  object.finish();
  const Frame frame = add_rigid_body(parts.builder, body, parts.gravity);
  parts.model.rigid_bodies.push_back({name,
                                      frame,
                                      {},
                                      body.mass,
                                      body.inertia,
                                      {parts.builder.groups().back(), parts.builder.constraints()}});
}

std::shared_ptr<const Mesh> read_mesh(JsonObject object, const std::string& folder) {
  Mesh mesh;
  if (object.has("gmsh"))
    mesh = read_gmsh((std::filesystem::path(folder) / object.text("gmsh")).string());
  else
    mesh = generate_mesh(object);
  object.finish();
  return std::make_shared<const Mesh>(std::move(mesh));
}

// The nodes' positions and velocities in a rigid motion of the mesh.
std::pair<std::vector<double>, std::vector<double>> placed(const Mesh& mesh, const Placement& placement) {
  std::vector<double> q, v;
  for (const std::array<double, 3>& node : mesh.nodes) {
    const Eigen::Vector3d arm = placement.rotation * Eigen::Vector3d(node[0], node[1], node[2]);
    const Eigen::Vector3d position = placement.position + arm;
    const Eigen::Vector3d velocity = placement.velocity + placement.angular_velocity.cross(arm);
    q.insert(q.end(), position.begin(), position.end());
    v.insert(v.end(), velocity.begin(), velocity.end());
  }
  return {q, v};
}

const Material& read_material_name(JsonObject& object, const ModelParts& parts) {
  const std::string material = object.text("material");
  const auto found = parts.materials.find(material);
  if (found == parts.materials.end()) object.refuse("material", "there is no material '" + material + "'");
  return found->second;
}

void read_flexible_body(JsonObject& object, const std::string& name, ModelParts& parts) {
  const Material& material = read_material_name(object, parts);
  SolidOptions options;
  if (object.has("mass"))
    options.mass =
        object.choice<MassKind>("mass", {{"consistent", MassKind::consistent}, {"lumped", MassKind::lumped}});
  if (object.has("damping")) {
    JsonObject damping = object.object("damping");
    options.damping_alpha = damping.not_negative("alpha", 0.0);
    options.damping_beta = damping.not_negative("beta", 0.0);
    damping.finish();
  }
  options.gravity = {parts.gravity[0], parts.gravity[1], parts.gravity[2]};
  const Placement placement = read_placement(object);
  const std::shared_ptr<const Mesh> mesh = read_mesh(object.object("mesh"), parts.folder);
  object.finish();
  const auto [q, v] = placed(*mesh, placement);
  const CoordinateRange range = parts.builder.add_coordinates(name, q, v, {"x", "y", "z"}, 3);
  auto solid = std::make_shared<const SolidGroup>(name, mesh, material, options, range.first);
  parts.builder.add(solid);
  parts.model.flexible_bodies.push_back({name, solid, range});
}

// Between the two nodes of one element that are farthest apart.
double largest_element(const Mesh& mesh) {
  const int nodes = nodes_per_element(mesh.kind);
  const auto place = [&](std::size_t k) {
    return Eigen::Map<const Eigen::Vector3d>(mesh.nodes[static_cast<std::size_t>(mesh.elements[k])].data());
  };
  double largest = 0;
  for (std::size_t first = 0; first < mesh.elements.size(); first += static_cast<std::size_t>(nodes))
    for (int i = 0; i < nodes; ++i)
      for (int j = 0; j < i; ++j)
        largest = std::max(
            largest,
            (place(first + static_cast<std::size_t>(i)) - place(first + static_cast<std::size_t>(j))).norm());
  return largest;
}

// Its first coordinate. No point of the body is farther from all nodes than an element is wide.
int nearest_node(const FlexibleBody& body, const std::vector<double>& q, const Eigen::Vector3d& point,
                 const JsonObject& object) {
  int nearest = body.range.first;
  const auto distance = [&](int first) {
    return (Eigen::Map<const Eigen::Vector3d>(&q[first]) - point).norm();
  };
  for (int first = body.range.first; first < body.range.first + body.range.count; first += 3)
    if (distance(first) < distance(nearest)) nearest = first;
  const double widest = largest_element(body.solid->mesh());
  if (!(distance(nearest) <= widest))
    object.refuse("point", "is " + number_text(distance(nearest)) + " m from the nearest node of '" +
                               body.name + "', whose elements are " + number_text(widest) +
                               " m wide at most");
  return nearest;
}

}  // namespace

const FlexibleBody* ModelParts::flexible(const std::string& name) const {
  for (const FlexibleBody& body : model.flexible_bodies)
    if (body.name == name) return &body;
  return nullptr;
}

RigidPart* ModelParts::rigid(const std::string& name) {
  for (RigidPart& body : model.rigid_bodies)
    if (body.name == name) return &body;
  return nullptr;
}

void read_material(JsonObject& object, const std::string& name, ModelParts& parts) {
  Material material;
  material.law = object.choice<MaterialLaw>("law", {{"st_venant_kirchhoff", MaterialLaw::st_venant_kirchhoff},
                                                    {"neo_hookean", MaterialLaw::neo_hookean}});
  material.young = object.positive("young");
  material.poisson = object.number("poisson");
  if (!(material.poisson > -1 && material.poisson < 0.5))
    object.refuse("poisson", "must be between -1 and 0.5");
  material.density = object.positive("density");
  object.finish();
  parts.materials[name] = material;
}

void read_body(JsonObject& object, const std::string& name, ModelParts& parts) {
  if (name == "ground") throw InvalidInput(object.place(), "no body may have the name of the ground");
  using Reader = void (*)(JsonObject&, const std::string&, ModelParts&);
  const Reader reader =
      object.choice<Reader>("type", {{"rigid", read_rigid_body}, {"flexible", read_flexible_body}});
  reader(object, name, parts);
}

void read_point(JsonObject& object, const std::string& name, ModelParts& parts) {
  const std::string body = object.text("body");
  const Eigen::Vector3d point = object.vector("point");
  object.finish();
  if (const FlexibleBody* flexible = parts.flexible(body)) {
    const int first = nearest_node(*flexible, parts.builder.initial_q(), point, object);
    const auto index = static_cast<int>(flexible - parts.model.flexible_bodies.data());
    parts.model.points.push_back({name, {}, {}, index, (first - flexible->range.first) / 3});
  } else if (const RigidPart* rigid = parts.rigid(body)) {
    const Attachment place = attach(parts.builder, rigid->frame, point);
    parts.model.points.push_back({name, rigid->frame, place.point});
  } else {
    object.refuse("body", "there is no body '" + body + "'");
  }
}

}  // namespace mfs::dae
