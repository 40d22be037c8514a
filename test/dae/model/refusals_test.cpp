// Whatever is wrong in a model file is refused, with its place in the file.
#include <ostream>

#include <gmock/gmock.h>

#include "test/dae/mechanics/expect_refused.hpp"
#include "test/dae/model/small_model.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using mfs::dae::Json;

struct Mistake {
  const char* at;     // in the file, as a JSON pointer
  const char* value;  // put there; nothing: what is there is taken away
  const char* argument;
  const char* text;
};

void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << mistake.at << " = " << mistake.value;
}

const Mistake kMistakes[] = {
    {"/name", "", "name", "is missing"},
    {"/colour", "3", "colour",
     "is not known here; known are: bodies, description, end, forces, gravity, integrator, joints, "
     "materials, "
     "motions, name, outputs, parameters, points, reactions, record, start"},
    {"/end", "\"long\"", "end", "must be a number, not of type string"},
    {"/end", "0", "end", "must be positive"},
    {"/end", "-1e-9", "end", "must be positive, not -1e-09"},
    {"/end", "1e101", "end", "must not be more than 1e100"},
    {"/outputs", "1.5", "outputs", "must be an integer from 1 to 100000000"},
    {"/outputs", "0", "outputs", "must be an integer from 1 to 100000000"},
    {"/outputs", "100000001", "outputs", "must be an integer from 1 to 100000000"},
    {"/gravity", "[0, 1]", "gravity", "must have three numbers, not 2"},
    {"/gravity", "[0, 1, \"down\"]", "gravity", "must be an array of numbers, but has one of type string"},
    {"/gravity", "9.81", "gravity", "must be an array of numbers, not a number"},
    {"/materials", "[]", "materials", "must be an object, not of type array"},
    {"/reactions", "\"tip\"", "reactions", "must be an array of texts"},
    {"/reactions/0", "4", "reactions", "must be an array of texts"},
    {"/reactions/1", "\"tip\"", "reactions", "joint 'tip' is named twice"},
    {"/reactions/0", "\"top\"", "reactions", "there is no joint 'top'"},

    {"/materials/steel/law", "\"rubber\"", "materials.steel.law",
     "'rubber' is none of: neo_hookean, st_venant_kirchhoff"},
    {"/materials/steel/young", "-1", "materials.steel.young", "must be positive"},
    {"/materials/steel/poisson", "0.5", "materials.steel.poisson", "must be between -1 and 0.5"},
    {"/materials/steel/density", "0", "materials.steel.density", "must be positive"},
    {"/materials/steel/colour", "1", "materials.steel.colour", "is not known here"},

    {"/bodies/ground", "{}", "bodies.ground", "name of the ground"},
    {"/bodies/a:b", "{}", "bodies.a:b", "letters, digits"},
    {"/bodies/..~1x", "{}", "bodies.../x", "letters, digits"},
    {"/bodies/block/type", "7", "bodies.block.type", "must be a text, not a number"},
    {"/bodies/block/type", "\"soft\"", "bodies.block.type", "'soft' is none of: flexible, rigid"},
    {"/bodies/block/mass", "0", "bodies.block.mass", "must be positive"},
    {"/bodies/block/inertia", "[1, 2]", "bodies.block.inertia", "must have 3 numbers"},
    {"/bodies/block/inertia", "[1, 2, -3]", "bodies.block", "inertia"},
    {"/bodies/block/inertia", "[1, 2, 3.1]", "bodies.block",
     "body block: no body has its inertia tensor: the largest principal moment, 3.1 kg m^2, is more than the "
     "sum of the others, 3"},
    // Its principal moments are 1, 1 and 2.1.
    {"/bodies/block/inertia", "[1.55, 1, 1.55, 0, 0, 0.55]", "bodies.block", "body block: no body has"},
    {"/bodies/block/colour", "1", "bodies.block.colour",
     "is not known here; known are: angular_velocity, inertia, mass, position, rotation, type, velocity"},
    {"/bodies/bar/material", "\"wood\"", "bodies.bar.material", "there is no material 'wood'"},
    {"/bodies/bar/mass", "\"heavy\"", "bodies.bar.mass", "is none of: consistent, lumped"},
    {"/bodies/bar/damping/beta", "-1", "bodies.bar.damping.beta", "must not be negative"},
    {"/bodies/bar/damping/gamma", "1", "bodies.bar.damping.gamma", "is not known here"},
    {"/bodies/bar/rotation/axis", "[0, 0, 0]", "bodies.bar.rotation.axis", "must not be zero"},
    {"/bodies/bar/rotation/angle", "", "bodies.bar.rotation.angle", "is missing"},
    {"/bodies/bar/colour", "1", "bodies.bar.colour", "is not known here"},
    {"/bodies/bar/mesh", "", "bodies.bar.mesh", "is missing"},
    {"/bodies/bar/mesh", "{\"gmsh\": \"none.msh\"}", "bodies.bar", "nowhere/none.msh"},
    {"/bodies/bar/mesh", "{\"gmsh\": \"/\"}", "bodies.bar", "/: cannot be read: it is a folder"},
    {"/bodies/bar/mesh/generator", "\"ball\"", "bodies.bar.mesh.generator", "'ball' is none of: "},
    {"/bodies/bar/mesh/element", "\"hex9\"", "bodies.bar.mesh.element", "'hex9' is none of: "},
    {"/bodies/bar/mesh/refine", "0", "bodies.bar.mesh.refine", "must be an integer from 1 to 100"},
    {"/bodies/bar/mesh/size", "[1, 0, 1]", "bodies.bar.mesh.size", "must be positive"},
    {"/bodies/bar/mesh/divisions", "[4, 1.5, 1]", "bodies.bar.mesh.divisions", "must be integers"},
    {"/bodies/bar/mesh/length", "3", "bodies.bar.mesh.length",
     "is not known here; known are: divisions, element, generator, gmsh, refine, size"},
    {"/bodies/bar/mesh",
     R"({"generator": "box", "element": "hex8", "refine": 10, "size": [1, 1, 1], "divisions": [1000, 1000, 10]})",
     "bodies.bar", "mesh: 1e+10 cells are more than the 8.83738e+06 of this element"},
    {"/bodies/bar/mesh", R"({"generator": "bell_crank", "element": "tet10", "refine": 100})", "bodies.bar",
     "mesh: 8.6e+07 cells are more than the 1.03743e+06 of this element"},

    {"/parameters", R"({"a": "b + 1"})", "parameters.a", "there is no parameter 'b'"},
    {"/parameters", R"({"a": "1 / 0"})", "parameters.a", "is not finite"},
    {"/parameters", R"({"t": 1})", "parameters.t", "other meanings"},
    {"/parameters", R"({"a-b": 1})", "parameters.a-b", "letters, digits and _"},
    {"/parameters", R"({"a.b": 1})", "parameters.a.b", "other meanings"},
    {"/bodies/block/mass", "\"3 kg\"", "bodies.block.mass", "expression '3 kg'"},

    {"/joints/hinge/type", "\"glue\"", "joints.hinge.type", "'glue' is none of: "},
    {"/joints/hinge/a", "\"nobody\"", "joints.hinge.a", "'nobody' is neither ground nor a rigid body"},
    {"/joints/hinge/b", "\"bar\"", "joints.hinge.b", "nor BODY:NODE_SET"},
    {"/joints/hinge/b", "\"block:x0\"", "joints.hinge.b", "no BODY:NODE_SET with a flexible body"},
    {"/joints/hinge/b", "\"bar:x7\"", "joints.hinge.b", "has no node set 'x7', only: x0, x1, y0, y1, z0, z1"},
    {"/joints/hinge/b", "\"ground\"", "joints.hinge", "hinge"},
    {"/joints/hinge/point", "", "joints.hinge.point", "is missing"},
    {"/joints/hinge/axis", "", "joints.hinge.axis", "is missing"},
    {"/joints/hinge/axis", "[0, 0, 0]", "joints.hinge", "no direction"},
    {"/joints/tip/axis", "[0, 0, 1]", "joints.tip.axis", "is not known here"},
    {"/joints/tip",
     R"({"type": "universal", "a": "ground", "b": "block", "point": [0, 3.5, 0.1], "axis": [0, 1, 0],
         "axis_b": [0, -2, 0]})",
     "joints.tip.axis_b", "is parallel to axis"},
    {"/joints/tip",
     R"({"type": "rolling_wheel", "a": "ground", "b": "block", "point": [0, 3.5, 0.1], "axis": [0, 1, 0],
         "axis_b": [0, 2, 0], "radius": 1})",
     "joints.tip", "the wheel lies flat"},
    {"/joints/tip",
     R"({"type": "rolling_ball", "a": "ground", "b": "block", "point": [0, 3.5, 0.1], "axis": [0, 1, 0], "radius": 0})",
     "joints.tip.radius", "must be positive"},

    {"/motions/turn/type", "\"dance\"", "motions.turn.type", "'dance' is none of: "},
    {"/motions/turn/joint", "\"nope\"", "motions.turn.joint", "there is no joint 'nope'"},
    {"/motions/turn/joint", "\"tip\"", "motions.turn.joint", "'tip' does not move that way"},
    {"/motions/turn/angle", "3", "motions.turn.angle",
     "must be a function or an expression, as \"3\", not a number"},
    {"/motions/turn/angle/type", "\"cubic\"", "motions.turn.angle.type", "'cubic' is none of: "},
    {"/motions/turn/angle/offset", "1", "motions.turn.angle.offset", "is not known here"},
    {"/motions/turn/angle", R"({"type": "harmonic", "amplitude": 1, "frequency": 0})",
     "motions.turn.angle.frequency", "must be positive"},
    {"/motions/turn/angle", R"({"type": "smooth_step", "begin": 1, "end": 1, "after": 1})", "motions.turn",
     "begin"},
    {"/motions/turn/angle", R"({"type": "spline", "x": [0, 1], "y": [0]})", "motions.turn.angle.y",
     "as many numbers as x"},
    {"/motions/turn/angle", R"({"type": "spline", "x": [0, 0], "y": [0, 1]})", "motions.turn.angle.x",
     "must ascend"},
    {"/motions/held", R"({"type": "nodes", "side": "block", "x": {"type": "constant", "value": 0}})",
     "motions.held.side", "no BODY:NODE_SET"},
    {"/motions/held", R"({"type": "nodes", "side": "bar:x0"})", "motions.held.x", "one of x, y, z is needed"},
    {"/motions/held", R"({"type": "point", "side": "block", "point": [0, 0, 0]})", "motions.held", "held"},

    {"/forces/cushion/type", "\"pillow\"", "forces.cushion.type", "'pillow' is none of: "},
    {"/forces/cushion/stiffness", "[1, 2, 3]", "forces.cushion.stiffness", "must have six numbers"},
    {"/forces/cushion/stiffness/3", "-4", "forces.cushion", "negative"},
    {"/forces/cushion/stiffness/3", "1e300", "forces.cushion.stiffness",
     "must not be more than 1e100 in size"},
    {"/forces/strut/stiffness", "1e300", "forces.strut.stiffness", "must not be more than 1e100 in size"},
    {"/forces/strut/stiffness", "-1", "forces.strut.stiffness", "must not be negative"},
    {"/forces/strut/point_a", "[0, 3.5, 0.1]", "forces.strut", "strut"},
    {"/forces/push/x", "", "forces.push", "push"},
    {"/forces/wind/side", "\"block\"", "forces.wind.side", "no BODY:NODE_SET"},
    {"/forces/wind/x", "", "forces.wind", "wind"},

    {"/points/tip/body", "\"nobody\"", "points.tip.body", "nobody"},
    {"/points/tip/point", "", "points.tip.point", "is missing"},
    {"/points/tip/point", "[-0.01, 51, 0.19]", "points.tip.point",
     "is 48 m from the nearest node of 'bar', whose elements are 0.167705 m wide at most"},

    {"/integrator/method", "\"euler\"", "integrator.method", "'euler' is none of: bdf, generalized_alpha"},
    {"/integrator/unknowns", "\"some\"", "integrator.unknowns", "'some' is none of: full, reduced"},
    {"/integrator/rtol", "-1", "integrator.rtol", "must not be negative"},
    {"/integrator/max_order", "0", "integrator.max_order", "must be an integer from 1 up"},
    {"/integrator/keep_factors", "1", "integrator.keep_factors", "must be true or false, not a number"},
    {"/integrator/step", "1", "integrator.step", "is not known here"},

    {"/forces/push/x", "\"1 +\"", "forces.push.x", "expression '1 +'"},
    {"/forces/push/x", "\"speed\"", "forces.push.x", "there is no parameter 'speed'"},
    {"/forces/push/x", "\"hinge.turn\"", "forces.push.x", "there is no quantity 'turn'"},
    {"/forces/push/x", "\"tip.angle\"", "forces.push.x", "joint 'tip' does not move that way"},
    {"/forces/push/x", "\"door.angle\"", "forces.push.x", "there is no joint 'door'"},
    {"/forces/push/x", "\"hinge.vx\"", "forces.push.x", "there is no point 'hinge'"},
    {"/forces/push/axes", "\"world\"", "forces.push.axes", "'world' is none of: body, ground"},
    {"/forces/strut/force", "\"t\"", "forces.strut.force", "there is no parameter 't'; the variable is x"},
    {"/forces/motor", R"({"type": "actuator", "joint": "tip", "torque": "1"})", "forces.motor.joint",
     "joint 'tip' does not move that way"},
    {"/forces/motor", R"({"type": "actuator", "a": "ground", "b": "block", "point_a": [0, 1, 2], "point_b":
      [0, 1, 2], "force": "1"})",
     "forces.motor", "its points have come together"},
    {"/forces/motor", R"({"type": "actuator", "a": "ground", "b": "block", "point_a": [0, 1, 2], "point_b":
      [3, 1, 2], "force": "1", "torque": "1"})",
     "forces.motor.torque", "is not known here; known are: a, b, force, joint, point_a, point_b, type"},
    {"/forces/motor", R"({"type": "torque", "side": "block"})", "forces.motor", "it has no function"},
    {"/forces/motor", R"({"type": "rotational_spring", "joint": "hinge", "stiffness": 1, "torque": "x"})",
     "forces.motor", "it has both a stiffness and a function"},
    {"/forces/motor", R"({"type": "actuator", "joint": "hinge"})", "forces.motor.joint",
     "has neither torque nor force"},
    {"/motions/turn/angle", "\"0.5 * hinge.angle\"", "motions.turn", "it depends on what it moves"},
    {"/motions/turn/angle", "\"block_top.vx\"", "motions.turn", "it must not depend on rates"},
};

class Refusal : public testing::TestWithParam<Mistake> {};

TEST_P(Refusal, NamesThePlace) {
  const Mistake& mistake = GetParam();
  Json json = small_model();
  const Json::json_pointer at(mistake.at);
  if (*mistake.value)
    json[at] = Json::parse(mistake.value);
  else
    json[at.parent_pointer()].erase(at.back());
  mfs::test::expect_refused(mistake.argument, mistake.text,
                            [&] { mfs::dae::make_model(json, "nowhere", 1); });
}

INSTANTIATE_TEST_SUITE_P(Model, Refusal, testing::ValuesIn(kMistakes));

TEST(ModelFile, ThatCannotBeReadOrIsNoJson) {
  const TemporaryFolder folder;
  const auto read = [](const std::string& path) { return [path] { mfs::dae::read_json(path); }; };
  mfs::test::expect_refused(folder.path("none.json"), "No such file", read(folder.path("none.json")));
  mfs::test::expect_refused(folder.path("."), "it is a folder", read(folder.path(".")));
  const std::string broken = folder.write("broken.json", "{\n\"name\": }");
  mfs::test::expect_refused(broken, "parse error at line 2, column 9", read(broken));
  const std::string twice = folder.write("twice.json", R"({"a": {"b": 1, "c": [{"b": 1}], "b": 2}})");
  mfs::test::expect_refused(twice, "the key 'b' is twice", read(twice));
  const std::string large = folder.write("large.json", R"({"end": 1e999})");
  mfs::test::expect_refused(large, "1e999", read(large));
  EXPECT_EQ(mfs::dae::read_json(folder.write("good.json", R"({"b": {"a": 1}, "a": 2})"))["a"], 2);
}

TEST(Model, MustBeAnObject) {
  mfs::test::expect_refused("", "must be an object", [] { mfs::dae::make_model(Json::array(), "", 1); });
}

// In messages as what ends no text.
TEST(Model, ANameWithAControlCharacterIsShown) {
  Json json = small_model();
  json["bodies"][std::string("a\0b\n", 4)] = Json::object();
  mfs::test::expect_refused("bodies.a\\u0000b\\u000a", "a name is made of letters",
                            [&] { mfs::dae::make_model(json, "", 1); });
}

TEST(RefineMeshes, NeedsAGenerator) {
  Json json = small_model();
  json["bodies"].erase("bar");
  mfs::test::expect_refused("refine", "no mesh", [&] { mfs::dae::refine_meshes(json, 2); });
}

}  // namespace
