// The scripts of perf: the folder that is carried, and the table of depths.
#include <gmock/gmock.h>

#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "test/perf/shell.hpp"

namespace {

using testing::HasSubstr;

const std::string kScripts = MFS_SCRIPTS "/";

// Two depths: half the rate of products at the root, twice the time of the copies below it.
const std::string kDepths =
    R"({"case": "a:1", "depth": 1, "fronts": 2, "gflop": 0.1, "gbyte": 4.2, "most_pivots": 64, "ms": 2.024, )"
    R"("largest_ms": 0, "small_ms": 2.024, "assemble_ms": 0, "diagonal_ms": 0, "strips_ms": 0, "products_ms": 0, )"
    R"("roots_ms": 0, "exchange_ms": 0, "update_ms": 0, "inverses_ms": 0}
{"case": "a:1", "depth": 0, "fronts": 1, "gflop": 500, "gbyte": 0.1, "most_pivots": 100, "ms": 20.048, )"
    R"("largest_ms": 0, "small_ms": 0, "assemble_ms": 0, "diagonal_ms": 0.048, "strips_ms": 0, "products_ms": 20, )"
    R"("roots_ms": 0, "exchange_ms": 0, "update_ms": 0, "inverses_ms": 0}
{"case": "a:1", "depth": "all", "fronts": 3, "gflop": 500.1, "gbyte": 4.3, "most_pivots": 100, "ms": 22.072, )"
    R"("largest_ms": 0, "small_ms": 2.024, "assemble_ms": 0, "diagonal_ms": 0.048, "strips_ms": 0, "products_ms": 20, )"
    R"("roots_ms": 0, "exchange_ms": 0, "update_ms": 0, "inverses_ms": 0}
)";

TEST(PlotDepths, TableWithFloor) {
  const TemporaryFolder folder;
  const ProgramRun run = shell(kScripts + "plot_depths " + folder.write("depths.jsonl", kDepths));
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("### a:1"));
  EXPECT_THAT(run.out, HasSubstr("| small ms | products ms |\n"));  // the rest is below one percent
  EXPECT_THAT(run.out, HasSubstr("\n| 0 | 1 | 100 | 500 | 0.1 | 20.048 | 90.8% | 24.94 | 10.024 | 2.0 |"));
  EXPECT_THAT(run.out, HasSubstr("\n| 1 | 2 | 64 | 0.1 | 4.2 | 2.024 | 9.2% | 0.05 | 1.012 | 2.0 |"));
  EXPECT_THAT(run.out,
              HasSubstr("\n| all | 3 | 100 | 500.1 | 4.3 | 22.072 | 100.0% | 22.66 | 11.036 | 2.0 |"));
}

TEST(PlotDepths, OtherCards) {
  const TemporaryFolder folder;
  const ProgramRun run = shell(kScripts + "plot_depths --tflops 25 --tbytes 2.1 --panel-us 24 --case a:1 " +
                               folder.write("depths.jsonl", kDepths));
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| 24.94 | 20.048 | 1.0 |"));
  EXPECT_THAT(run.out, HasSubstr("| 0.05 | 2.024 | 1.0 |"));
}

TEST(PlotDepths, RefusesWhatItCannotRead) {
  const TemporaryFolder folder;
  ProgramRun run = shell(kScripts + "plot_depths --case b:2 " + folder.write("depths.jsonl", kDepths));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("b:2"));
  run =
      shell(kScripts + "plot_depths " + folder.write("old.jsonl", R"({"case": "a:1", "depth": 0, "ms": 1})"));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("this version of perf_depths"));
}

TEST(PlotDepths, Plot) {
  if (shell("/usr/bin/python3 -c 'import matplotlib'").code != 0)
    GTEST_SKIP() << "python3-matplotlib is not there";
  const TemporaryFolder folder;
  const std::string png = folder.path("depths.png");
  const ProgramRun run =
      shell(kScripts + "plot_depths --png " + png + " " + folder.write("depths.jsonl", kDepths));
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(text_of(png).substr(1, 3), "PNG");
}

// Of all matrices of a run: a fifth case comes below the first, instead of making the picture wider.
TEST(PlotDepths, PlotOfManyCases) {
  if (shell("/usr/bin/python3 -c 'import matplotlib'").code != 0)
    GTEST_SKIP() << "python3-matplotlib is not there";
  const TemporaryFolder folder;
  const auto size_of_plot = [&](int cases) {
    std::string lines;
    for (int i = 1; i <= cases; ++i)
      lines += std::regex_replace(kDepths, std::regex("a:1"), "a:" + std::to_string(i));
    const std::string png = folder.path("depths.png");
    const ProgramRun run =
        shell(kScripts + "plot_depths --png " + png + " " + folder.write("depths.jsonl", lines));
    EXPECT_EQ(run.code, 0) << run.err;
    // The header: width and height, four bytes each, the first of them for sizes that no plot has.
    const std::string header = text_of(png).substr(16, 8);
    const auto byte = [&](int i) { return static_cast<unsigned char>(header[i]); };
    return std::pair{byte(2) * 256 + byte(3), byte(6) * 256 + byte(7)};
  };
  const auto [width_of_4, height_of_4] = size_of_plot(4);
  const auto [width_of_5, height_of_5] = size_of_plot(5);
  EXPECT_EQ(width_of_5, width_of_4);
  EXPECT_EQ(height_of_5, 2 * height_of_4);
}

// Two rounds of one case, of MFS and a peer, as perf_device writes them.
std::string device_lines(double refactor) {
  const auto line = [](const std::string& solver, double refactor_s) {
    return R"({"case": "a:1", "solver": ")" + solver +
           R"(", "backend": "cuda", "threads": 4, "status": "solved", )" +
           R"("message": "", "device_bytes": 12e9, "solve_1_s": 2e-4, "refactor_s": )" +
           std::to_string(refactor_s) + "}\n";
  };
  return line("mfs", refactor) + line("peer", 0.5) + line("mfs", 2 * refactor) +
         R"({"case": "a:1", "ratio": "mfs/peer"})" + "\n";
}

TEST(Compare, RecordsTakeTheLeastOfRoundsAndTablesTheRatio) {
  const TemporaryFolder folder;
  const std::string raw = folder.write("raw.jsonl", device_lines(0.25));
  const std::string records = folder.path("records.jsonl");
  ASSERT_EQ(shell(kScripts + "compare --record card --commit abc " + raw + " >" + records).code, 0);
  ProgramRun run =
      shell(kScripts + "compare --table --columns refactor,solve_1,device_bytes,nothing " + records);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| a:1, cuda, 4 | 250 ms (0.50) | 200 us (1.00) | 1.2e+10 (1.00) |  |\n"));
  EXPECT_THAT(run.out, testing::Not(HasSubstr("peer")));
}

// perf_host does not say where its solvers run: on threads of the host.
TEST(Compare, TakesWhatPerfHostWrites) {
  const TemporaryFolder folder;
  const std::string raw = folder.write(
      "raw.jsonl", shell(MFS_BUILD "/bin/perf_host --repeat 1 --rounds 2 --peers klu poisson2d:5").out);
  const std::string records = folder.path("records.jsonl");
  ASSERT_EQ(shell(kScripts + "compare --record host " + raw + " >" + records).code, 0);
  const ProgramRun run = shell(kScripts + "compare --table --columns n " + records);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("| poisson2d:5, openmp, 1 | 25 (1.00) |\n"));
}

TEST(Compare, NamesWhatGotSlower) {
  const TemporaryFolder folder;
  const auto records = [&folder](const std::string& name, const std::string& machine, double refactor) {
    const std::string raw = folder.write(name + ".raw", device_lines(refactor));
    EXPECT_EQ(shell(kScripts + "compare --record " + machine + " " + raw + " >" + folder.path(name)).code, 0);
    return folder.path(name);
  };
  const std::string old = records("old", "card", 0.1);
  const std::string slower = records("slower", "card", 0.103);
  ProgramRun run = shell(kScripts + "compare " + old + " " + slower);
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_THAT(run.out, HasSubstr("a:1 mfs cuda 4: refactor: 100 ms -> 103 ms, +3.0%"));
  EXPECT_EQ(shell(kScripts + "compare --slower 4 " + old + " " + slower).code, 0);
  EXPECT_EQ(shell(kScripts + "compare " + slower + " " + old).code, 0);
  run = shell(kScripts + "compare " + old + " " + records("elsewhere", "other", 0.1));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("no machine, case, solver"));
}

TEST(Compare, RefusesWhatIsNoRecordOrFailed) {
  const TemporaryFolder folder;
  const std::string raw = folder.write("raw.jsonl", device_lines(0.1));
  ProgramRun run = shell(kScripts + "compare " + raw + " " + raw);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("not a record"));
  run =
      shell(kScripts + "compare --record card " +
            folder.write("failed.jsonl",
                         R"({"case": "a:1", "solver": "peer", "status": "failed", "message": "no device"})"));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("a:1: failed: no device"));
  run = shell(kScripts + "compare --record card " + folder.write("cut.jsonl", R"({"case": )"));
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("cut.jsonl: line 1"));
}

// The keys that records need are those that the three programs write.
TEST(Compare, RecordsOfRuns) {
  const TemporaryFolder folder;
  const std::string lines = folder.path("lines");
  const ProgramRun run =
      shell(MFS_BUILD "/bin/perf_device --backend openmp --repeat 1 poisson2d:8 >" + lines +
            " && " MFS_BUILD "/bin/mfs bench poisson2d:8 --refactor 1 --json - >>" + lines + " && " +
            kScripts + "compare --record host " + lines);
  ASSERT_EQ(run.code, 0) << run.err;
  const auto records = json_lines(run.out);
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0]["benchmark"], "device");
  EXPECT_EQ(records[1]["benchmark"], "bench");
  for (const auto& record : records) EXPECT_GT(record["seconds"]["refactor"], 0);
}

TEST(PackDevice, AFolderThatRunsByItself) {
  const TemporaryFolder folder;
  const std::string packed = folder.path("device");
  ASSERT_EQ(shell(kScripts + "pack_device --build " MFS_BUILD " " + packed).code, 0);
  const std::string run_there =
      "env -i PATH=/usr/bin:/bin TMPDIR=" + folder.path("") + " " + packed + "/device ";
  for (int again = 0; again < 2; ++again) {
    const ProgramRun run = shell(run_there + "--backend openmp --repeat 1 poisson2d:8");
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(json_lines(run.out).at(0)["status"], "solved");
  }
  const ProgramRun libraries = shell("ls " + folder.path("") + "/mfs-device-*/lib");
  EXPECT_THAT(libraries.out, HasSubstr("libmfs.so"));
  EXPECT_THAT(libraries.out, testing::Not(HasSubstr("libc.so")));
  EXPECT_THAT(shell(run_there + "--program mfs info").out, HasSubstr("Kokkos"));
  const ProgramRun missing = shell(run_there + "--program nothing");
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(missing.err, HasSubstr("nothing"));
}

TEST(PackDevice, SaysThatNothingIsBuilt) {
  const TemporaryFolder folder;
  const ProgramRun run =
      shell(kScripts + "pack_device --build " + folder.path("") + " " + folder.path("device"));
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("build it first"));
}

TEST(PackDevice, SaysHowItIsCalled) {
  const ProgramRun run = shell(kScripts + "pack_device --help");
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.out, HasSubstr("pack_device [--build"));
}

TEST(EngineeringCases, AreSolved) {
  if (shell("python3 -c 'import scipy.sparse'").code != 0) GTEST_SKIP() << "no scipy";
  const TemporaryFolder folder;
  const std::vector<std::string> names{
      "curl_curl_10", "curl_curl_12", "curl_curl_14", "shell",    "incompressible", "darcy",
      "penalties",    "oseen",        "lattice",      "skew",     "feeders",        "network",
      "strip",        "ring",         "blocks",       "triangle", "transport",      "given_values"};
  std::string cases;
  for (const std::string& name : names) cases += " " + name + ":5";
  ProgramRun run = shell(kScripts + "engineering_cases " + folder.path("made") + cases);
  ASSERT_EQ(run.code, 0) << run.err;
  for (const std::string& name : names) {
    const std::string file = folder.path("made/" + name + ".petsc");
    EXPECT_THAT(run.out, HasSubstr(file));
    const ProgramRun solved = shell(MFS_BUILD "/bin/mfs solve " + file + " --threads 1");
    EXPECT_EQ(solved.code, 0) << name << ": " << solved.err;
  }
}

TEST(EngineeringCases, RefuseUnknownNames) {
  if (shell("python3 -c 'import scipy.sparse'").code != 0) GTEST_SKIP() << "no scipy";
  const TemporaryFolder folder;
  const ProgramRun run = shell(kScripts + "engineering_cases " + folder.path("made") + " shells");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("'shells' is none of: curl_curl_10"));
}

const std::string kSeries = "time,a.v,von_mises_max,von_mises_node m\n0,3,0,7\n0.5,4,0,8\n";

TEST(CompareSeries, DifferenceOverNorm) {
  const TemporaryFolder folder;
  const std::string b = folder.write("b.csv", kSeries);
  const std::string a =
      folder.write("a.csv", "time,a.v,von_mises_max,von_mises_node m\n0,3.3,0,7\n0.5,4.4,0,9\n");
  const ProgramRun run = shell(kScripts + "compare_series " + a + " " + b);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("\n| a.v | 1.0e-01 |\n"));
  EXPECT_THAT(run.out, HasSubstr("\n| von_mises_max | 0.0e+00 |\n"));     // none, though the norm is zero
  EXPECT_THAT(run.out, HasSubstr("\n| von_mises_node m | 5.0e-01 |\n"));  // in one of two outputs
}

TEST(CompareSeries, RefusesOtherTimesAndQuantities) {
  const TemporaryFolder folder;
  const std::string b = folder.write("b.csv", kSeries);
  for (const char* other : {"time,a.v,von_mises_max,von_mises_node m\n0,3,0,7\n0.4,4,0,8\n",
                            "time,a.w,von_mises_max,von_mises_node m\n0,3,0,7\n0.5,4,0,8\n"}) {
    const ProgramRun run = shell(kScripts + "compare_series " + folder.write("a.csv", other) + " " + b);
    EXPECT_EQ(run.code, 1);
    EXPECT_THAT(run.err, HasSubstr("not the same quantities"));
  }
}

}  // namespace
