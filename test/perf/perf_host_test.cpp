// perf_host, with a library that stands in for PARDISO's: what it prints, and what it refuses.
#include <gmock/gmock.h>

#include <map>

#include "test/perf/shell.hpp"

namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kHost = MFS_BUILD "/bin/perf_host ";
const std::string kStub = "--pardiso " MFS_STUB_PARDISO " ";

std::vector<std::string> solvers(const std::vector<nlohmann::json>& lines) {
  std::vector<std::string> names;
  for (const nlohmann::json& line : lines) {
    if (line.contains("solver")) names.push_back(line["solver"]);
  }
  return names;
}

TEST(PerfHost, TakesChainsOfBodies) {
  const ProgramRun run = shell(kHost + "--peers klu --repeat 1 --rounds 1 chain:3 chain:2");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0]["case"], "chain:3");
  EXPECT_EQ(lines[0]["n"], 35);
  EXPECT_EQ(lines[0]["accurate"], true);
  EXPECT_EQ(lines[3]["n"], 24);
  EXPECT_EQ(shell(kHost + "--peers klu chain:1").code, 2);
}

TEST(PerfHost, SolversTakeTurnsAndRatiosHaveTheirSpread) {
  const ProgramRun run = shell(kHost + kStub + "--peers umfpack,klu --repeat 1 --rounds 3 poisson2d:6");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 3u * 4 + 3);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(lines[i]["solver"], (std::vector<std::string>{"mfs", "umfpack", "klu", "pardiso"})[i % 4]);
    EXPECT_EQ(lines[i]["round"], i / 4 + 1);
    EXPECT_EQ(lines[i]["status"], "solved") << lines[i]["message"];
    EXPECT_EQ(lines[i]["accurate"], true) << lines[i]["solver"];
    EXPECT_GT(lines[i]["factor_entries"], 0) << lines[i]["solver"];
  }
  for (std::size_t i = 12; i < 15; ++i) {
    const nlohmann::json& line = lines[i];
    EXPECT_EQ(line["ratio"], "mfs/" + lines[i - 11]["solver"].get<std::string>());
    EXPECT_EQ(line["rounds"], 3);
    for (const std::string phase : {"analysis", "first_factor", "refactor", "solve_1", "solve_16", "step"}) {
      std::vector<double> expected;
      for (std::size_t round = 0; round < 3; ++round)
        expected.push_back(lines[4 * round][phase + "_s"].get<double>() /
                           lines[4 * round + i - 11][phase + "_s"].get<double>());
      std::sort(expected.begin(), expected.end());
      EXPECT_THAT((std::vector<double>{line[phase + "_least"], line[phase], line[phase + "_most"]}),
                  testing::Pointwise(testing::DoubleNear(1e-9 * expected[2]), expected))
          << phase;
    }
  }
}

TEST(PerfHost, SolversThatNeedItAreRefined) {
  const ProgramRun run =
      shell("STUB_PARDISO=wrong " + kHost + kStub + "--peers klu --repeat 1 --rounds 1 kkt:2");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  EXPECT_THAT(solvers(lines), ElementsAre("mfs", "klu", "pardiso"));
  EXPECT_EQ(lines[2]["refinement_steps"], 2);
  EXPECT_EQ(lines[2]["accurate"], true);
}

// SuperLU and MUMPS are measured where they were found.
TEST(PerfHost, OthersOfDebianSolve) {
  const std::string help = shell(kHost + "--help").out;
  for (const std::string name : {"superlu", "mumps"}) {
    SCOPED_TRACE(name);
    const ProgramRun run = shell(kHost + "--peers " + name + " --repeat 2 --rounds 1 kkt:3 convdiff3d:4");
    if (help.find(name) == std::string::npos) {
      EXPECT_NE(run.code, 0);
      continue;
    }
    ASSERT_EQ(run.code, 0) << run.err;
    const std::vector<nlohmann::json> lines = json_lines(run.out);
    ASSERT_EQ(lines.size(), 6u);
    for (const std::size_t i : {1, 4}) {
      EXPECT_EQ(lines[i]["solver"], name);
      EXPECT_EQ(lines[i]["accurate"], true) << lines[i].dump();
      EXPECT_GT(lines[i]["factor_entries"], 0);
      EXPECT_GT(lines[i]["flops"], 0);
      EXPECT_LT(lines[i]["flops"], 10 * lines[i - 1]["flops"].get<double>()) << "those of one factorization";
    }
    const TemporaryFolder folder;
    const std::string singular = folder.write(
        "singular.mtx", "%%MatrixMarket matrix coordinate real general\n2 2 4\n1 1 1\n1 2 1\n2 1 1\n2 2 1\n");
    const std::vector<nlohmann::json> refused =
        json_lines(shell(kHost + "--peers " + name + " --repeat 1 --rounds 1 " + singular).out);
    ASSERT_EQ(refused.size(), 2u);
    EXPECT_NE(refused[1].value("accurate", false), true) << refused[1].dump();
  }
}

TEST(PerfHost, PardisoAloneMayStandBeside) {
  const ProgramRun run = shell(kHost + kStub + "--repeat 1 --rounds 1 --peers none poisson2d:5");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(solvers(json_lines(run.out)), ElementsAre("mfs", "pardiso"));
}

TEST(PerfHost, ASolverThatFailsHasNoRatio) {
  const ProgramRun run =
      shell("STUB_PARDISO=fails " + kHost + kStub + "--peers klu --repeat 1 --rounds 1 poisson2d:5");
  EXPECT_EQ(run.code, 1);
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[2]["status"], "failed");
  EXPECT_EQ(lines[2]["message"], "PARDISO: error -4 in phase 22");
  EXPECT_EQ(lines[3]["ratio"], "mfs/klu");
}

TEST(PerfHost, RefusesWhatItCannotRun) {
  ProgramRun run = shell(kHost + "--pardiso /no/such/library.so poisson2d:5");
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("/no/such/library.so"));
  run = shell(kHost + "poisson2d:5 poisson2d:ten");
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.out, "");  // before any work
  EXPECT_THAT(run.err, HasSubstr("poisson2d:ten"));
  run = shell(kHost + "--peers another poisson2d:5");
  EXPECT_NE(run.code, 0);
  EXPECT_EQ(run.out, "");
}

TEST(PerfHost, TheScriptFindsWhatItIsToldOf) {
  const std::string script = "PERF_HOST=" MFS_BUILD "/bin/perf_host ";
  ProgramRun run = shell(script + "MKL_RT=" MFS_STUB_PARDISO " " MFS_SCRIPTS
                                  "/host --peers klu --repeat 1 --rounds 1 poisson2d:5");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(solvers(json_lines(run.out)), ElementsAre("mfs", "klu", "pardiso"));
  run = shell(script + "MKL_RT= " MFS_SCRIPTS "/host --peers klu --repeat 1 --rounds 1 poisson2d:5");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(solvers(json_lines(run.out)), ElementsAre("mfs", "klu"));
  EXPECT_THAT(run.err, HasSubstr("PARDISO is not measured"));
  run = shell("PERF_HOST=/no/such/program " MFS_SCRIPTS "/host");
  EXPECT_EQ(run.code, 2);
}

}  // namespace
