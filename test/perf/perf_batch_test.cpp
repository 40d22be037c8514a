// perf_batch: what it prints, and what it refuses.
#include <gmock/gmock.h>

#include "test/perf/shell.hpp"

namespace {

using testing::HasSubstr;

const std::string kBatch = MFS_BUILD "/bin/perf_batch ";

TEST(PerfBatch, SolversSolveAllSystemsInEachRound) {
  const ProgramRun run =
      shell(kBatch + "--count 21 --rounds 2 --threads 2 --backends openmp,serial chain:3 poisson2d:5");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::vector<nlohmann::json> lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 12u);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i]["case"], i < 6 ? "chain:3" : "poisson2d:5");
    EXPECT_EQ(lines[i]["n"], i < 6 ? 35 : 25);
    EXPECT_EQ(lines[i]["solver"], (std::vector<std::string>{"mfs openmp", "mfs serial", "klu"})[i % 6 / 2]);
    EXPECT_EQ(lines[i]["round"], i % 2 + 1);
    EXPECT_EQ(lines[i]["failed"], 0);
    EXPECT_GT(lines[i]["us"], 0);
    EXPECT_GT(lines[i]["analysis_ms"], 0);
    EXPECT_LT(lines[i]["backward_error"], i % 6 < 4 ? 1.01e-12 : 1e-8);
  }
}

// Of 100 unknowns as one leaf, and of small ones.
TEST(PerfBatch, TellsDetailsOfTheAnalysis) {
  const std::string command = kBatch + "--count 3 --rounds 1 --without-klu --details poisson2d:10";
  const ProgramRun usual = shell(command), leaves = shell(command + " --leaf-size 5");
  EXPECT_THAT(usual.err, HasSubstr("list: "));
  EXPECT_THAT(leaves.err, HasSubstr(" factor entries"));
  EXPECT_NE(usual.err, leaves.err);
}

TEST(PerfBatch, SaysWhatCannotBe) {
  const ProgramRun unknown = shell(kBatch + "--count 3 --backends abacus --without-klu chain:3");
  EXPECT_EQ(unknown.code, 1);
  EXPECT_THAT(unknown.out, HasSubstr("there is no abacus"));
  const ProgramRun short_chain = shell(kBatch + "--count 3 chain:1");
  EXPECT_EQ(short_chain.code, 2);
  EXPECT_THAT(short_chain.err, HasSubstr("two bodies"));
  EXPECT_EQ(shell(kBatch + "--count 0 chain:3").code != 0, true);
}

}  // namespace
