#include "dae/model/model.hpp"

#include <cmath>
#include <set>

#include <mfs/error.hpp>

#include "dae/mechanics/number_text.hpp"
#include "dae/model/model_parts.hpp"
#include "dae/model/quantities.hpp"

namespace mfs::dae {
namespace {

bool begins_with(const std::string& text, const std::string& begin) {
  return text.compare(0, begin.size(), begin) == 0;
}

// A complaint of another part says which body or joint; here it learns where in the file that is.
void read_all(JsonObject& file, const char* key, ModelParts& parts,
              void (*read)(JsonObject&, const std::string&, ModelParts&)) {
  for (auto& [name, object] : file.members(key)) {
    try {
      read(object, name, parts);
    } catch (const InvalidInput& e) {
      if (begins_with(e.argument(), object.place())) throw;
      throw InvalidInput(object.place(), e.what());
    }
  }
}

// What the reader of a joint, a motion or a force has added to the system, but for interfaces of its sides
// and measures, which others use, too.
class Added {
 public:
  explicit Added(ModelParts& parts)
      : parts_(parts), group_(parts.builder.groups().size()), row_(parts.builder.constraints()) {
    parts.sides.clear();
    parts.along = {};
  }
  std::vector<ModelElement> elements() const {
    std::vector<ModelElement> elements;
    int row = row_;
    const auto& groups = parts_.builder.groups();
    for (std::size_t g = group_; g < groups.size(); ++g) {
      const std::string name = groups[g]->name(0);
      if (!begins_with(name, "interface ") && !begins_with(name, "body ") &&
          parts_.measuring.count(groups[g].get()) == 0)
        elements.push_back({groups[g], row});
      row += groups[g]->size() * groups[g]->local_constraints();
    }
    return elements;
  }

 private:
  ModelParts& parts_;
  std::size_t group_;
  int row_;
};

// Of the axis of `of` about the axis of `about`, both as time begins.
double angle_between(const MultibodyBuilder& builder, const Attachment& of, const Attachment& about) {
  const Eigen::Vector3d axis = initial_placement(builder, of.frame).rotation * of.axes.col(2);
  const Eigen::Matrix3d axes = initial_placement(builder, about.frame).rotation * about.axes;
  return std::atan2(axes.col(1).dot(axis), axes.col(0).dot(axis));
}

void read_and_keep_joint(JsonObject& object, const std::string& name, ModelParts& parts) {
  const Added added(parts);
  read_joint(object, name, parts);
  const Joint& joint = parts.joints.at(name);
  ModelJoint kept{name, joint.kind, joint.a, joint.b, joint.radius, added.elements()};
  if (joint.kind == JointKind::universal)
    kept.angle_begin = {angle_between(parts.builder, joint.b, joint.a),
                        angle_between(parts.builder, joint.a, joint.b)};
  parts.model.joints.push_back(std::move(kept));
}

ModelAction read_and_keep(JsonObject& object, const std::string& name, ModelParts& parts,
                          void (*read)(JsonObject&, const std::string&, ModelParts&)) {
  const Added added(parts);
  read(object, name, parts);
  return {name, object.text("type"), added.elements(), parts.sides, parts.along};
}

void read_and_keep_motion(JsonObject& object, const std::string& name, ModelParts& parts) {
  parts.model.motions.push_back(read_and_keep(object, name, parts, read_motion));
}

void read_and_keep_force(JsonObject& object, const std::string& name, ModelParts& parts) {
  parts.model.forces.push_back(read_and_keep(object, name, parts, read_force));
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
                         "where time begins it is " + number_text(residual.position[row]) +
                             " off; beside flexible bodies a motion has to begin where bodies are placed");
}

/// Their times alone are 0.8 GB.
constexpr int kMostOutputs = 100000000;

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
  model.outputs = file.integer("outputs", 1, kMostOutputs);
  if (file.has("start"))
    model.starts_at_rest = file.choice<bool>("start", {{"as_given", false}, {"equilibrium", true}});
  parts.gravity = file.vector("gravity", parts.gravity);
  read_all(file, "materials", parts, read_material);
  read_all(file, "bodies", parts, read_body);
  read_all(file, "joints", parts, read_and_keep_joint);
  read_all(file, "points", parts, read_point);
  read_all(file, "motions", parts, read_and_keep_motion);
  read_all(file, "forces", parts, read_and_keep_force);
  model.reactions = file.texts("reactions");
  std::set<std::string> reacting;
  for (const std::string& joint : model.reactions) {
    if (parts.joints.count(joint) == 0) file.refuse("reactions", "there is no joint '" + joint + "'");
    if (!reacting.insert(joint).second) file.refuse("reactions", "joint '" + joint + "' is named twice");
  }
  model.record = file.texts("record");
  if (file.has("integrator")) {
    JsonObject integrator = file.object("integrator");
    model.integrator = read_integrator(integrator, parts.builder.length_unit());
  }
  file.finish();
  model.system = parts.builder.build(threads, backend);
  model.integrator.threads = threads;
  model.integrator.backend = backend;
  model.q0 = parts.builder.initial_q();
  model.v0 = parts.builder.initial_v();
  check_motions(model);
  try {
    chosen_quantities(model);
  } catch (const InvalidInput& e) {
    throw InvalidInput("record", e.what());
  }
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
  for (int i = 0; i < model.outputs; ++i) times.push_back(model.end * i / model.outputs);
  times.push_back(model.end);  // not end * outputs / outputs, which rounding may make more
  return times;
}

}  // namespace mfs::dae
