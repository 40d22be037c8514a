#include "dae/model/model.hpp"

#include <cmath>

#include <mfs/error.hpp>

#include "dae/model/model_parts.hpp"

namespace mfs::dae {
namespace {

// A complaint of another part says which body or joint; here it learns where in the file that is.
void read_all(JsonObject& file, const char* key, ModelParts& parts,
              void (*read)(JsonObject&, const std::string&, ModelParts&)) {
  for (auto& [name, object] : file.members(key)) {
    try {
      read(object, name, parts);
    } catch (const InvalidInput& e) {
      if (e.argument().compare(0, object.place().size(), object.place()) == 0) throw;
      throw InvalidInput(object.place(), e.what());
    }
  }
}

// The rows that hold the points of the joint together: its first ones, three, or two where it slides.
MeasuredJoint rows_of(const Joint& joint, const ConstrainedSystem& system) {
  const bool slides = joint.kind == JointKind::translational || joint.kind == JointKind::cylindrical;
  const std::string prefix = "joint " + joint.name + ", ";
  int row = 0;
  while (system.constraint_name(row).compare(0, prefix.size(), prefix) != 0) ++row;
  return {joint.name, row, slides ? 2 : 3};
}

// A flexible body is placed without strain; moving the nodes that a motion holds would tear it.
void check_motions(const MultibodyModel& model) {
  if (model.flexible_bodies.empty()) return;
  constexpr double kOff = 1e-6;  // m, rad
  const std::vector<double> zero(model.q0.size() + static_cast<std::size_t>(model.system->constraints()));
  Residual residual = make_residual(*model.system);
  model.system->evaluate({0.0, model.q0.data(), model.v0.data(), zero.data(), zero.data()}, residual);
  for (int row = 0; row < model.system->constraints(); ++row)
    if (!(std::abs(residual.position[row]) <= kOff))
      throw InvalidInput(model.system->constraint_name(row),
                         "where time begins it is " + std::to_string(residual.position[row]) +
                             " off; beside flexible bodies a motion has to begin where bodies are placed");
}

}  // namespace

MultibodyModel make_model(const Json& json, const std::string& folder, int threads, Backend backend) {
  ModelParts parts;
  JsonObject file(json, "", &parts.parameters);
  MultibodyModel& model = parts.model;
  parts.folder = folder;
  model.name = file.text("name");
  if (file.has("description")) file.text("description");
  if (file.has("parameters")) {
    JsonObject parameters = file.object("parameters");
    read_parameters(parameters, parts.parameters);
  }
  model.end = file.positive("end");
  model.outputs = file.integer("outputs", 1);
  if (file.has("start"))
    model.starts_at_rest = file.choice<bool>("start", {{"as_given", false}, {"equilibrium", true}});
  parts.gravity = file.vector("gravity", parts.gravity);
  read_all(file, "materials", parts, read_material);
  read_all(file, "bodies", parts, read_body);
  read_all(file, "joints", parts, read_joint);
  read_all(file, "points", parts, read_point);
  read_all(file, "motions", parts, read_motion);
  read_all(file, "forces", parts, read_force);
  const std::vector<std::string> reactions = file.texts("reactions");
  for (const std::string& joint : reactions)
    if (parts.joints.count(joint) == 0) file.refuse("reactions", "there is no joint '" + joint + "'");
  if (file.has("integrator")) {
    JsonObject integrator = file.object("integrator");
    model.integrator = read_integrator(integrator);
  }
  file.finish();
  model.system = parts.builder.build(threads, backend);
  model.integrator.threads = threads;
  model.integrator.backend = backend;
  for (const std::string& joint : reactions)
    model.joints.push_back(rows_of(parts.joints.at(joint), *model.system));
  model.q0 = parts.builder.initial_q();
  model.v0 = parts.builder.initial_v();
  check_motions(model);
  return std::move(parts.model);
}

void refine_meshes(Json& json, int refine) {
  bool found = false;
  if (json.is_object() && json.contains("bodies") && json["bodies"].is_object())
    for (Json& body : json["bodies"])
      if (body.is_object() && body.contains("mesh") && body["mesh"].is_object() &&
          body["mesh"].contains("generator")) {
        body["mesh"]["refine"] = refine;
        found = true;
      }
  if (!found) throw InvalidInput("refine", "the model has no mesh that is made by a generator");
}

std::vector<double> output_times(const MultibodyModel& model) {
  std::vector<double> times;
  for (int i = 0; i <= model.outputs; ++i) times.push_back(model.end * i / model.outputs);
  return times;
}

}  // namespace mfs::dae
