// The program mfs-dae from outside: exit codes, standard output and error, files.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "test/dae/model/small_model.hpp"
#include "test/dae/program/results.hpp"
#include "test/program/run_program.hpp"

namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class DaeProgram : public testing::Test {
 protected:
  std::string path(const std::string& name) { return folder_.path(name); }
  std::string file(const std::string& name, const std::string& text) { return folder_.write(name, text); }
  // A block that falls freely.
  std::string falling(double gravity = -10) {
    ordered_json json = ordered_json::parse(R"({"name": "falling", "end": 1, "outputs": 4, "bodies": {"block":
      {"type": "rigid", "mass": 2, "inertia": [1, 1, 1]}}, "points": {"corner": {"body": "block", "point": [1, 0, 0]}}})");
    json["gravity"] = {0, 0, gravity};
    return file("falling.json", json.dump());
  }
  // Runs it, expects this exit code and one line of complaint, and gives that back.
  std::string complaint(const std::vector<std::string>& arguments, int code) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.code, code) << run.err;
    EXPECT_THAT(run.err, AllOf(StartsWith("mfs-dae: "), EndsWith("\n")));
    EXPECT_EQ(run.err.find('\n'), run.err.size() - 1) << run.err;
    return run.err;
  }
  TemporaryFolder folder_;
};

TEST_F(DaeProgram, ListsAndWritesItsModels) {
  const ProgramRun list = run_program({"models"});
  EXPECT_EQ(list.code, 0);
  EXPECT_THAT(list.out,
              AllOf(HasSubstr("crank_piston "), HasSubstr("suspension "), HasSubstr("bell_crank ")));
  const ProgramRun write = run_program({"models", "--write", path("new/models"), "--refine", "3"});
  EXPECT_EQ(write.code, 0) << write.err;
  for (const char* name : {"crank_piston", "suspension", "bell_crank"}) {
    const std::string model = path("new/models/") + name + ".json";
    EXPECT_THAT(write.out, HasSubstr(model + "\n"));
    for (const auto& body : ordered_json::parse(text_of(model))["bodies"])
      if (body.contains("mesh")) {
        EXPECT_EQ(body["mesh"]["refine"], 3) << name;
      }
  }
}

TEST_F(DaeProgram, TakesAModelOfTheLibraryByItsName) {
  const ProgramRun check = run_program({"check", "simple_pendulum"});
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_EQ(check.out,
            "simple_pendulum: 0 flexible and 1 rigid bodies, 7 coordinates, 6 constraints, 27 unknowns\n");
  EXPECT_THAT(complaint({"check", "perpetuum_mobile"}, 3), HasSubstr("perpetuum_mobile: cannot be read"));
  // As after `mfs-dae run simple_pendulum -o simple_pendulum`.
  const std::filesystem::path here = std::filesystem::current_path();
  std::filesystem::create_directories(path("simple_pendulum"));
  std::filesystem::current_path(path("."));
  EXPECT_EQ(run_program({"check", "simple_pendulum"}).out, check.out);
  std::filesystem::current_path(here);
}

TEST_F(DaeProgram, ChecksAModel) {
  const ProgramRun check = run_program({"check", file("small.json", kSmallModel)});
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_EQ(check.out,
            "small: 1 flexible and 1 rigid bodies, 264 coordinates, 66 constraints, 858 unknowns\n");
  const ProgramRun coarse = run_program({"check", path("small.json"), "--refine", "1"});
  EXPECT_THAT(coarse.out, HasSubstr(" 81 coordinates,"));
}

TEST_F(DaeProgram, NamesWhatIsRedundant) {
  const std::string hinges = R"({
    "name": "door", "end": 0.01, "outputs": 1,
    "bodies": {"door": {"type": "rigid", "mass": 1, "inertia": [1, 1, 1]}},
    "joints": {
      "high": {"type": "revolute", "a": "ground", "b": "door", "point": [0, 1, 0], "axis": [0, 1, 0]},
      "low": {"type": "spherical", "a": "ground", "b": "door", "point": [0, 0, 0]}
    }
  })";
  const ProgramRun run = run_program({"run", file("door.json", hinges), "-o", path("out")});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("7 coordinates, 6 constraints leave 1 degrees of freedom,"));
  EXPECT_THAT(run.out, HasSubstr("left out        3 redundant constraints: joint low, equation 1 of 3 (along "
                                 "ground x); joint low, equation 2"));
}

TEST_F(DaeProgram, RunsAndSumsUp) {
  const ProgramRun run = run_program({"run", falling(), "-o", path("out"), "--json", path("report.json")});
  EXPECT_EQ(run.code, 0) << run.err;
  for (const char* line : {"model           falling: 7 coordinates, 1 constraints", "\nsteps ", "\nNewton ",
                           "\nviolation ", "\nmemory ", "\nreordering ", "\nfactorization ", "\nsolve ",
                           "\nassembly ", "\nrest ", "\nanalysis ", "\nParaView "})
    EXPECT_THAT(run.out, HasSubstr(line));
  const ordered_json report = ordered_json::parse(text_of(path("report.json")));
  EXPECT_EQ(report["name"], "falling");
  EXPECT_EQ(report["backend"], "openmp");
  EXPECT_EQ(report["coordinates"], 7);
  const Table series = read_table(path("out/time_series.csv"));
  for (const double a : series.at("acceleration corner [m/s2]")) EXPECT_NEAR(a, 10, 1e-6);
  const std::vector<double>&t = series.at("t [s]"), &z = series.at("bodies.block.position.z [m]");
  for (std::size_t i = 0; i < t.size(); ++i) EXPECT_NEAR(z[i], -5 * t[i] * t[i], 1e-6);
  EXPECT_THAT(text_of(path("out/results.npy")), HasSubstr("('bodies.block.orientation', '<f8', (4,)), "));
  EXPECT_THAT(text_of(path("out/vtu/rigid.bodies_0004.vtu")), HasSubstr("Name=\"bodies\""));
  EXPECT_TRUE(report["notes"].empty()) << report["notes"];
}

TEST_F(DaeProgram, LeavesNothingOfTheRunBefore) {
  const auto files = [&] {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path("out")))
      if (!entry.is_directory()) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  };
  const std::vector<std::string> arguments{"run", falling(), "-o", path("out"), "--no-plots"};
  run_program(arguments);
  const std::vector<std::string> of_four = files();
  ordered_json json = ordered_json::parse(text_of(falling()));
  json["outputs"] = 11;
  const std::string longer = file("longer.json", json.dump());
  run_program({"run", longer, "-o", path("out"), "--no-plots"});
  for (const char* picture : {"time_series.png", "steps.png", "deformed.png"})
    file(std::string("out/") + picture, "of the run before");
  std::vector<std::string> with_others = files();
  EXPECT_EQ(with_others.size(), of_four.size() + 7 + 3);
  // A run that does not come to write leaves all of it.
  json["end"] = -1;
  EXPECT_EQ(run_program({"run", file("wrong.json", json.dump()), "-o", path("out")}).code, 3);
  EXPECT_EQ(files(), with_others);
  // What is not of a run stays, whatever the list of the run before says.
  for (const char* name : {"mine.png", "vtu/mine_0001.vtu", "vtu/mine.vtu", "mine_0001.vtu"})
    file(std::string("out/") + name, "mine");
  std::string list = text_of(path("out/result.pvd"));
  for (const char* name : {"vtu/mine.vtu", "mine_0001.vtu", "vtu/../mine_0001.vtu", "../out/mine_0001.vtu"})
    list += std::string("<DataSet timestep=\"0\" part=\"0\" file=\"") + name + "\"/>\n";
  file("out/result.pvd", list);
  run_program(arguments);
  std::vector<std::string> expected = of_four;
  for (const char* name : {"mine.png", "mine_0001.vtu", "mine_0001.vtu", "mine.vtu"})
    expected.push_back(name);
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(files(), expected);
}

TEST_F(DaeProgram, RecordsWhatTheModelChooses) {
  ordered_json json = ordered_json::parse(text_of(falling()));
  json["record"] = {"bodies.*.velocity", "energy.kinetic"};
  const ProgramRun run =
      run_program({"run", file("chosen.json", json.dump()), "-o", path("out"), "--no-plots"});
  EXPECT_EQ(run.code, 0) << run.err;
  const Table series = read_table(path("out/time_series.csv"));
  EXPECT_EQ(series.size(), 1 + 1 + 3 + 1U);
  EXPECT_NEAR(series.at("energy.kinetic [J]").back(), 100, 1e-4);  // 2 kg at 10 m/s
  json["record"] = {"bodies.bloc"};
  EXPECT_THAT(complaint({"check", file("wrong.json", json.dump())}, 3),
              HasSubstr("record: bodies.bloc: there is no 'bloc'; known are: block"));
}

// A table of more columns than a spreadsheet takes keeps to the overview.
TEST_F(DaeProgram, LeavesALongRecordToTheBinaryFile) {
  ordered_json json = ordered_json::parse(text_of(falling()));
  for (int i = 0; i < 50; ++i) json["bodies"]["b" + std::to_string(i)] = json["bodies"]["block"];
  json["integrator"] = {{"max_order", 2}};
  const ProgramRun run =
      run_program({"run", file("many.json", json.dump()), "-o", path("out"), "--no-plots"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("time_series.csv has the overview alone"));
  EXPECT_EQ(read_table(path("out/time_series.csv")).size(), 2U);
  EXPECT_THAT(text_of(path("out/results.npy")), HasSubstr("('bodies.b49.velocity', '<f8', (3,)), "));
}

TEST_F(DaeProgram, SaysWhatItCorrectsAtTheBeginning) {
  ordered_json json = ordered_json::parse(text_of(falling()));
  json["bodies"]["block"]["velocity"] = {0, 0, 3};
  json["joints"]["pin"] = {{"type", "spherical"}, {"a", "ground"}, {"b", "block"}, {"point", {0, 0, 0}}};
  json["gravity"] = {0, 0, 0};
  const ProgramRun run = run_program(
      {"run", file("pin.json", json.dump()), "-o", path("out"), "--no-plots", "--json", path("report.json")});
  EXPECT_EQ(run.code, 0) << run.err;
  const std::string note =
      "initial velocities are corrected by up to 3 m/s (body block), so that all constraints hold";
  EXPECT_THAT(run.out, HasSubstr("note            " + note));
  EXPECT_EQ(ordered_json::parse(text_of(path("report.json")))["notes"], ordered_json::array({note}));
}

// A door on two hinges, the lower of which has this axis and place.
std::string door(const std::array<double, 3>& axis, double x) {
  ordered_json json = {{"name", "door"}, {"end", 0.01}, {"outputs", 1}};
  json["bodies"]["door"] = {{"type", "rigid"}, {"mass", 1}, {"inertia", {1, 1, 1}}};
  json["joints"]["high"] = {
      {"type", "revolute"}, {"a", "ground"}, {"b", "door"}, {"point", {0, 2, 0}}, {"axis", {0, 1, 0}}};
  json["joints"]["low"] = {
      {"type", "revolute"}, {"a", "door"}, {"b", "ground"}, {"point", {x, 0, 0}}, {"axis", axis}};
  return json.dump();
}

TEST_F(DaeProgram, NamesJointsThatAreOutOfLine) {
  const std::string straight = run_program({"check", file("door.json", door({0, 1, 0}, 0))}).out;
  EXPECT_THAT(straight, Not(HasSubstr("note")));
  // Half a degree, and a hinge that points the other way.
  const std::string askew = file("askew.json", door({-std::sin(M_PI / 360), -std::cos(M_PI / 360), 0}, 0));
  const std::string note =
      "the axis of joint low is 0.5 degrees off that of joint high, which may lock the mechanism";
  const ProgramRun check = run_program({"check", askew});
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_THAT(check.out, HasSubstr("note            " + note + "\n"));
  const ProgramRun run =
      run_program({"run", askew, "-o", path("out"), "--no-plots", "--json", path("r.json")});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(ordered_json::parse(text_of(path("r.json")))["notes"], ordered_json::array({note}));
  const ProgramRun beside = run_program({"check", file("beside.json", door({0, 1, 0}, 1e-3))});
  EXPECT_THAT(beside.out, HasSubstr("joint low is 0.001 m beside that of joint high"));
  // What differs by more is meant: 5 degrees, 0.3 m.
  const double turn = 5 * M_PI / 180;
  for (const std::string& meant : {door({std::sin(turn), std::cos(turn), 0}, 0), door({0, 1, 0}, 0.3)})
    EXPECT_THAT(run_program({"check", file("meant.json", meant)}).out, Not(HasSubstr("note")));
}

// The one of four parallel axes that is not; a pendulum's axis beside them is in no loop.
TEST_F(DaeProgram, NamesTheJointOfALoopThatIsOutOfLine) {
  run_program({"models", "--write", path("models")});
  ordered_json json = ordered_json::parse(text_of(path("models/four_bar.json")));
  const double turn = 0.1 * M_PI / 180;
  json["joints"]["A"]["axis"] = {0, std::sin(turn), std::cos(turn)};
  json["bodies"]["bob"] = {{"type", "rigid"}, {"mass", 1}, {"inertia", {1, 1, 1}}};
  json["joints"]["pin"] = {{"type", "revolute"},
                           {"a", "ground"},
                           {"b", "bob"},
                           {"point", {0, 0, 0}},
                           {"axis", {std::sin(turn), 0, std::cos(turn)}}};
  const std::string out = run_program({"check", file("four_bar.json", json.dump())}).out;
  EXPECT_THAT(out, HasSubstr("the axis of joint A is 0.1 degrees off that of joint B, which"));
  EXPECT_EQ(out.find("note"), out.rfind("note")) << out;
}

TEST_F(DaeProgram, NamesAUniversalJointWhoseAxesAreNotPerpendicular) {
  ordered_json json = ordered_json::parse(text_of(falling()));
  json["joints"]["cross"] = {{"type", "universal"}, {"a", "ground"},     {"b", "block"},
                             {"point", {0, 0, 0}},  {"axis", {1, 0, 0}}, {"axis_b", {1, 1, 0}}};
  EXPECT_THAT(run_program({"check", file("cross.json", json.dump())}).out,
              HasSubstr("the axes of joint cross are 45 degrees apart where bodies are placed"));
}

// Bodies in mm beside joints in m; a mass point on a rod of a metre is meant.
TEST_F(DaeProgram, NamesJointsThatAreFarFromTheirBodies) {
  const auto notes = [&](double a, double b, double radius) {
    ordered_json json = {{"name", "pair"}, {"end", 0.01}, {"outputs", 1}};
    const double inertia = 2 * radius * radius;
    json["bodies"]["left"] = {
        {"type", "rigid"}, {"mass", 2}, {"inertia", {inertia, inertia, inertia}}, {"position", {a, 0, 0}}};
    json["bodies"]["right"] = json["bodies"]["left"];
    json["bodies"]["right"]["position"] = {b, 0, 0};
    json["joints"]["hip"] = {
        {"type", "revolute"}, {"a", "left"}, {"b", "right"}, {"point", {0.1, 0, 0}}, {"axis", {0, 0, 1}}};
    return run_program({"check", file("pair.json", json.dump())}).out;
  };
  EXPECT_THAT(notes(50.1, 150.1, 0.05), HasSubstr("joint hip is 816 radii of gyration"));
  EXPECT_THAT(notes(50, 150, 50), Not(HasSubstr("note")));
  EXPECT_THAT(notes(0.1, 1.1, 1e-6), Not(HasSubstr("note")));
}

// A pin in mm on a beam in m; one on an arm of some lengths is meant.
TEST_F(DaeProgram, NamesJointsThatAreFarFromTheirMesh) {
  ordered_json json = {{"name", "beam"}, {"end", 0.01}, {"outputs", 1}};
  json["materials"]["rubber"] = {
      {"law", "st_venant_kirchhoff"}, {"young", 1e7}, {"poisson", 0.3}, {"density", 1000}};
  json["bodies"]["beam"] = {{"type", "flexible"}, {"material", "rubber"}};
  json["bodies"]["beam"]["mesh"] = {{"generator", "box"},
                                    {"element", "hex8"},
                                    {"refine", 1},
                                    {"size", {1, 0.1, 0.1}},
                                    {"divisions", {2, 1, 1}}};
  json["joints"]["pin"] = {{"type", "revolute"}, {"a", "ground"}, {"b", "beam:x1"}, {"axis", {0, 0, 1}}};
  const auto notes = [&](double x) {
    json["joints"]["pin"]["point"] = {x, 0.05, 0.05};
    return run_program({"check", file("beam.json", json.dump())}).out;
  };
  EXPECT_THAT(notes(48), HasSubstr("joint pin is 47 m from the nodes that it holds, whose mesh is 1 m long"));
  EXPECT_THAT(notes(6), Not(HasSubstr("note")));
}

// Not one of them is out of line.
TEST_F(DaeProgram, HasNoNotesOnItsOwnModels) {
  std::istringstream list(run_program({"models"}).out);
  int count = 0;
  for (std::string line; std::getline(list, line); ++count) {
    const std::string name = line.substr(0, line.find(' '));
    EXPECT_THAT(run_program({"check", name}).out, Not(HasSubstr("note"))) << name;
  }
  EXPECT_GE(count, 20);
}

// A bar that is pressed at its end: the law has its largest force at 1 / sqrt(3) of the length, and beyond
// that shorter elements push less than longer ones. What was reached is there. A slender bar would buckle
// before, by what rounding leaves, earlier with one BLAS than with another.
TEST_F(DaeProgram, NamesTheElementThatIsPressedTooFar) {
  ordered_json json = {{"name", "press"}, {"end", 1}, {"outputs", 10}};
  json["materials"]["soft"] = {
      {"law", "st_venant_kirchhoff"}, {"young", 1e7}, {"poisson", 0.3}, {"density", 1000}};
  json["bodies"]["bar"] = {{"type", "flexible"}, {"material", "soft"}, {"damping", {{"beta", 1e-3}}}};
  json["bodies"]["bar"]["mesh"] = {{"generator", "box"},
                                   {"element", "hex8"},
                                   {"refine", 1},
                                   {"size", {1, 0.2, 0.2}},
                                   {"divisions", {10, 1, 1}}};
  json["motions"]["wall"] = {{"type", "nodes"}, {"side", "bar:x0"}, {"x", "0"}, {"y", "0"}, {"z", "0"}};
  json["motions"]["ram"] = {{"type", "nodes"}, {"side", "bar:x1"}, {"x", "-0.9 * t"}, {"y", "0"}, {"z", "0"}};
  const std::string why = complaint(
      {"run", file("press.json", json.dump()), "-o", path("out"), "--no-plots", "--threads", "1"}, 7);
  EXPECT_THAT(why,
              testing::ContainsRegex("t = 0[.]4[0-9]* s.*; body bar, element [0-9]+ is pressed to [0-9.e-]* "
                                     "of its length; st_venant_kirchhoff is for small strains"));
  EXPECT_THAT(text_of(path("out/time_series.csv")), HasSubstr("\n0.4,"));
}

TEST_F(DaeProgram, SaysWhyALeaningWheelHasNoEquilibrium) {
  EXPECT_THAT(complaint({"static", "rolling_disc", "-o", path("out"), "--no-plots"}, 7),
              AllOf(HasSubstr("no static equilibrium has been found"),
                    HasSubstr("what rolls (joint road) may be held "
                              "up by its motion alone")));
}

TEST_F(DaeProgram, PlotsAreForThoseWhoWantThem) {
  const ProgramRun run = run_program({"run", falling(), "-o", path("out"), "--no-plots"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out.find("plot "), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path("out/steps.png")));
  EXPECT_THAT(complaint({"plot", path("nowhere")}, 3), HasSubstr("nowhere: holds no results"));
  const ProgramRun plot = run_program({"plot", path("out")});
  if (plot.err.find("needs matplotlib") != std::string::npos) GTEST_SKIP() << plot.err;
  EXPECT_EQ(plot.code, 0) << plot.err;
  for (const char* name : {"time_series", "steps", "deformed"}) {
    const std::string picture = path("out/") + name + ".png";
    EXPECT_THAT(plot.out, HasSubstr("plot            " + picture + "\n"));
    EXPECT_EQ(text_of(picture).substr(1, 3), "PNG");
  }
}

class DaeSignal : public DaeProgram, public testing::WithParamInterface<int> {
 protected:
  /// Runs the program, sends it the signal once `begun`, and reads its report. Its standard output:
  /// path("stdout").
  void run_until_signal(std::vector<std::string> arguments, const std::function<bool()>& begun,
                        ordered_json& read) {
    const std::string report = path("report.json"), out = path("stdout"), err = path("stderr");
    arguments.insert(arguments.end(), {"-o", path("out"), "--no-plots", "--json", report});
    const pid_t child = fork();
    if (child == 0) {
      dup2(open(out.c_str(), O_WRONLY | O_CREAT, 0600), STDOUT_FILENO);
      dup2(open(err.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
      exec_program(arguments);
    }
    int status = 0;
    while (!begun() && waitpid(child, &status, WNOHANG) == 0) usleep(20000);
    kill(child, GetParam());
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status)) << text_of(err);
    EXPECT_EQ(WEXITSTATUS(status), 128 + GetParam());
    const std::string word = GetParam() == SIGINT ? "interrupted" : "terminated";
    EXPECT_EQ(text_of(err), "mfs-dae: " + word + "\n");
    read = ordered_json::parse(text_of(report));
    EXPECT_EQ(read["status"], word);
  }
};

// The run would take hours; the signal comes when the first steps are there.
TEST_P(DaeSignal, LeavesWhatIsThere) {
  ordered_json json = ordered_json::parse(text_of(falling()));
  json["end"] = 1e6;
  json["outputs"] = 1000000;
  json["integrator"] = {{"max_step", 1e-3}};
  const std::string model = file("long.json", json.dump());
  const auto lines = [&](const char* table = "out/steps.csv") {
    const std::string text = text_of(path(table));
    return std::count(text.begin(), text.end(), '\n');
  };
  ordered_json json_report;
  ASSERT_NO_FATAL_FAILURE(run_until_signal(
      {"run", model}, [&] { return lines() >= 3; }, json_report));
  EXPECT_EQ(json_report["steps"], lines() - 1);  // each step that was made is in the table
  EXPECT_THAT(text_of(path("stdout")), AllOf(HasSubstr("\nsteps "), HasSubstr("\nParaView ")));
  EXPECT_THAT(text_of(path("out/results.npy")),
              HasSubstr(" " + std::to_string(lines("out/time_series.csv") - 1) + ",), }"));
}

// A block of some thousand nodes falls, so that there is no equilibrium; the signal comes during the search.
TEST_P(DaeSignal, EndsTheSearchForAnEquilibrium) {
  const std::string model = file("block.json", R"({
    "name": "block", "end": 1, "outputs": 1, "gravity": [0, 0, -9.81],
    "materials": {"soft": {"law": "neo_hookean", "young": 1e6, "poisson": 0.3, "density": 1000}},
    "bodies": {"block": {"type": "flexible", "material": "soft", "mesh":
      {"generator": "box", "element": "hex8", "refine": 1, "size": [1, 1, 1], "divisions": [12, 12, 12]}}}})");
  ordered_json json_report;
  const auto begun = [&] { return !text_of(path("out/time_series.csv")).empty(); };
  ASSERT_NO_FATAL_FAILURE(run_until_signal({"static", model}, begun, json_report));
  EXPECT_GE(json_report["iterations"], 1);
  EXPECT_EQ(read_table(path("out/time_series.csv")).at("t [s]").size(), 1U);  // where it was then
}

INSTANTIATE_TEST_SUITE_P(All, DaeSignal, testing::Values(SIGINT, SIGTERM));

TEST_F(DaeProgram, ReportsStaticsAsJson) {
  const auto report = [&](const std::vector<std::string>& arguments) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    const ordered_json json = ordered_json::parse(run.out);  // and nothing else
    EXPECT_EQ(json["status"], "solved");
    EXPECT_EQ(json["name"], "simple_pendulum");
    return json;
  };
  const std::string model = "simple_pendulum", out = path("out");
  EXPECT_LT(report({"static", model, "-o", out, "--json", "-"})["force"], 1e-6);
  EXPECT_FALSE(std::filesystem::exists(out + "/time_series.png"));
  const ordered_json modes = report({"modes", model, "-o", out, "--json", "-"});
  ASSERT_EQ(modes["modes"].size(), 1U);
  EXPECT_NEAR(modes["modes"][0]["frequency"], std::sqrt(9.81) / (2 * std::acos(-1.0)), 1e-5);
  EXPECT_FALSE(std::filesystem::exists(out + "/modes.png"));
  EXPECT_EQ(report({"linearize", model, "-o", out, "--json", "-"})["matrices"].size(), 5U);
  EXPECT_EQ(run_program({"modes", model, "-o", out, "--no-plots"}).out.find("plot"), std::string::npos);
  const std::string failed = path("failed.json");
  complaint({"static", "perpetuum_mobile", "-o", out, "--json", failed}, 3);
  EXPECT_EQ(ordered_json::parse(text_of(failed))["status"], "invalid_input");
}

// The file system takes no more in the middle of the run.
TEST_F(DaeProgram, AFullDiskEndsTheRun) {
  ordered_json json = ordered_json::parse(text_of(falling()));
  json["end"] = 100;
  json["integrator"] = {{"max_step", 1e-2}};
  const std::string model = file("long.json", json.dump());
  const std::string command = std::string("trap '' XFSZ; ulimit -f 64; exec ") + MFS_PROGRAM + " run " +
                              model + " -o " + path("out") + " --json " + path("report.json") +
                              " > /dev/null 2> " + path("stderr");
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_THAT(text_of(path("stderr")), HasSubstr("out/steps.csv: cannot be written: File too large"));
  EXPECT_EQ(ordered_json::parse(text_of(path("report.json")))["status"], "invalid_input");
}

// A bar of 2 kg on a hinge, 0.6 m from its centre: its moment of inertia there is 0.96.
std::string pendulum() {
  return R"({"name": "pendulum", "end": 1, "outputs": 4, "gravity": [0, -9.81, 0], "start": "equilibrium",
    "parameters": {"k": 24, "c": "0.05 * k"},
    "bodies": {"bar": {"type": "rigid", "mass": 2, "inertia": [0.1, 0.24, 0.24], "position": [0.6, 0, 0]}},
    "joints": {"hinge": {"type": "revolute", "a": "ground", "b": "bar", "point": [0, 0, 0], "axis": [0, 0, 1]}},
    "points": {"centre": {"body": "bar", "point": [0.6, 0, 0]}},
    "forces": {"coil": {"type": "rotational_spring", "joint": "hinge", "stiffness": "k", "damping": "c"}}})";
}

TEST_F(DaeProgram, FindsTheEquilibriumAndStartsThere) {
  const std::string model = file("pendulum.json", pendulum());
  const ProgramRun run = run_program({"static", model, "-o", path("rest"), "--set", "k=12"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("equilibrium     pendulum: "), HasSubstr("rest/result.pvd")));
  EXPECT_TRUE(std::filesystem::exists(path("rest/time_series.csv")));
  // Started there it stays there; as given it would begin with g m l^2 / 0.96.
  EXPECT_EQ(run_program({"run", model, "-o", path("out")}).code, 0);
  const Table rest = read_table(path("out/time_series.csv"));
  for (const double a : rest.at("acceleration centre [m/s2]")) EXPECT_NEAR(a, 0, 1e-6);
  ordered_json given = ordered_json::parse(pendulum());
  given["start"] = "as_given";
  EXPECT_EQ(run_program({"run", file("given.json", given.dump()), "-o", path("out")}).code, 0);
  EXPECT_NEAR(read_table(path("out/time_series.csv")).at("acceleration centre [m/s2]")[0],
              9.81 * 2 * 0.36 / 0.96, 1e-6);
  EXPECT_THAT(complaint({"static", falling(), "-o", path("rest")}, 7), HasSubstr("block.z moves most"));
}

TEST_F(DaeProgram, ListsModesAndDrawsThem) {
  const std::string model = file("pendulum.json", pendulum());
  const ProgramRun run = run_program({"modes", model, "-o", path("modes"), "--undamped", "--set", "k=0"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("pendulum, at rest: 1 modes\n"));
  const double frequency = std::sqrt(2 * 9.81 * 0.6 / 0.96) / (2 * std::acos(-1.0));
  const Table table = read_table(path("modes/modes.csv"));
  ASSERT_EQ(table.at("mode").size(), 1U);
  EXPECT_NEAR(table.at("frequency [Hz]")[0], frequency, 1e-7);
  EXPECT_NEAR(table.at("damping_ratio")[0], 0, 1e-12);
  EXPECT_THAT(text_of(path("modes/shapes.mtx")), HasSubstr("array complex general"));
  EXPECT_THAT(text_of(path("modes/mode_001.pvd")), HasSubstr("vtu/mode_001_15.vtu"));
  EXPECT_TRUE(std::filesystem::exists(path("modes/vtu/mode_001_15.vtu")));
  if (run.err.empty()) {
    EXPECT_TRUE(std::filesystem::exists(path("modes/modes.png")));  // where matplotlib is
  }
  // What a longer list left goes.
  for (const char* name : {"mode_002.pvd", "mode_003.pvd", "modes.png"})
    file(std::string("modes/") + name, "of the list before");
  EXPECT_EQ(run_program({"modes", model, "-o", path("modes"), "--no-plots"}).code, 0);
  EXPECT_TRUE(std::filesystem::exists(path("modes/mode_001.pvd")));
  for (const char* name : {"mode_002.pvd", "mode_003.pvd", "modes.png"})
    EXPECT_FALSE(std::filesystem::exists(path("modes/") + name)) << name;
  // 0.96 s^2 + 1.2 s + ... : the real part is that of the damping wherever the bar is.
  EXPECT_EQ(run_program({"modes", model, "-o", path("moving"), "--at", "0.5"}).code, 0);
  EXPECT_NEAR(read_table(path("moving/modes.csv")).at("real [1/s]")[0], -1.2 / (2 * 0.96), 1e-6);
  EXPECT_THAT(complaint({"modes", model, "--set", "q=1"}, 3), HasSubstr("the model has no parameter 'q'"));
  EXPECT_THAT(complaint({"modes", model, "--set", "q"}, 3), HasSubstr("is not NAME=VALUE"));
}

TEST_F(DaeProgram, WritesTheMatricesOfAState) {
  const ProgramRun run = run_program({"linearize", file("pendulum.json", pendulum()), "-o", path("linear")});
  EXPECT_EQ(run.code, 0) << run.err;
  const auto dense = [&](const char* name) { return read_dense(path("linear/") + name); };
  // In the only direction that the constraints leave free: 0.96, 1.2, and 24 - m g l sin(angle).
  const Eigen::VectorXd free = Eigen::FullPivLU<Eigen::MatrixXd>(dense("Phi_q.mtx")).kernel();
  ASSERT_EQ(free.size(), 8);
  const double mass = free.dot(dense("M.mtx") * free),
               angle =
                   std::stod(text_of(path("linear/rows.csv"))
                                 .substr(text_of(path("linear/rows.csv")).find("hinge.angle.value\",") + 19));
  EXPECT_NEAR(24 * angle + 2 * 9.81 * 0.6 * std::cos(angle), 0, 1e-6);
  EXPECT_NEAR(free.dot(dense("D.mtx") * free) / mass, 1.2 / 0.96, 1e-9);
  EXPECT_NEAR(free.dot(dense("K.mtx") * free) / mass, (24 - 2 * 9.81 * 0.6 * std::sin(angle)) / 0.96, 1e-6);
  EXPECT_THAT(text_of(path("linear/rows.csv")),
              HasSubstr("\"joint hinge, equation 5 of 5 (about [0 1 0])\""));
}

TEST_F(DaeProgram, UsageIsCode2) {
  EXPECT_THAT(complaint({}, 2), HasSubstr("subcommand"));
  EXPECT_THAT(complaint({"run", "a.json"}, 2), HasSubstr("-o is required"));
  for (const char* t : {"-1", "nan", "inf", "soon"})
    EXPECT_THAT(complaint({"modes", "a.json", "--at", t}, 2),
                HasSubstr(std::string("--at: ") + t + " is no time"));
  EXPECT_THAT(complaint({"run", "a.json", "-o", path("out"), "--backend", "abacus"}, 2), HasSubstr("abacus"));
  EXPECT_THAT(complaint({"run", "a.json", "-o", path("out"), "--threads", "0"}, 2), HasSubstr("--threads"));
  EXPECT_THAT(complaint({"models", "--refine", "0"}, 2), HasSubstr("--refine"));
  EXPECT_THAT(complaint({"plot"}, 2), HasSubstr("DIR is required"));
}

TEST_F(DaeProgram, InvalidInputIsCode3) {
  EXPECT_THAT(complaint({"check", path("none.json")}, 3), HasSubstr("none.json: cannot be read"));
  EXPECT_THAT(complaint({"check", file("wrong.json", R"({"name": 3})")}, 3),
              HasSubstr("name: must be a text"));
  EXPECT_THAT(complaint({"check", falling(), "--refine", "2"}, 3), HasSubstr("refine: "));
  ordered_json json = ordered_json::parse(kSmallModel);
  json["integrator"]["max_order"] = 6;
  const std::string order = file("order.json", json.dump());
  EXPECT_THAT(complaint({"check", order}, 3), HasSubstr("integrator: max_order: must be 1 ... 5"));
  EXPECT_THAT(complaint({"run", order, "-o", path("never")}, 3), HasSubstr("max_order"));
  EXPECT_FALSE(std::filesystem::exists(path("never")));
  EXPECT_THAT(complaint({"run", falling(), "-o", file("taken", "")}, 3), HasSubstr("taken"));
  EXPECT_THAT(complaint({"run", falling(), "-o", path("out"), "--json", path("no/report.json")}, 3),
              HasSubstr("no/report.json"));
}

TEST_F(DaeProgram, AFailedRunIsReported) {
  // Held at two points that move apart.
  ordered_json json = ordered_json::parse(text_of(falling()));
  for (const char* name : {"left", "right"})
    json["motions"][name] = {{"type", "point"},
                             {"side", "block"},
                             {"point", {0, 0, 0}},
                             {"x", {{"type", "linear"}, {"slope", name[0] == 'l' ? -1 : 1}}}};
  const std::string model = file("torn.json", json.dump());
  const ProgramRun run = run_program({"run", model, "-o", path("out"), "--json", path("report.json")});
  EXPECT_NE(run.code, 0);
  EXPECT_THAT(run.err, HasSubstr("motion"));
  const ordered_json report = ordered_json::parse(text_of(path("report.json")));
  EXPECT_NE(report["status"], "solved");
  EXPECT_THAT(run.err, HasSubstr(report["message"].get<std::string>()));
}

TEST_F(DaeProgram, WhatLeadsNowhereHasAStatusOfItsOwn) {
  ordered_json json = ordered_json::parse(text_of(falling()));
  json["forces"]["push"] = {{"type", "point"}, {"side", "block"}, {"point", {0, 0, 0}}, {"x", "1/(t - 0.5)"}};
  const std::string model = file("pole.json", json.dump()), report = path("report.json");
  EXPECT_THAT(complaint({"run", model, "-o", path("out"), "--no-plots", "--json", report}, 7),
              HasSubstr("; the force on block.x jumps or has a pole"));
  EXPECT_EQ(ordered_json::parse(text_of(report))["status"], "failed");
  complaint({"static", falling(), "-o", path("out"), "--json", report}, 7);
  EXPECT_EQ(ordered_json::parse(text_of(report))["status"], "failed");
}

}  // namespace
