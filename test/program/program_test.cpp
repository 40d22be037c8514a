// The program mfs from outside: exit codes, standard output and error, JSON, files.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "test/program/program_fixture.hpp"

namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::Pointwise;
using testing::StartsWith;

// ---- solving ----

TEST_F(Program, SolvesAndWritesX) {
  const std::string a = file("a.mtx", kTriangular), x = path("x.mtx");
  const ProgramRun run = run_program({"solve", a, "-o", x});
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out, AllOf(HasSubstr("a: n = 2, 3 entries\n"), HasSubstr("1 right-hand side,"),
                             HasSubstr("\nbackward error ")));
  EXPECT_THAT(solution(x), Pointwise(DoubleNear(1e-15), {0.375, 0.25}));
  EXPECT_THAT(text_of(x), StartsWith(kArray + "% solution of A x = b"));
}

TEST_F(Program, SolvesTheTransposedSystem) {
  const std::string a = file("a.mtx", kTriangular), x = path("x.mtx");
  EXPECT_EQ(run_program({"solve", a, "--transpose", "-o", x}).code, 0);
  EXPECT_THAT(solution(x), Pointwise(DoubleNear(1e-15), {0.5, 0.125}));
}

TEST_F(Program, TakesRightHandSidesFromAFile) {
  const std::string a = file("a.mtx", kTriangular), x = path("x.mtx");
  const std::string b = file("b.mtx", kArray + "2 2\n3\n4\n2\n0\n");
  EXPECT_EQ(run_program({"solve", a, "--rhs", b, "-o", x}).code, 0);
  EXPECT_THAT(solution(x), Pointwise(DoubleNear(1e-15), {1, 1, 1, 0}));
  EXPECT_EQ(run_program({"solve", a, "--rhs", b, "--nrhs", "2"}).code, 0);
  EXPECT_THAT(complaint({"solve", a, "--rhs", b, "--nrhs", "3"}, 3), HasSubstr("--nrhs"));
}

TEST_F(Program, RandomRightHandSidesAreTheSameEveryTime) {
  const std::string a = file("a.mtx", kTriangular), x = path("x.mtx"), y = path("y.mtx");
  EXPECT_EQ(run_program({"solve", a, "--rhs", "random", "--nrhs", "3", "-o", x}).code, 0);
  EXPECT_EQ(run_program({"solve", a, "--rhs", "random", "--nrhs", "3", "-o", y}).code, 0);
  const std::vector<double> first = solution(x);
  EXPECT_EQ(first.size(), 6u);
  EXPECT_EQ(first, solution(y));
  EXPECT_NE(first[0], first[2]);
}

TEST_F(Program, SymmetricAndSkewSymmetricFiles) {
  const std::string x = path("x.mtx");
  const std::string symmetric =
      file("s.mtx", "%%MatrixMarket matrix coordinate integer symmetric\n2 2 2\n1 1 1\n2 1 2\n");
  EXPECT_EQ(run_program({"solve", symmetric, "-o", x}).code, 0);
  EXPECT_THAT(solution(x), Pointwise(DoubleNear(1e-15), {0.5, 0.25}));
  const std::string skew =
      file("k.mtx", "%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 2\n");
  EXPECT_EQ(run_program({"solve", skew, "-o", x}).code, 0);
  EXPECT_THAT(solution(x), Pointwise(DoubleNear(1e-15), {0.5, -0.5}));
}

TEST_F(Program, OptionsReachTheSolver) {
  const std::string a = file("a.mtx", kTriangular);
  const ProgramRun run = run_program({"solve", a, "--threads", "1", "--backend", "serial", "--max-block", "7",
                                      "--refactor", "3", "--tol", "1e-10", "--json", "-"});
  EXPECT_EQ(run.code, 0) << run.err;
  const auto json = ordered_json::parse(run.out);
  EXPECT_EQ(json["threads"], 1);
  EXPECT_EQ(json["backend"], "serial");
  EXPECT_GT(json["time_refactor"], 0);
  EXPECT_THAT(run_program({"solve", a, "--refactor", "3"}).out,
              AllOf(HasSubstr("the least of 3\n"), HasSubstr("refinement steps, the least of 4\n")));
  EXPECT_THAT(run_program({"solve", a}).out, Not(HasSubstr("least")));
}

// ---- JSON ----

TEST_F(Program, JsonOnStandardOutputIsAlone) {
  const ProgramRun run = run_program({"solve", file("a.mtx", kTriangular), "--json", "-"});
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_EQ(run.out.find('\n'), run.out.size() - 1);
  const auto json = ordered_json::parse(run.out);
  EXPECT_EQ(keys_of(json), kKeys);
  EXPECT_EQ(json["name"], "a");
  EXPECT_EQ(json["n"], 2);
  EXPECT_EQ(json["nnz"], 3);
  EXPECT_EQ(json["status"], "solved");
  EXPECT_EQ(json["message"], "");
  EXPECT_EQ(json["time_refactor"], 0);
  EXPECT_LE(json["backward_error"], 1e-12);
  EXPECT_EQ(json["diagonal_blocks"], 2);
  EXPECT_EQ(json["nnz_factor"], 2) << "of the blocks";
}

TEST_F(Program, JsonIsWrittenWhenSolvingFails) {
  const std::string j = path("r.json");
  const std::string singular = file("s.mtx", kReal + "2 2 4\n1 1 1\n1 2 1\n2 1 1\n2 2 1\n");
  const ProgramRun run = run_program({"solve", singular, "--rhs", "random", "--json", j});
  EXPECT_EQ(run.code, 4);
  EXPECT_EQ(run.out, "");
  auto json = ordered_json::parse(text_of(j));
  EXPECT_EQ(keys_of(json), kKeys);
  EXPECT_EQ(json["status"], "singular");
  EXPECT_EQ("mfs: " + json["message"].get<std::string>() + "\n", run.err);
  EXPECT_EQ(json["n"], 2);
  EXPECT_TRUE(json["backward_error"].is_null());

  EXPECT_EQ(run_program({"solve", path("none.mtx"), "--json", j}).code, 3);
  json = ordered_json::parse(text_of(j));
  EXPECT_EQ(keys_of(json), kKeys);
  EXPECT_EQ(json["name"], "none");
  EXPECT_EQ(json["status"], "invalid_input");
}

// ---- exit codes ----

TEST_F(Program, UsageIs2) {
  const std::string a = file("a.mtx", kTriangular);
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{},
                                             {"nonsense"},
                                             {"solve"},
                                             {"solve", a, "--nonsense"},
                                             {"solve", a, a},
                                             {"solve", a, "--threads", "0"},
                                             {"solve", a, "--threads", "x"},
                                             {"solve", a, "--nrhs", "0"},
                                             {"solve", a, "--backend", "gpu"},
                                             {"solve", a, "--tol", "0"},
                                             {"solve", a, "--tol", "nan"},
                                             {"solve", a, "--precision", "half"},
                                             {"solve", a, "--dump"},
                                             {"analyze", a, "--condition"},
                                             {"analyze", a, "--memory-limit", "8GX"},
                                             {"solve", a, "--memory-limit", "-1"},
                                             {"solve", a, "--memory-limit", "0"},
                                             {"solve", a, "--max-block", "0"},
                                             {"solve", a, "--refactor", "-1"},
                                             {"solve", a, "--json"},
                                             {"bench"},
                                             {"bench", "elas3d"},
                                             {"bench", "elas3d:0"},
                                             {"bench", "kkt:3", "elas4d:3"},
                                             {"bench", "kkt:2", "kkt:3", "-o", path("x.mtx")},
                                             {"analyze"},
                                             {"info", "x"}})
    complaint(arguments, 2);
}

TEST_F(Program, InvalidInputIs3AndNamesThePlace) {
  const std::string none = path("none.mtx");
  EXPECT_EQ(complaint({"solve", none}, 3), none + ": cannot be opened: No such file or directory");
  const std::string late = file("late.mtx", kReal + "% comment\n2 2 2\n1 1 1\n3 1 1\n");
  EXPECT_EQ(complaint({"solve", late}, 3), late + ": line 5: row 3 is not in 1..2");
  const std::string wide = file("wide.mtx", kReal + "2 3 0\n");
  EXPECT_EQ(complaint({"solve", wide}, 3), wide + ": line 2: the matrix is not square: 2 x 3");
  const std::string pattern = file("p.mtx", "%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n");
  EXPECT_EQ(complaint({"solve", pattern}, 3), pattern + ": line 2: the file is a pattern: it has no values");
  const std::string nan = file("nan.mtx", kReal + "2 2 3\n1 1 1\n2 1 nan\n2 2 1\n");
  EXPECT_THAT(complaint({"solve", nan}, 3),
              AllOf(StartsWith("nan: "), HasSubstr("(row 1, column 0)"), HasSubstr("count from 0")));
  complaint({"solve", file("empty.mtx", kReal + "0 0 0\n")}, 3);
  complaint({"bench", "elas3d:1000000"}, 3);

  const std::string a = file("a.mtx", kTriangular), b = file("b.mtx", kArray + "3 1\n1\n1\n1\n");
  EXPECT_THAT(complaint({"solve", a, "--rhs", b}, 3), HasSubstr(b + ": line 2: right-hand sides of 2 rows"));
  complaint({"solve", a, "--rhs", file("nan_b.mtx", kArray + "2 1\n1\ninf\n")}, 3);
}

TEST_F(Program, OutputThatCannotBeWrittenIs3) {
  const std::string a = file("a.mtx", kTriangular);
  EXPECT_EQ(complaint({"solve", a, "-o", "/no/such/x.mtx"}, 3),
            "/no/such/x.mtx: cannot be opened for writing: No such file or directory");
  EXPECT_THAT(complaint({"solve", a, "-o", "/dev/full"}, 3),
              HasSubstr("/dev/full: cannot be written: No space left"));
  EXPECT_THAT(complaint({"solve", a, "--json", "/no/such/r.json"}, 3), HasSubstr("/no/such/r.json"));
  EXPECT_THAT(complaint({"solve", a, "--json", "/dev/full"}, 3), HasSubstr("/dev/full"));
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"solve", a}, {"solve", a, "--json", "-"}, {"analyze", a}, {"info"}}) {
    EXPECT_EQ(run_program(arguments, {"/dev/full"}).code, 3) << arguments[0];
    EXPECT_EQ(run_program(arguments, {"", false, true}).code, 3) << arguments[0];
  }
}

// Random right-hand sides: a singular matrix may well have a solution for b = (1, 1).
TEST_F(Program, SingularIs4) {
  EXPECT_THAT(
      complaint({"solve", file("n.mtx", kReal + "2 2 4\n1 1 1\n1 2 1\n2 1 1\n2 2 1\n"), "--rhs", "random"},
                4),
      StartsWith("n: numerically singular"));
  EXPECT_THAT(complaint({"solve", file("s.mtx", kReal + "2 2 2\n1 1 1\n1 2 1\n")}, 4),
              AllOf(StartsWith("s: structurally singular"), HasSubstr("row 1")));
  const std::string lie = file("lie.mtx", kReal + "2000000000 2000000000 1\n1 1 1\n");
  EXPECT_EQ(
      complaint({"solve", lie}, 4),
      "structurally singular: " + lie +
          ": the header claims 2000000000 rows, but at least 1999999999 of them have no entry (row 1); rows "
          "and columns count from 0");
}

#if !defined(__SANITIZE_ADDRESS__)  // which ends the program when memory is asked for that cannot be
TEST_F(Program, OutOfMemoryIs5) {
  std::string text = kReal + "5000 5000 5000\n";
  for (int i = 1; i <= 5000; ++i) text += std::to_string(i) + " " + std::to_string(i) + " 1\n";
  EXPECT_THAT(complaint({"solve", file("d.mtx", text), "--nrhs", "2147483647"}, 5),
              HasSubstr("out of host memory"));
}
#endif

// 3 x = 1 has no solution in double: its nearest has a backward error of 2^-54 or so.
TEST_F(Program, AccuracyNotReachedIs6AndWritesNoX) {
  const std::string a = file("a.mtx", kReal + "1 1 1\n1 1 3\n"), x = path("x.mtx"), j = path("r.json");
  complaint({"solve", a, "--tol", "1e-30", "-o", x, "--json", j}, 6);
  EXPECT_FALSE(std::filesystem::exists(x));
  EXPECT_EQ(ordered_json::parse(text_of(j))["status"], "accuracy_not_reached");
}

TEST_F(Program, ABackendThatIsNotThereIs7) {
  if (run_program({"info"}).out.find("cuda") != std::string::npos) GTEST_SKIP() << "cuda can be used here";
  EXPECT_THAT(complaint({"solve", file("a.mtx", kTriangular), "--backend", "cuda"}, 7), HasSubstr("cuda"));
}

// ---- the other commands ----

TEST_F(Program, BenchWritesOneJsonLinePerCase) {
  const ProgramRun run = run_program({"bench", "poisson2d:9", "kkt:2", "circuit:200", "--json", "-"});
  EXPECT_EQ(run.code, 0) << run.err;
  std::vector<std::string> names;
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) {
    const auto json = ordered_json::parse(line);
    EXPECT_EQ(keys_of(json), kKeys);
    EXPECT_EQ(json["status"], "solved");
    names.push_back(json["name"]);
  }
  EXPECT_THAT(names, ElementsAre("poisson2d:9", "kkt:2", "circuit:200"));
}

TEST_F(Program, BenchTakesTheOptionsOfSolve) {
  const std::string x = path("x.mtx");
  EXPECT_EQ(
      run_program({"bench", "poisson2d:3", "--rhs", "random", "--nrhs", "2", "--transpose", "-o", x}).code,
      0);
  EXPECT_EQ(solution(x).size(), 18u);
}

TEST_F(Program, AnalyzeShowsTheFrontsByDepth) {
  const ProgramRun run = run_program({"analyze", file("a.mtx", kTriangular)});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("a: n = 2, 3 entries"), HasSubstr("\nflops "), HasSubstr("\n  gemm "),
                             HasSubstr("\nfactor size "), HasSubstr("\ndepth "), HasSubstr("\n    0 ")));
}

TEST_F(Program, AnalyzeWritesJson) {
  const std::string json = path("a.json");
  EXPECT_EQ(run_program({"analyze", file("a.mtx", kTriangular), "--json", json}).code, 0);
  const auto made = ordered_json::parse(text_of(json));
  EXPECT_EQ(made["n"], 2);
  EXPECT_EQ(made["partial"], false);
  EXPECT_EQ(made["segments"], 0);
}

TEST_F(Program, MemoryLimitsTakeUnits) {
  const std::string a = file("a.mtx", kTriangular);
  for (const auto& [size, bytes] :
       {std::pair{"20000", "20000"}, {"20KB", "20000"}, {"20 kb", "20000"}, {"20KiB", "20480"}})
    EXPECT_THAT(complaint({"bench", "elas3d:4", "--memory-limit", size}, 5),
                HasSubstr(std::string(bytes) + " available"));
  EXPECT_THAT(complaint({"solve", a, "--backend", "kokkos", "--memory-limit", "8GB"}, 3),
              HasSubstr("memory_limit"));
  EXPECT_EQ(run_program({"solve", a, "--memory-limit", "8GB"}).code, 0);
}

TEST_F(Program, FactorsThatMemoryHasNoRoomForGoToAFile) {
  const std::string in_memory = path("memory.mtx"), out_of_core = path("file.mtx"), json = path("r.json");
  const std::vector<std::string> solve{"bench", "elas3d:9", "--threads", "2", "-o"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), solve.begin(), solve.end());
    return run_program(more);
  };
  EXPECT_EQ(with({in_memory, "--json", json}).code, 0);
  const auto full = ordered_json::parse(text_of(json));
  EXPECT_EQ(full["partial"], false);
  const std::string limit = std::to_string(full["bytes_peak"].get<std::int64_t>() * 7 / 10);
  EXPECT_THAT(complaint({"bench", "elas3d:9", "--memory-limit", limit}, 5), HasSubstr("out_of_core_dir"));
  const std::string folder = path("");
  const ProgramRun run = with({out_of_core, "--memory-limit", limit, "--out-of-core-dir", folder});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr(" to a file, a pass of a solve reads "));
  EXPECT_EQ(with({out_of_core, "--memory-limit", limit, "--out-of-core-dir", folder, "--json", json}).code,
            0);
  EXPECT_EQ(text_of(out_of_core), text_of(in_memory));
  const auto partial = ordered_json::parse(text_of(json));
  EXPECT_EQ(partial["partial"], true);
  EXPECT_GT(partial["bytes_out"], 0);
  EXPECT_GE(partial["bytes_back"], partial["bytes_out"]);
  EXPECT_THAT(
      complaint({"bench", "elas3d:9", "--memory-limit", limit, "--out-of-core-dir", folder + "/none"}, 7),
      AllOf(HasSubstr("/none"), HasSubstr("No such file")));
}

TEST_F(Program, AnalyzeNeedsNoValues) {
  EXPECT_EQ(run_program({"analyze", file("p.mtx",
                                         "%%MatrixMarket matrix coordinate pattern symmetric\n"
                                         "3 3 5\n1 1\n2 1\n2 2\n3 2\n3 3\n")})
                .code,
            0);
  EXPECT_EQ(run_program({"analyze",
                         file("c.mtx", "%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 0 1\n")})
                .code,
            0);
}

TEST_F(Program, InfoHelpAndVersion) {
  const ProgramRun info = run_program({"info"});
  EXPECT_EQ(info.code, 0);
  EXPECT_THAT(info.out, AllOf(StartsWith("mfs "), HasSubstr("\nbackends "), HasSubstr("serial")));
  EXPECT_THAT(run_program({"--version"}).out, StartsWith("mfs "));
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"--help"}, {"solve", "--help"}, {"bench", "-h"}}) {
    const ProgramRun help = run_program(arguments);
    EXPECT_EQ(help.code, 0);
    EXPECT_EQ(help.err, "");
    EXPECT_THAT(help.out, HasSubstr("Exit codes: 0 solved, 2 usage"));
  }
}

// Whatever OpenBLAS makes of this processor.
TEST_F(Program, WorksWithTheBestKernelsOfOpenBlas) {
  if (std::getenv("OPENBLAS_CORETYPE")) GTEST_SKIP() << "the environment has chosen";
  EXPECT_THAT(run_program({"info"}).out, Not(HasSubstr("would be faster")));
}
TEST_F(Program, WorksWithThemByAnotherNameToo) {
  if (std::getenv("OPENBLAS_CORETYPE")) GTEST_SKIP() << "the environment has chosen";
  Streams streams;
  streams.program = path("renamed");
  std::filesystem::copy_file(MFS_PROGRAM, streams.program);
  EXPECT_THAT(run_program({"info"}, streams).out,
              AllOf(StartsWith("mfs "), Not(HasSubstr("would be faster"))));
}

#ifndef __SANITIZE_ADDRESS__
// Then the file of the process is the loader, which is not the one to begin again with.
TEST_F(Program, IsRunByTheDynamicLoaderToo) {
  const std::string loader = "/lib64/ld-linux-x86-64.so.2";
  if (!std::filesystem::exists(loader)) GTEST_SKIP() << "no " << loader;
  EXPECT_EQ(std::system((loader + " '" MFS_PROGRAM "' info >/dev/null").c_str()), 0);
}
#endif

// ---- terminal ----

TEST_F(Program, ProgressIsShownOnATerminalOnly) {
  const std::string a = file("a.mtx", kTriangular);
  EXPECT_EQ(run_program({"solve", a}).err, "");
  const ProgramRun run = run_program({"solve", a}, {"", true, false});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.err, HasSubstr("\r\033[Kread "));
  EXPECT_THAT(run.err, EndsWith("\r\033[K"));  // and leaves nothing behind
  EXPECT_THAT(run.out, HasSubstr("\nbackward error "));
}

// ---- files of others ----

TEST_F(Program, MalformedFilesNeverCrash) {
  const char* matrices = std::getenv("MFS_MATRIX_DIR");
  const std::string folder = std::string(matrices ? matrices : "") + "/malformed";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "MFS_MATRIX_DIR has no folder malformed";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const ProgramRun run = run_program({"solve", entry.path().string()});
    EXPECT_TRUE(run.code == 0 || run.code == 3 || run.code == 4)
        << entry.path() << ": " << run.code << " " << run.err;
  }
}

}  // namespace
