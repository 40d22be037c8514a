// What mfs-dae tells of equilibria.
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "test/dae/program/results.hpp"
#include "test/program/run_program.hpp"

namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class StaticsProgram : public testing::Test {
 protected:
  TemporaryFolder folder_;
};

/// A bar of 1 m, 1 kg on a hinge about z at the origin, at this angle from the x axis; gravity along -y.
ordered_json bar(double angle) {
  ordered_json json = {{"name", "bar"}, {"end", 1}, {"outputs", 1}, {"gravity", {0, -9.81, 0}}};
  json["bodies"]["bar"] = {{"type", "rigid"},
                           {"mass", 1},
                           {"inertia", {0.01, 1.0 / 12, 1.0 / 12}},
                           {"position", {0.5 * std::cos(angle), 0.5 * std::sin(angle), 0}},
                           {"rotation", {{"axis", {0, 0, 1}}, {"angle", angle}}}};
  json["joints"]["hinge"] = {
      {"type", "revolute"}, {"a", "ground"}, {"b", "bar"}, {"point", {0, 0, 0}}, {"axis", {0, 0, 1}}};
  return json;
}

// sqrt(2 L / (3 g)) = 0.2607 s.
TEST_F(StaticsProgram, SaysThatAnEquilibriumIsUnstable) {
  const std::string note = "this equilibrium is unstable: a small motion, in which bar.",
                    grows = "by e in 0.261 s";
  const std::string upright = folder_.write("upright.json", bar(0.5 * M_PI).dump());
  const ProgramRun rest = run_program(
      {"static", upright, "-o", folder_.path("out"), "--no-plots", "--json", folder_.path("r.json")});
  EXPECT_EQ(rest.code, 0) << rest.err;
  EXPECT_THAT(rest.out, AllOf(HasSubstr("note            " + note), HasSubstr(grows)));
  const auto notes = ordered_json::parse(text_of(folder_.path("r.json")))["notes"];
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_THAT(notes[0].get<std::string>(), AllOf(HasSubstr(note), HasSubstr("it is where the model begins")));
  EXPECT_THAT(run_program({"modes", upright}).out, HasSubstr("note            " + note));
  ordered_json starts = bar(0.5 * M_PI);
  starts["start"] = "equilibrium";
  starts["end"] = 0.01;
  EXPECT_THAT(run_program({"run", folder_.write("starts.json", starts.dump()), "-o", folder_.path("out"),
                           "--no-plots"})
                  .out,
              HasSubstr("note            " + note));
}

TEST_F(StaticsProgram, SaysWhatModesOfAMotionAre) {
  ordered_json json = bar(0);
  EXPECT_THAT(run_program({"modes", folder_.write("falls.json", json.dump()), "--at", "0.3"}).out,
              HasSubstr("note            the motion is not steady: its matrices change as it goes on"));
  json.erase("gravity");
  const std::string rests = folder_.write("rests.json", json.dump());
  EXPECT_THAT(run_program({"modes", rests, "--at", "0.3"}).out, Not(HasSubstr("note")));
  json["bodies"]["bar"]["angular_velocity"] = {0, 0, 5};
  json["bodies"]["bar"]["velocity"] = {0, 2.5, 0};
  const std::string turns = folder_.write("turns.json", json.dump());
  EXPECT_THAT(run_program({"modes", turns, "--at", "0.3"}).out,
              HasSubstr("note            all turns as one body, at 5 rad/s: modes are those seen from axes"));
  EXPECT_THAT(run_program({"linearize", turns, "--at", "0.3", "-o", folder_.path("matrices")}).out,
              HasSubstr("note            the mechanism moves: matrices are those of this moment"));
}

/// A disc of 0.5 m that rolls along -y with 2 m/s. It may as well roll in another direction: turned about z
/// its place stays, its Euler parameters p = (c, 0, c, 0) change by z p / 2, its velocity by z x v and p' = w
/// p / 2 by z p' / 2. That fulfils the constraints on velocities by Phi_q and V_q together alone.
TEST_F(StaticsProgram, LinearizesWhatRolls) {
  ordered_json json = {{"name", "disc"}, {"end", 1}, {"outputs", 1}, {"gravity", {0, 0, -9.81}}};
  json["bodies"]["disc"] = {{"type", "rigid"},
                            {"mass", 1},
                            {"inertia", {0.0625, 0.0625, 0.125}},
                            {"position", {0, 0, 0.5}},
                            {"rotation", {{"axis", {0, 1, 0}}, {"angle", M_PI_2}}},
                            {"velocity", {0, -2, 0}},
                            {"angular_velocity", {4, 0, 0}}};
  json["joints"]["road"] = {
      {"type", "rolling_wheel"}, {"a", "ground"},       {"b", "disc"},  {"point", {0, 0, 0.5}},
      {"axis", {0, 0, 1}},       {"axis_b", {1, 0, 0}}, {"radius", 0.5}};
  const std::string out = folder_.path("rolls");
  const ProgramRun run =
      run_program({"linearize", folder_.write("disc.json", json.dump()), "--at", "0", "-o", out});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("M, D, K, Phi_q, V_q, F"));
  const double c = std::sqrt(0.5);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(7), rate = Eigen::VectorXd::Zero(7);
  x.tail(4) << 0, -0.5 * c, 0, 0.5 * c;
  rate << 2, 0, 0, -c, 0, c, 0;
  const Eigen::VectorXd by_rates = read_dense(out + "/Phi_q.mtx") * rate,
                        by_places = read_dense(out + "/V_q.mtx") * x;
  ASSERT_EQ(by_rates.size(), 4);
  EXPECT_NEAR((by_rates + by_places).norm(), 0, 1e-9);
  EXPECT_GT(by_rates.norm(), 0.1);
}

// The torque of a controller feeds it: x'' - 0.1 x' + (3 g / 2 L) x = 0, s = 0.05 + 3.836 i.
TEST_F(StaticsProgram, SaysThatAMotionIsFed) {
  ordered_json json = bar(-0.5 * M_PI);
  json["forces"]["controller"] = {
      {"type", "actuator"}, {"joint", "hinge"}, {"torque", "hinge.angle_rate/30"}};
  const ProgramRun rest = run_program(
      {"static", folder_.write("fed.json", json.dump()), "-o", folder_.path("out"), "--no-plots"});
  EXPECT_EQ(rest.code, 0) << rest.err;
  EXPECT_THAT(rest.out, HasSubstr("moves most, swings at 0.61 Hz and grows by e in 20 s\n"));
}

// What the search has moved is not what constraints ask for: here a motion by 0.2 rad.
TEST_F(StaticsProgram, SaysWhatWasCorrectedBeforeTheSearch) {
  ordered_json json = bar(0);
  const auto out = [&] {
    const ProgramRun run = run_program(
        {"static", folder_.write("bar.json", json.dump()), "-o", folder_.path("out"), "--no-plots"});
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("ParaView"));
    return run.out;
  };
  EXPECT_THAT(out(), Not(HasSubstr("note")));
  json["motions"]["crank"] = {{"type", "rotation"}, {"joint", "hinge"}, {"angle", "0.2 + t"}};
  const std::string note =
      "note            initial positions are corrected by up to 0.0998 m (body bar) and 0.2 rad";
  EXPECT_THAT(out(), AllOf(HasSubstr(note), Not(HasSubstr("velocities"))));
}

/// A top of A = 0.6, C = 0.05 about its foot whose centre is 0.5 m from there, at 0.8 rad from up. It
/// precesses at 1.025 rad/s; seen from axes that turn along nutation is 2.42811 Hz, by the steady motion's
/// closed form A^2 s^2 + A^2 p^2 sin^2 + (C w - 2 A p cos)^2 = 0, w the spin and p the precession.
TEST_F(StaticsProgram, ListsModesOfATopAsExactlyAsItPrecesses) {
  ordered_json json =
      ordered_json::parse(R"({"name": "top", "end": 0.5, "outputs": 1, "gravity": [0, 0, -9.81],
    "bodies": {"p": {"type": "rigid", "mass": 2, "inertia": [0.1, 0.1, 0.05],
      "position": [0.35867804544976145, 0, 0.34835335467358275],
      "angular_velocity": [142.95898117697737, 0, 139.8687608379949], "velocity": [0, 0.3676130831345077, 0],
      "rotation": {"axis": [0, 1, 0], "angle": 0.8}}},
    "joints": {"h": {"type": "spherical", "a": "ground", "b": "p", "point": [0, 0, 0]}}})");
  const ProgramRun run =
      run_program({"modes", folder_.write("top.json", json.dump()), "--at", "0", "--json", "-"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_NEAR(ordered_json::parse(run.out)["modes"][2]["frequency"], 2.4281105, 5e-6);
}

// It would be the root of all folders.
TEST_F(StaticsProgram, RefusesAFolderWithoutAName) {
  ASSERT_EQ(run_program({"models", "--write", folder_.path("models")}).code, 0);
  const std::string model = folder_.path("models") + "/simple_pendulum.json";
  for (const std::string command : {"run", "static", "modes", "linearize"}) {
    const ProgramRun run = run_program({command, model, "-o", ""});
    EXPECT_EQ(run.code, 2) << command;
    EXPECT_THAT(run.err, HasSubstr("-o: the folder has no name")) << command;
  }
}

// Flexible, so that the solver's own backend is asked. Without a card `cuda` says so.
TEST_F(StaticsProgram, WorksByTheBackendThatIsAskedFor) {
  ASSERT_EQ(run_program({"models", "--write", folder_.path("models")}).code, 0);
  const std::string model = folder_.path("models") + "/bell_crank.json";
  const auto report = [&](const std::string& command, const std::string& backend) {
    const ProgramRun run = run_program({command, model, "-o", folder_.path("out"), "--no-plots", "--threads",
                                        "2", "--json", "-", "--backend", backend});
    EXPECT_EQ(run.code, 0) << run.err;
    return ordered_json::parse(run.out);
  };
  const auto expected = report("modes", "openmp");
  for (const std::string backend : {"serial", "kokkos"}) {
    const auto modes = report("modes", backend);
    EXPECT_EQ(modes["backend"], backend);
    for (std::size_t i = 0; i < expected["modes"].size(); ++i) {
      const double frequency = expected["modes"][i]["frequency"];
      EXPECT_NEAR(modes["modes"][i]["frequency"], frequency, 1e-6 * frequency) << backend;
    }
    EXPECT_EQ(report("static", backend)["status"], "solved");
  }
  const ProgramRun run = run_program({"static", model, "-o", folder_.path("out"), "--backend", "cuda"});
  EXPECT_THAT(run.code, testing::AnyOf(0, 7)) << run.err;
}

}  // namespace
