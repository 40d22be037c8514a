// The program mfs-dae from outside: exit codes, standard output and error, files.
#include <filesystem>

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

TEST_F(DaeProgram, ChecksAModel) {
  const ProgramRun check = run_program({"check", file("small.json", kSmallModel)});
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_EQ(check.out,
            "small: 1 flexible and 1 rigid bodies, 264 coordinates, 66 constraints, 858 unknowns\n");
  const ProgramRun coarse = run_program({"check", path("small.json"), "--refine", "1"});
  EXPECT_THAT(coarse.out, HasSubstr(" 81 coordinates,"));
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
}

TEST_F(DaeProgram, UsageIsCode2) {
  EXPECT_THAT(complaint({}, 2), HasSubstr("subcommand"));
  EXPECT_THAT(complaint({"run", "a.json"}, 2), HasSubstr("-o is required"));
  EXPECT_THAT(complaint({"run", "a.json", "-o", path("out"), "--backend", "abacus"}, 2), HasSubstr("abacus"));
  EXPECT_THAT(complaint({"run", "a.json", "-o", path("out"), "--threads", "0"}, 2), HasSubstr("--threads"));
  EXPECT_THAT(complaint({"models", "--refine", "0"}, 2), HasSubstr("--refine"));
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

}  // namespace
