// Threads of a solver whose options leave them open: who decides, and what is this process's share of a node.
#include <mfs/threads.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include <mfs/mfs.hpp>

#include "kernels/runtime/control_groups.hpp"
#include "solver/node_share.hpp"
#include "test/solver/systems.hpp"

extern char** environ;

namespace mfs::test {
namespace {

/// A variable of the environment, as long as it lives.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Variable() { unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

int own_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  sched_getaffinity(0, sizeof set, &set);
  const int quota = processor_quota();
  return quota > 0 ? std::min(CPU_COUNT(&set), quota) : CPU_COUNT(&set);
}

TEST(NodeShare, EqualPartsOfWhatTheLauncherMayUse) {
  EXPECT_EQ(share_of_processors(8, 8, 1), 8);
  EXPECT_EQ(share_of_processors(8, 8, 4), 2);
  EXPECT_EQ(share_of_processors(8, 8, 3), 2);
  EXPECT_EQ(share_of_processors(8, 8, 16), 1) << "more ranks than processors";
  EXPECT_EQ(share_of_processors(4, 16, 4), 4) << "each bound to four of its own";
  EXPECT_EQ(share_of_processors(1, 16, 4), 1) << "each bound to one";
  EXPECT_EQ(share_of_processors(8, 16, 4), 4) << "bound to sockets, two ranks on each";
  EXPECT_EQ(share_of_processors(8, 0, 4), 2) << "the launcher is not to be seen";
  EXPECT_EQ(share_of_processors(8, 2, 4), 2) << "a launcher that is bound itself";
}

TEST(NodeShare, ListsOfSlurm) {
  EXPECT_EQ(entry_of_slurm_list("4", 0), 4);
  EXPECT_EQ(entry_of_slurm_list("2(x3),1", 0), 2);
  EXPECT_EQ(entry_of_slurm_list("2(x3),1", 2), 2);
  EXPECT_EQ(entry_of_slurm_list("2(x3),1", 3), 1);
  EXPECT_EQ(entry_of_slurm_list("5,4(x3),16,3(x2)", 4), 16);
  EXPECT_EQ(entry_of_slurm_list("5,4(x3),16,3(x2)", 6), 3);
  EXPECT_EQ(entry_of_slurm_list("2(x3),8,1", 77), 8) << "no such node: the largest";
  EXPECT_EQ(entry_of_slurm_list("2(x3),8,1", -1), 8);
  for (const char* list :
       {"", "two", "2(x", "2(x3", "2(x3)1", "2,", "-2", "0", "2(x0)", "2 ", "99999999999999"})
    EXPECT_EQ(entry_of_slurm_list(list, 50), 0) << list;
}

TEST(NodeShare, NumberOfRanksByTheLaunchersVariable) {
  EXPECT_EQ(local_ranks().count, 1);
  for (const char* name : {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS", "MV2_COMM_WORLD_LOCAL_SIZE",
                           "PMI_LOCAL_SIZE", "PALS_LOCAL_SIZE"}) {
    const Variable slurm("SLURM_STEP_TASKS_PER_NODE", "7");  // of the step that mpirun itself is
    {
      const Variable ranks(name, "3");
      EXPECT_EQ(local_ranks().count, 3) << name;
      EXPECT_STREQ(local_ranks().variable, name);
    }
    for (const char* wrong : {"", "0", "-4", "3x", "three"}) {
      const Variable ranks(name, wrong);
      EXPECT_EQ(local_ranks().count, 7) << name << "=" << wrong;
    }
  }
  const Variable slurm("SLURM_STEP_TASKS_PER_NODE", "2(x3),9"), node("SLURM_NODEID", "3");
  EXPECT_EQ(local_ranks().count, 9);
}

// Run by the next test alone: in a process that a launcher has started, with or without a script around it.
TEST(LaunchedProcess, SeesItsLauncherAndTakesItsShare) {
  const char* launcher = std::getenv("MFS_TEST_LAUNCHER");
  if (launcher == nullptr) GTEST_SKIP() << "for NodeShare.ALauncherIsSeenBehindAScript";
  EXPECT_EQ(launcher_of("PMI_LOCAL_SIZE"), std::atoi(launcher));
  EXPECT_EQ(default_threads(), std::max(1, own_processors() / 2));
  cpu_set_t first;
  CPU_ZERO(&first);
  sched_getaffinity(0, sizeof first, &first);
  for (int cpu = CPU_SETSIZE - 1; CPU_COUNT(&first) > 1; --cpu) CPU_CLR(cpu, &first);
  ASSERT_EQ(sched_setaffinity(0, sizeof first, &first), 0);
  EXPECT_EQ(default_threads(), 1) << "bound to one processor";
}

TEST(NodeShare, ALauncherIsSeenBehindAScript) {
  char self[4096];
  const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
  ASSERT_GT(length, 0);
  self[length] = '\0';
  const std::string filter = " --gtest_filter=LaunchedProcess.*",
                    exe = std::string("'") + self + "'" + filter;
  const std::string nested = "sh -c \"" + exe + "; exit \\$?\"; exit $?";
  for (const std::string& command : {"exec " + exe, exe + "; exit $?", nested}) {
    std::vector<std::string> variables{"PMI_LOCAL_SIZE=2", "MFS_TEST_LAUNCHER=" + std::to_string(getpid())};
    for (char** variable = environ; *variable != nullptr; ++variable) variables.emplace_back(*variable);
    std::vector<char*> environment;
    for (std::string& variable : variables) environment.push_back(variable.data());
    environment.push_back(nullptr);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      execle("/bin/sh", "sh", "-c", command.c_str(), nullptr, environment.data());
      _exit(127);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command << ": status " << status;
  }
}

int threads_of_new_solver(int asked = 0, Backend backend = Backend::openmp) {
  Options options;
  options.threads = asked;
  options.backend = backend;
  Solver solver(options);
  const SparseMatrix a = grid_2d(5, 4);
  solver.analyze(a.view());
  return solver.report().threads;
}

TEST(DefaultThreads, WhoDecides) {
  EXPECT_EQ(default_threads(), own_processors());
  const Variable ranks("OMPI_COMM_WORLD_LOCAL_SIZE", "100000");
  EXPECT_EQ(threads_of_new_solver(), 1) << "the share of the node";
  {
    const Variable variable("MFS_NUM_THREADS", "3");
    EXPECT_EQ(threads_of_new_solver(), 3) << "MFS_NUM_THREADS before the share";
    set_default_threads(4);
    EXPECT_EQ(default_threads(), 4);
    EXPECT_EQ(threads_of_new_solver(), 4) << "set_default_threads before MFS_NUM_THREADS";
    EXPECT_EQ(threads_of_new_solver(2), 2) << "Options::threads before all";
    EXPECT_EQ(threads_of_new_solver(0, Backend::serial), 1);
    set_default_threads(0);
    EXPECT_EQ(threads_of_new_solver(), 3);
  }
  for (const char* nothing : {"", "0"}) {
    const Variable variable("MFS_NUM_THREADS", nothing);
    EXPECT_EQ(threads_of_new_solver(), 1);
  }
}

TEST(DefaultThreads, ASolverKeepsWhatItWasMadeWith) {
  const SparseMatrix a = grid_2d(5, 4);
  set_default_threads(2);
  Solver solver;
  set_default_threads(1);
  solver.factor(a.view());
  EXPECT_EQ(solver.report().threads, 2);
  solver.analyze(a.view());
  EXPECT_EQ(solver.report().threads, 2);
  set_default_threads(0);
}

TEST(DefaultThreads, WrongNumbersAreRefused) {
  for (const int wrong : {-1, 513}) EXPECT_THROW(set_default_threads(wrong), InvalidInput) << wrong;
  for (const char* wrong : {"-1", "513", "two", "2 threads", "1e1", "99999999999999999999"}) {
    const Variable variable("MFS_NUM_THREADS", wrong);
    try {
      Solver solver;
      ADD_FAILURE() << wrong << " was taken";
    } catch (const InvalidInput& error) {
      EXPECT_EQ(error.argument(), "MFS_NUM_THREADS");
      EXPECT_THAT(error.what(), testing::HasSubstr(wrong));
    }
    EXPECT_EQ(threads_of_new_solver(2), 2) << "not asked";
  }
  EXPECT_EQ(default_threads(), own_processors());
}

}  // namespace
}  // namespace mfs::test
