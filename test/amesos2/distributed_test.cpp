// mfs_distributed on 1, 2 and 4 ranks as a user starts it: the methods of Trilinos with MFS below them.
//
// Solutions are compared with the direct one inside the program (--check), with those of KLU2, and between
// all methods and numbers of ranks. KLU2 is no reference where it is itself spread over ranks, as in MueLu's
// coarsest grid: Debian's is wrong there.
#include <gmock/gmock.h>

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "test/program/run_program.hpp"

namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Le;
using ::testing::Not;
using Json = nlohmann::json;
using Strings = std::vector<std::string>;

std::string settings(const std::string& name) {
  return std::string(MFS_DISTRIBUTED_SETTINGS) + "/" + name + ".xml";
}

ProgramRun run(int ranks, const Strings& arguments) {
  Strings all{"-n", std::to_string(ranks)};
  for (const char* flag : {MFS_MPIEXEC_FLAGS})
    if (*flag != '\0') all.emplace_back(flag);
  all.emplace_back(MFS_DISTRIBUTED);
  all.insert(all.end(), arguments.begin(), arguments.end());
  // Waiting ranks leave the processor to those that work, also where Open MPI believes in enough processors.
  Streams streams;
  streams.environment = {{"OMPI_MCA_mpi_yield_when_idle", "1"}};
  return run_program(all, streams);
}

/// One object per file and solver. All must have converged to the direct solution.
std::vector<Json> solve(int ranks, const Strings& files, const Strings& options) {
  Strings arguments;
  for (const std::string& file : files) arguments.push_back(settings(file));
  arguments.insert(arguments.end(), options.begin(), options.end());
  arguments.insert(arguments.end(), {"--json", "--check"});
  const ProgramRun result = run(ranks, arguments);
  EXPECT_EQ(result.code, 0) << result.out << result.err;
  std::vector<Json> all;
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) all.push_back(Json::parse(line));
  for (const Json& one : all) {
    EXPECT_EQ(one["ranks"], ranks);
    EXPECT_TRUE(one["converged"]) << one;
    EXPECT_THAT(one["residual"].get<std::vector<double>>(), Each(Le(1e-9))) << one;
    EXPECT_THAT(one["difference"].get<std::vector<double>>(), Each(Le(1e-6))) << one;
  }
  return all;
}

const Json& find(const std::vector<Json>& all, const std::string& file, const std::string& solver = "MFS") {
  static const Json none;
  for (const Json& one : all)
    if (one["settings"] == file && one["solver"] == solver) return one;
  ADD_FAILURE() << file << " with " << solver << " was not run";
  return none;
}

std::vector<double> list(const Json& one, const char* key) {
  return one[key].get<std::vector<double>>();
}

/// `first` on rank 0, `other` on the rest.
std::vector<double> on_ranks(int ranks, double first, double other) {
  std::vector<double> all(static_cast<std::size_t>(ranks), other);
  all[0] = first;
  return all;
}

/// Analyses with the first values and with new ones. FROSch has a solver for the subdomain, with two levels
/// one for the extensions, and on rank 0 the coarse one, and keeps them all. Ifpack2 makes its own anew, and
/// so does MueLu the coarse one, which works on rank 0.
void expect_analyses(const std::vector<Json>& all, int ranks) {
  for (const Json& one : all) {
    const std::string file = one["settings"];
    const auto first = list(one, "analyses"), again = list(one, "analyses_again");
    const bool two_levels = file == "gdsw" || file == "rgdsw";
    if (file == "muelu")
      EXPECT_EQ(first, on_ranks(ranks, 1, 0)) << file;
    else
      EXPECT_EQ(first, two_levels ? on_ranks(ranks, 3, 2) : on_ranks(ranks, 1, 1)) << file;
    EXPECT_EQ(again, file == "schwarz" || file == "muelu" ? first : on_ranks(ranks, 0, 0)) << file;
  }
}

const Strings kAll{"schwarz", "frosch_one_level", "gdsw", "rgdsw", "muelu"};

class Ranks : public ::testing::TestWithParam<int> {};

TEST_P(Ranks, ElasticityByEachMethod) {
  const int ranks = GetParam();
  const auto all = solve(ranks, kAll, {"--nodes=13", "--new-values=1"});
  ASSERT_EQ(all.size(), kAll.size());
  expect_analyses(all, ranks);
  // These counts were seen with KLU2 as well, by another program.
  const int one_level = ranks == 2 ? 22 : 37;
  for (const char* file : {"schwarz", "frosch_one_level"})
    EXPECT_NEAR(find(all, file)["iterations"][0], one_level, 1) << file;
  for (const char* file : {"gdsw", "rgdsw"}) EXPECT_LT(find(all, file)["iterations"][0], one_level) << file;
  EXPECT_LE(find(all, "muelu")["iterations"][0], 36);
  for (const Json& one : all) {
    const auto norms = list(one, "norm"), first = list(all[0], "norm");
    ASSERT_EQ(norms.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(norms[k] / first[k], 1.0, 1e-8) << one["settings"];
    EXPECT_GT(std::abs(norms[0] / norms[1] - 1.0), 1e-2) << "the new values change nothing";
  }
}

TEST_P(Ranks, StokesByTheSchwarzMethods) {
  const int ranks = GetParam();
  const auto all = solve(ranks, {"schwarz", "frosch_one_level", "gdsw", "rgdsw"},
                         {"--problem=stokes", "--nodes=7", "--new-values=1"});
  expect_analyses(all, ranks);
  for (const Json& one : all) {
    EXPECT_LE(one["iterations"][0], 60) << one["settings"];
    EXPECT_NEAR(one["norm"][0].get<double>() / all[0]["norm"][0].get<double>(), 1.0, 1e-8) << one["settings"];
  }
}

/// In Schwarz methods KLU2 is serial too, and each of its subdomains is as good.
TEST_P(Ranks, AsManyIterationsAsWithKlu2) {
  const Strings files{"schwarz", "frosch_one_level", "gdsw"};
  for (const char* problem : {"elasticity", "stokes"}) {
    const auto all =
        solve(GetParam(), files, {"--nodes=7", "--solver=MFS,KLU2", std::string("--problem=") + problem});
    for (const std::string& file : files) {
      const Json &mfs = find(all, file), &klu2 = find(all, file, "KLU2");
      EXPECT_NEAR(mfs["iterations"][0], klu2["iterations"][0], 1) << file << " " << problem;
      EXPECT_NEAR(mfs["norm"][0].get<double>() / klu2["norm"][0].get<double>(), 1.0, 1e-8) << file;
      EXPECT_EQ(list(klu2, "analyses"), on_ranks(GetParam(), 0, 0)) << "MFS worked where KLU2 was asked for";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Distributed, Ranks, ::testing::Values(2, 4));

TEST(DistributedOnOneRank, MfsAndKlu2SideBySide) {
  const auto all = solve(1, {"schwarz", "frosch_one_level", "muelu"},
                         {"--nodes=9", "--solver=MFS,KLU2", "--new-values=1"});
  ASSERT_EQ(all.size(), 6u);
  for (const char* file : {"schwarz", "frosch_one_level", "muelu"}) {
    const Json &mfs = find(all, file), &klu2 = find(all, file, "KLU2");
    EXPECT_EQ(mfs["iterations"][0], klu2["iterations"][0]) << file;
    EXPECT_LE(mfs["iterations"][1], klu2["iterations"][1]) << file;  // MueLu 16.1 has 26, and 29 with KLU2
    for (int k = 0; k < 2; ++k)
      EXPECT_NEAR(mfs["norm"][k].get<double>() / klu2["norm"][k].get<double>(), 1.0, 1e-9) << file;
  }
}

/// Rows of a file lie anywhere: no nodes, no null space.
TEST(DistributedMatrixFile, OnTwoRanks) {
  const TemporaryFolder folder;
  std::string text = "%%MatrixMarket matrix coordinate real general\n60 60 178\n";
  for (int i = 1; i <= 60; ++i) {
    text += std::to_string(i) + " " + std::to_string(i) + " 4\n";
    if (i > 1) text += std::to_string(i) + " " + std::to_string(i - 1) + " -1.5\n";
    if (i < 60) text += std::to_string(i) + " " + std::to_string(i + 1) + " -1\n";
  }
  const auto all = solve(2, {"schwarz", "frosch_one_level"},
                         {"--matrix=" + folder.write("A.mtx", text), "--new-values=1"});
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0]["unknowns"], 60);
}

// ---- what must end as an error ----

/// Exit code 1 and a text on standard error, of which `expected` is a part.
void expect_error(int ranks, const Strings& arguments, const Strings& expected) {
  const ProgramRun result = run(ranks, arguments);
  EXPECT_EQ(result.code, 1) << result.out << result.err;
  for (const std::string& text : expected) EXPECT_THAT(result.err, HasSubstr(text));
}

/// A row of zeros in one subdomain. With FROSch the other ranks may wait inside it: the failing one ends all.
TEST(DistributedErrors, SingularSubdomain) {
  for (const char* file : {"schwarz", "frosch_one_level", "gdsw"})
    expect_error(4, {settings(file), "--nodes=7", "--singular=2"}, {"rank 2: ", "singular"});
  // The rows of rank 1 are 96 to 191.
  expect_error(2, {settings("schwarz"), "--nodes=4", "--singular=1"},
               {"rank 1: ", "singular", "(global row 144)"});
}

/// The shipped file with one text in place of another.
std::string changed(const TemporaryFolder& folder, const std::string& name, const std::string& from,
                    const std::string& to) {
  std::string text = text_of(settings(name));
  const std::size_t place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return folder.write(name + ".xml", text.replace(place, from.size(), to));
}

TEST(DistributedErrors, WrongParameters) {
  const TemporaryFolder folder;
  const auto wrong = [&](const std::string& name, const std::string& from, const std::string& to,
                         const std::string& expected) {
    SCOPED_TRACE(name + ": " + to);
    expect_error(2, {changed(folder, name, from, to), "--nodes=5"}, {expected});
  };
  wrong("frosch_one_level", "\"Threads\"", "\"Thread\"", "Thread");
  wrong("schwarz", "\"Threads\"", "\"Thread\"", "Thread");
  wrong("schwarz", "ParameterList name=\"Amesos2\"", "ParameterList name=\"Amesos\"", "Amesos2");
  wrong("schwarz", "Amesos2 solver name", "Amesos2 solver", "\"KLU2\" : ParameterList");  // Ifpack2's default
  wrong("muelu", "value=\"MFS\"", "value=\"KLU2\"", "has made no solver MFS");
  wrong("frosch_one_level", "Reuse: Symbolic Factorization", "Reuse: Symbolic Factorisation",
        "nobody has read: AlgebraicOverlappingOperator -> Reuse: Symbolic Factorisation");
  wrong("gdsw", "name=\"CoarseSolver\"", "name=\"CoarsestSolver\"", "CoarsestSolver -> Solver");
  wrong("muelu", "coarse: type", "coarsest: type", "coarsest: type");
  wrong("muelu", "value=\"MueLu\"", "value=\"ML\"", "there is no list \"ML\"");
  // One layer of "MFS" too few: FROSch takes it away, and Amesos2 finds an option among its own.
  wrong(
      "frosch_one_level",
      "<ParameterList name=\"MFS\">\n                <Parameter name=\"Threads\" type=\"int\" value=\"1\"/>\n"
      "              </ParameterList>",
      "<Parameter name=\"Threads\" type=\"int\" value=\"1\"/>", "Threads");
}

/// They reach the innermost list "MFS" of each engine, FROSch's below one of the same name.
TEST(DistributedOptions, OfMfsFromTheCommandLine) {
  for (const char* file : {"schwarz", "frosch_one_level"}) {
    EXPECT_EQ(run(1, {settings(file), "--nodes=4", "--mfs-backend=serial", "--mfs-threads=1"}).code, 0)
        << file;
    expect_error(1, {settings(file), "--nodes=4", "--mfs-backend=abacus"}, {"abacus", "Backend"});
    expect_error(1, {settings(file), "--nodes=4", "--mfs-threads=1000000"}, {"threads"});
  }
}

TEST(DistributedOptions, EnginesPrintWhereAsked) {
  const Strings arguments{settings("frosch_one_level"), "--nodes=4"};
  EXPECT_THAT(run(1, arguments).out, Not(HasSubstr("AlgebraicOverlappingOperator")));
  const ProgramRun verbose = run(1, {arguments[0], arguments[1], "--verbose"});
  EXPECT_THAT(verbose.out,
              AllOf(HasSubstr("AlgebraicOverlappingOperator"), HasSubstr("frosch_one_level with MFS")));
}

TEST(DistributedErrors, Usage) {
  EXPECT_EQ(run(1, {}).code, 2);
  EXPECT_EQ(run(1, {settings("schwarz"), "--nodse=5"}).code, 2);
  EXPECT_EQ(run(1, {settings("schwarz"), "--singular=1"}).code, 2);
  expect_error(2, {"nowhere.xml"}, {"nowhere.xml: no such file"});
  expect_error(2, {settings("schwarz"), "--problem=heat"}, {"elasticity or stokes, not heat"});
  expect_error(4, {settings("schwarz"), "--nodes=1"}, {"1 nodes in direction"});
  expect_error(1, {settings("schwarz"), "--matrix=nowhere.mtx"}, {"nowhere.mtx: no such file"});
}

}  // namespace
