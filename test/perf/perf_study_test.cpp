// perf/study: what it measures, that it sees solutions which differ, and what it tells a device's backend.
#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>

#include "test/perf/shell.hpp"

namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kStudy = MFS_SCRIPTS "/study ";
const std::string kPrograms = MFS_BUILD "/bin";

bool has_matplotlib() {
  return shell("/usr/bin/python3 -c 'import matplotlib'").code == 0;
}

// A folder of programs in which `mfs bench` is this line of shell, with the arguments in "$@". `mfs info`
// lists two backends.
class FakePrograms {
 public:
  explicit FakePrograms(const std::string& bench) {
    add("mfs", "if [ \"$1\" = info ]; then echo 'backends  serial, openmp'; exit 0; fi\n" + bench);
  }
  void add(const std::string& name, const std::string& shell) {
    const std::string path = folder_.write(name, "#!/bin/bash\n" + shell + "\n");
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }
  std::string option() const { return " --bin " + folder_.path("") + " "; }
  std::string path(const std::string& name) const { return folder_.path(name); }

 private:
  TemporaryFolder folder_;
};

const std::string kSolved =
    R"({"name": "a", "n": 2, "backend": "cuda", "threads": 1, "nnz_factor": 4, "flops": 8e9, "bytes_peak": 1000, )"
    R"("time_factor": 2, "time_refactor": 1, "time_solve": 0.5, "backward_error": 1e-16, "condition": 10, )"
    R"("status": "solved", "message": ""})";

// The sums over fronts are those that the solver itself makes of its plan, divided and undivided.
TEST(Study, OperationsAreThoseOfTheSolver) {
  const TemporaryFolder folder;
  const std::string kept = folder.path("flops.jsonl");
  const ProgramRun run = shell(kStudy + "flops --sizes 7,30 kkt:5 poisson2d:12 --json " + kept);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| kkt:5 | 450 | undivided |"));
  const std::vector<nlohmann::json> lines = json_lines(text_of(kept));
  ASSERT_EQ(lines.size(), 6u);
  for (const nlohmann::json& line : lines) {
    const ProgramRun solved =
        shell(kPrograms + "/mfs bench --json - --max-block " + std::to_string(line["block"].get<int>()) +
              " " + line["case"].get<std::string>());
    const nlohmann::json expected = json_lines(solved.out).at(0);
    for (const char* key : {"flops_getrf", "flops_trsm", "flops_gemm", "nnz_factor"})
      EXPECT_EQ(line[key].get<double>(), expected[key].get<double>()) << line << key;
  }
}

TEST(Study, BlocksBesidePeers) {
  const TemporaryFolder folder;
  const std::string kept = folder.path("blocks.jsonl");
  const ProgramRun run = shell(
      kStudy + "blocks --sizes 4,64 --refactor 1 --threads 1 --peers cholmod,umfpack elas3d:4 kkt:4 --json " +
      kept);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("| elas3d:4 | openmp, 4 |"), HasSubstr("| elas3d:4 | cholmod |"),
                    HasSubstr("| kkt:4 | cholmod | failed: CHOLMOD: the matrix is not symmetric |")));
  const std::vector<nlohmann::json> lines = json_lines(text_of(kept));
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_LT(lines[0]["flops_getrf"].get<double>(), lines[1]["flops_getrf"].get<double>());
  for (const nlohmann::json& line : lines) {
    if (line["status"] != "solved") continue;
    EXPECT_GT(line["time_refactor"].get<double>(), 0) << line;
    EXPECT_GT(line["bytes_process"].get<double>(), line["bytes_peak"].get<double>()) << line;
    EXPECT_LE(line["backward_error"].get<double>(), 1e-12) << line;
  }
}

// The blocks of a device are its own: no size is asked for, but memory limits as parts of what all factors
// take.
TEST(Study, ADeviceHasLimitsInsteadOfBlocks) {
  const FakePrograms fake("echo \"$@\" >>$(dirname $0)/calls; echo '" + kSolved + "'");
  const ProgramRun run = shell(kStudy + "blocks --backend cuda --partial 0.5,0.1 a.mtx" + fake.option());
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("| a | cuda, FULL | 1 s | 500 ms | 8 Gflop | 8 Gflop/s |"),
                             HasSubstr("| a | cuda, PARTIAL at 0.5 of FULL |")));
  const std::string calls = text_of(fake.path("calls"));
  EXPECT_THAT(calls, AllOf(HasSubstr("--memory-limit 500 "), HasSubstr("--memory-limit 100 "),
                           Not(HasSubstr("--max-block"))));
}

// Every product is in one of the bins, and rates of the machine go along.
TEST(Study, SizesOfProducts) {
  const TemporaryFolder folder;
  const std::string kept = folder.path("sizes.jsonl");
  const std::string rates = folder.write(
      "rates.json",
      R"({"format": 1, "rates": [{"processor": "p", "blas": "b", "backend": "openmp", "threads": 2, )"
      R"("date": "2026-11-25", "fronts": [{"size": 8, "flops_per_second": 1e9, "entries_per_second": 1e8}]}]})");
  ProgramRun run = shell(kStudy + "sizes --sizes 3 elas3d:5 --rates " + rates + " --json " + kept);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| elas3d:5 | 375 | 3 |"));
  const std::vector<nlohmann::json> lines = json_lines(text_of(kept));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1]["rates"]["fronts"][0]["size"], 8);
  const nlohmann::json solved =
      json_lines(shell(kPrograms + "/mfs bench elas3d:5 --max-block 3 --json -").out).at(0);
  double flops = 0, last = 0;
  for (const nlohmann::json& bin : lines[0]["products"]) {
    EXPECT_GT(bin[0].get<double>(), last);
    last = bin[0];
    flops += bin[1].get<double>();
  }
  EXPECT_EQ(flops, solved["flops_gemm"].get<double>());
  // A product of width 3 and the largest rest behind it is in the last bin.
  const double rest = solved["max_front"].get<double>() - 3, largest = std::cbrt(3 * rest * rest);
  EXPECT_LE(last, largest * (1 + 1e-9));
  EXPECT_GT(last * 1.7, largest);  // a step of the bins, and a width of 2
  run = shell(kStudy + "sizes elas3d:4 --rates " + folder.path("none.json"));
  EXPECT_EQ(run.code, 0) << run.err;
}

TEST(Study, BackendsAgree) {
  const ProgramRun run = shell(kStudy + "backends --refactor 1 --threads 1 elas3d:5 kkt:4");
  ASSERT_EQ(run.code, 0) << run.err;
  for (const std::string backend : {"serial, 1", "openmp, 1", "kokkos, 1"})
    EXPECT_THAT(run.out,
                AllOf(HasSubstr("| elas3d:5 | " + backend + " |"), HasSubstr("| kkt:4 | " + backend + " |")));
}

// Each writes its solution: with a condition of 10 and errors of 1e-16 they may differ by some 1e-14.
std::string solution_of(const std::string& difference) {
  return R"(for word in "$@"; do case "$word" in */x.mtx) target=$word;; serial) d=0;; openmp) d=)" +
         difference +
         ";; esac; done; printf '%%%%MatrixMarket matrix array real general\n2 1\n1.0\n%s\n' 1.$d >$target; "
         "echo '" +
         kSolved + "'";
}

TEST(Study, SolutionsThatDifferAreAFault) {
  const FakePrograms near(solution_of("000000000000001")), far(solution_of("0000000001"));
  ProgramRun run = shell(kStudy + "backends a.mtx" + near.option());
  EXPECT_EQ(run.code, 0) << run.err;
  run = shell(kStudy + "backends a.mtx" + far.option());
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("solution 5.0e-11 from the first one's"));
}

TEST(Study, ABackendThatFailsIsAFault) {
  const FakePrograms fake(
      R"(echo '{"name": "a", "backend": "serial", "threads": 1, "status": "singular", "message": "row 3"}'; exit 4)");
  const ProgramRun run = shell(kStudy + "backends a.mtx" + fake.option());
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("a, serial: singular: row 3"));
}

// Two kernels that overlap are at work for 0.8 s of 1, a copy of 100 bytes for 0.4 s, half of it beside them.
TEST(Study, TimelineOfKernelsAndCopies) {
  const TemporaryFolder folder;
  FakePrograms fake("");
  const std::string phase =
      R"({"seconds": 1, "activities": [["kernel", 0, 0.5, 0], ["out", 0.6, 1.0, 100], ["kernel", 0.4, 0.8, 0]]})";
  fake.add(
      "perf_timeline",
      R"(limit=0; for word in "$@"; do [ "$last" = --memory-limit ] && limit=$word; last=$word; done; echo '{"case": "a", )"
      R"("limit": '$limit', "device_bytes": 4000, "segments": 3, "refactor": )" +
          phase + R"(, "solve": {"seconds": 2, "activities": [["kernel", 1, 2, 0]]}}')");
  const std::string kept = folder.path("timeline.jsonl"), png = folder.path("timeline.png");
  ProgramRun run = shell(kStudy + "timeline a.mtx --partial 0.5 --json " + kept + fake.option());
  ASSERT_EQ(run.code, 0) << run.err;
  for (const std::string memory : {"FULL", "50%"}) {
    EXPECT_THAT(run.out,
                AllOf(HasSubstr("| a | " + memory +
                                " | 4 kB | 3 | refactor | 1 s | 80% | 100 B | 250 B/s | 50% | 0 B | - | - |"),
                      HasSubstr("| a | " + memory + " | 4 kB | 3 | solve | 2 s | 50% | 0 B | - | - |")));
  }
  EXPECT_EQ(json_lines(text_of(kept)).at(1)["limit"], 2000);
  if (!has_matplotlib()) return;
  run = shell(kStudy + "timeline --from " + kept + " --png " + png);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(text_of(png).substr(1, 3), "PNG");
}

TEST(Study, RefusesWhatIsNotThere) {
  ProgramRun run = shell(kStudy + "flops nothing:3");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("nothing:3"));
  run = shell(kStudy + "flops elas3d:3 --bin /nonexistent");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("/nonexistent/perf_fronts is not there"));
  EXPECT_EQ(shell(kStudy + "flops").code, 1);
  EXPECT_EQ(shell(kStudy + "colours elas3d:3").code, 2);
}

// Lines that were kept on another machine are shown and drawn here.
TEST(Study, Pictures) {
  if (!has_matplotlib()) GTEST_SKIP() << "python3-matplotlib is not there";
  const TemporaryFolder folder;
  const auto draw = [&](const std::string& study, const std::string& arguments) {
    const std::string kept = folder.path(study + ".jsonl"), png = folder.path(study + ".png");
    ASSERT_EQ(shell(kStudy + study + " elas3d:4 poisson2d:9 " + arguments + " --json " + kept).code, 0);
    const ProgramRun run = shell(kStudy + study + " --from " + kept + " --png " + png);
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(text_of(png).substr(1, 3), "PNG");
    EXPECT_THAT(run.out, HasSubstr("poisson2d:9"));
  };
  draw("flops", "");
  draw("blocks", "--sizes 8,64 --refactor 1 --peers umfpack");
  draw("backends", "--refactor 1 --backend serial,openmp");
  draw("sizes", "");
}

// 1 / step^2 of the mass and the constraints on both sides make a system that is solved.
TEST(Study, NewtonMatrixOfAModel) {
  if (!std::filesystem::exists(kPrograms + "/mfs-dae")) GTEST_SKIP() << "mfs-dae is not built";
  if (shell("/usr/bin/python3 -c 'import scipy'").code != 0) GTEST_SKIP() << "python3-scipy is not there";
  const ProgramRun run = shell(kStudy + "backends --backend openmp --refactor 1 bell_crank:1");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| bell_crank_1 | openmp"));
}

}  // namespace
