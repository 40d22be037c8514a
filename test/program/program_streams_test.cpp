// Standard input and output as files, output that breaks off, and a process that may take little memory.
#include <csignal>
#include <string>
#include <vector>

#include "test/program/program_fixture.hpp"

namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::AnyOf;
using testing::DoubleNear;
using testing::HasSubstr;
using testing::Pointwise;
using testing::StartsWith;

std::string diagonal(int n) {
  const std::string size = std::to_string(n);
  std::string text = kReal + size + " " + size + " " + size + "\n";
  for (int i = 1; i <= n; ++i) text += std::to_string(i) + " " + std::to_string(i) + " 3\n";
  return text;
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

// ---- standard input and output ----

TEST_F(Program, ReadsTheMatrixFromStandardInput) {
  Streams streams;
  streams.in = file("a.mtx", kTriangular);
  const std::string x = path("x.mtx");
  ProgramRun run = run_program({"solve", "-", "-o", x}, streams);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("stdin: n = 2, 3 entries\n"));
  EXPECT_THAT(solution(x), Pointwise(DoubleNear(1e-15), {0.375, 0.25}));
  EXPECT_EQ(run_program({"analyze", "-"}, streams).code, 0);
  EXPECT_EQ(run_program({"bench", "-"}, streams).code, 0);

  streams.in = file("bad.mtx", kReal + "2 2 1\n3 1 1\n");
  run = run_program({"solve", "-"}, streams);
  EXPECT_EQ(run.code, 3);
  EXPECT_EQ(run.err, "mfs: standard input: line 3: row 3 is not in 1..2\n");
  EXPECT_EQ(run_program({"solve", "-"}).err, "mfs: standard input: the file is empty\n");
}

TEST_F(Program, ReadsRightHandSidesFromStandardInput) {
  const std::string a = file("a.mtx", kTriangular), x = path("x.mtx");
  Streams streams;
  streams.in = file("b.mtx", kArray + "2 1\n3\n4\n");
  EXPECT_EQ(run_program({"solve", a, "--rhs", "-", "-o", x}, streams).code, 0);
  EXPECT_THAT(solution(x), Pointwise(DoubleNear(1e-15), {1, 1}));
  EXPECT_THAT(complaint({"solve", "-", "--rhs", "-"}, 2), HasSubstr("cannot be both A and b"));
}

TEST_F(Program, WritesXToStandardOutputAlone) {
  const std::string a = file("a.mtx", kTriangular);
  const ProgramRun run = run_program({"solve", a, "-o", "-"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, StartsWith(kArray + "% solution of A x = b"));
  EXPECT_THAT(solution(file("x.mtx", run.out)), Pointwise(DoubleNear(1e-15), {0.375, 0.25}));
  EXPECT_THAT(run.err, AllOf(HasSubstr("a: n = 2"), HasSubstr("\nbackward error ")));
  EXPECT_EQ(run_program({"solve", a, "-o", "-"}, {"/dev/full"}).code, 3);
  EXPECT_THAT(complaint({"solve", a, "-o", "-", "--json", "-"}, 2), HasSubstr("cannot be both X and JSON"));
  EXPECT_EQ(run_program({"solve", a, "-o", "-", "--json", path("r.json")}).err, "");
}

// ---- output that breaks off ----

TEST_F(Program, AFileThatCannotBeFinishedLeavesTheOldOne) {
  const std::string a = file(std::string(250, 'a') + ".mtx", diagonal(2000));  // the report has the name
  const std::string x = path("x.mtx"), j = path("r.json");
  ASSERT_EQ(run_program({"solve", a, "-o", x, "--json", j}).code, 0);
  const std::string old_x = text_of(x), old_j = text_of(j);
  ASSERT_EQ(solution(x).size(), 2000u);
  const std::vector<std::string> files = files_in(path(""));
  Streams little;
  little.file_size = 4096;
  EXPECT_EQ(run_program({"solve", a, "-o", x}, little).code, 3);
  EXPECT_EQ(text_of(x), old_x);
  little.file_size = 1024;  // LLVM's OpenMP has a file of that size for itself
  const ProgramRun run = run_program({"solve", a, "--json", j}, little);
  EXPECT_EQ(run.code, 3);
  EXPECT_EQ(run.err, "mfs: " + j + ": cannot be written: File too large\n");
  EXPECT_EQ(text_of(j), old_j);
  EXPECT_EQ(files_in(path("")), files);  // nothing is left beside them
}

TEST_F(Program, AReplacedFileKeepsItsLinkAndItsMode) {
  const std::string a = file("a.mtx", kTriangular), target = file("target.mtx", "old"),
                    link = path("link.mtx");
  std::filesystem::create_symlink("target.mtx", link);
  std::filesystem::permissions(target, std::filesystem::perms(0640));
  EXPECT_EQ(run_program({"solve", a, "-o", link}).code, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(solution(target).size(), 2u);
  EXPECT_EQ(std::filesystem::status(target).permissions(), std::filesystem::perms(0640));
}

TEST_F(Program, JsonOfCasesBeforeOneThatFailsIsThere) {
  const std::string j = path("r.json"), bad = file("bad.mtx", kReal + "1 1 1\n1 1 0\n");
  EXPECT_EQ(run_program({"bench", "poisson2d:5", bad, "poisson2d:6", "--json", j}).code, 4);
  std::istringstream lines(text_of(j));
  std::vector<std::string> status;
  for (std::string line; std::getline(lines, line);) status.push_back(ordered_json::parse(line)["status"]);
  EXPECT_EQ(status, (std::vector<std::string>{"solved", "singular", "solved"}));
}

// ---- matrices of the user in bench ----

TEST_F(Program, BenchTakesFiles) {
  const std::string a = file("mine.mtx", kTriangular);
  const ProgramRun run = run_program({"bench", a, "poisson2d:4", "--json", "-"});
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(ordered_json::parse(run.out.substr(0, run.out.find('\n')))["name"], "mine");
  EXPECT_THAT(complaint({"bench", path("none.mtx")}, 2), HasSubstr("neither a file nor FAMILY:SIZE"));
}

// ---- little memory ----

#if !defined(__SANITIZE_ADDRESS__)  // whose shadow takes terabytes of address space
constexpr rlim_t kLittle[] = {60, 80, 100, 120, 150, 200, 250, 300, 400, 600};  // MiB

// However many threads of its own OpenBLAS has been told to have.
TEST_F(Program, EndsWhereLittleAddressSpaceIsLeft) {
  const std::string a = file("a.mtx", kTriangular);
  for (const rlim_t megabytes : kLittle)
    for (const char* blas_threads : {"1", "16"})
      for (const char* threads : {"1", "2", "16"}) {
        Streams streams;
        streams.address_space = megabytes << 20;
        streams.environment = {{"OPENBLAS_NUM_THREADS", blas_threads}};
        const ProgramRun run = run_program({"solve", a, "--threads", threads}, streams);
        // 7: no room for the stack of a thread; 127: not even for the libraries.
        EXPECT_THAT(run.code, AnyOf(0, 5, 7, 127))
            << megabytes << " MiB, " << threads << " threads: " << run.err;
      }
  Streams streams;
  streams.address_space = rlim_t{100} << 20;
  const ProgramRun run = run_program({"info"}, streams);
  EXPECT_EQ(run.code, 5);
  EXPECT_THAT(run.err, HasSubstr("mfs: out of memory: the limit of the address space"));
  streams.address_space = rlim_t{400} << 20;
  EXPECT_EQ(run_program({"solve", a, "--threads", "1"}, streams).code, 0);
  streams.address_space = rlim_t{150} << 20;
  EXPECT_EQ(run_program({"solve", a, "--threads", "1"}, streams).code, 5);
}

#if defined(MFS_CLIENT)
// A program of which libmfs is a part does not look at its limit before OpenBLAS is loaded. OpenBLAS' threads
// take their space at any time, also between the question for threads and the start of these, which libgomp
// ends with 1: so any end will do.
TEST_F(Program, ClientsEndWhereLittleAddressSpaceIsLeft) {
  const std::string libraries = run_program({"info"}).out;
  if (libraries.find("OpenBLAS 0.3.21") == std::string::npos)
    GTEST_SKIP() << libraries
                 << ": later OpenBLAS asks for space without end when it is loaded, whoever loads it";
  Streams streams;
  streams.program = MFS_CLIENT;
  streams.environment = {{"OPENBLAS_NUM_THREADS", "16"}};
  for (const rlim_t megabytes : kLittle) {
    streams.address_space = megabytes << 20;
    const ProgramRun run =
        run_program({"--backend", "openmp", "--threads", "2", "--repeat", "1", "poisson2d:4"}, streams);
    EXPECT_NE(run.code, 1000 + SIGALRM) << megabytes << " MiB: hangs";
  }
}
#endif
#endif

}  // namespace
