// perf_device on the host: what it prints, and what it refuses.
#include <gmock/gmock.h>

#include "test/perf/shell.hpp"

namespace {

using testing::HasSubstr;

const std::string kDevice = MFS_BUILD "/bin/perf_device ";

TEST(PerfDevice, EveryFigureOfACaseAsOneLine) {
  const ProgramRun run = shell(kDevice + "--backend openmp --threads 2 --repeat 2 elas3d:5 kkt:4");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["case"], "elas3d:5");
  EXPECT_EQ(lines[0]["n"], 375);
  EXPECT_EQ(lines[1]["case"], "kkt:4");
  for (const nlohmann::json& line : lines) {
    EXPECT_EQ(line["solver"], "mfs");
    EXPECT_EQ(line["status"], "solved") << line["message"];
    EXPECT_EQ(line["threads"], 2);
    EXPECT_EQ(line["repeat"], 2);
    EXPECT_EQ(line["vectors"], "host");
    EXPECT_EQ(line["bitwise_equal"], true);
    EXPECT_EQ(line["accurate"], true);
    for (const char* key : {"analysis_s", "reorder_s", "symbolic_s", "first_factor_s", "refactor_s",
                            "refactor_median_s", "solve_1_s", "solve_1_median_s", "solve_16_s",
                            "solve_16_median_s", "step_s", "step_median_s", "factor_entries", "flops"})
      EXPECT_GT(line[key].get<double>(), 0) << key;
    for (const char* key : {"backward_error_1", "backward_error_16", "residual_1", "residual_16"})
      EXPECT_LE(line[key].get<double>(), 1e-12) << key;
    EXPECT_LE(line["refactor_s"].get<double>(), line["refactor_median_s"].get<double>());
  }
}

TEST(PerfDevice, RoundsTakeTurns) {
  const ProgramRun run = shell(kDevice + "--backend openmp --repeat 1 --rounds 2 poisson2d:8");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["round"], 1);
  EXPECT_EQ(lines[1]["round"], 2);
}

TEST(PerfDevice, BackendsTakeTurns) {
  const ProgramRun run = shell(kDevice + "--backend openmp,kokkos --repeat 1 poisson2d:8");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0]["backend"], "openmp");
  EXPECT_EQ(lines[1]["backend"], "kokkos");
}

TEST(PerfDevice, RefusesWhatItCannotRun) {
  ProgramRun run = shell(kDevice + "--backend openmp poisson2d:8 poisson2d:ten");
  EXPECT_EQ(run.code, 2);
  EXPECT_EQ(run.out, "");  // before any work
  EXPECT_THAT(run.err, HasSubstr("poisson2d:ten"));
  run = shell(kDevice + "--backend openmp,host poisson2d:8");
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("'host'"));
  run = shell(kDevice + "--backend openmp nothing:3");
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("nothing:3"));
  run = shell(kDevice + "--backend openmp --cudss /nonexistent poisson2d:8");
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("cuDSS"));
  EXPECT_NE(shell(kDevice + "--repeat 0 poisson2d:8").code, 0);
}

TEST(PerfDevice, AFailedCaseIsALineAndAnExitCode) {
  // No GPU in reach, if there is one.
  const ProgramRun run = shell("CUDA_VISIBLE_DEVICES= " + kDevice + "--backend cuda --repeat 1 poisson2d:8");
  EXPECT_EQ(run.code, 1);
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0]["status"], "failed");
  EXPECT_THAT(lines[0]["message"].get<std::string>(), HasSubstr("CUDA"));
  EXPECT_FALSE(lines[0].contains("refactor_s"));
}

}  // namespace
