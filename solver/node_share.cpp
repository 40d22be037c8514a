#include "solver/node_share.hpp"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string>

#include "kernels/runtime/control_groups.hpp"

namespace mfs {

namespace {

// Set by the launcher for each rank: Open MPI, MPICH and Intel MPI, MVAPICH, Cray PMI and PALS.
constexpr const char* kLocalSizes[] = {"OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS",
                                       "MV2_COMM_WORLD_LOCAL_SIZE", "PMI_LOCAL_SIZE", "PALS_LOCAL_SIZE"};
// Set by srun alone. SLURM_TASKS_PER_NODE is also there for a single process that a batch script starts.
constexpr const char* kSlurmList = "SLURM_STEP_TASKS_PER_NODE";

int positive_number(const char* text) {
  char* end = nullptr;
  const long number = std::strtol(text, &end, 10);
  return end != text && *end == '\0' && number > 0 && number <= 1 << 20 ? static_cast<int>(number) : 0;
}

// Empty where it cannot be read.
std::string content_of_proc(pid_t process, const char* name) {
  const std::string path = "/proc/" + std::to_string(process) + "/" + name;
  std::string content;
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return content;
  try {
    char piece[4096];
    for (ssize_t length = 0; (length = read(file, piece, sizeof piece)) > 0;)
      content.append(piece, static_cast<std::size_t>(length));
  } catch (...) {
    close(file);
    throw;
  }
  close(file);
  return content;
}

bool started_with(pid_t process, const std::string& variable) {
  const std::string environment = '\0' + content_of_proc(process, "environ");
  return environment.find('\0' + variable + '=') != std::string::npos;
}

// 0 where there is none.
pid_t parent_of(pid_t process) {
  const std::string line = content_of_proc(process, "stat");  // PID (NAME) STATE PARENT ...
  const std::size_t name_end = line.rfind(") ");
  return name_end == std::string::npos || name_end + 4 >= line.size()
             ? 0
             : static_cast<pid_t>(std::strtol(line.c_str() + name_end + 4, nullptr, 10));
}

// 0 where the system does not tell.
int processors_of(pid_t process) {
  cpu_set_t set;
  CPU_ZERO(&set);
  return process > 0 && sched_getaffinity(process, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
}

}  // namespace

int entry_of_slurm_list(const char* list, int node) {
  int largest = 0;
  for (long first = 0;; ++list) {  // of the nodes that the next item stands for
    char* end = nullptr;
    const long count = std::strtol(list, &end, 10);
    if (end == list || count < 1 || count > 1 << 20) return 0;
    long nodes = 1;
    if (end[0] == '(' && end[1] == 'x') {
      list = end + 2;
      nodes = std::strtol(list, &end, 10);
      if (end == list || nodes < 1 || nodes > 1 << 20 || *end++ != ')') return 0;
    }
    if (node >= first && node < first + nodes) return static_cast<int>(count);
    largest = std::max(largest, static_cast<int>(count));
    first += nodes;
    list = end;
    if (*list == '\0') return largest;
    if (*list != ',') return 0;
  }
}

LocalRanks local_ranks() {
  for (const char* variable : kLocalSizes) {
    const char* text = std::getenv(variable);
    const int count = text != nullptr ? positive_number(text) : 0;
    if (count > 0) return {count, variable};
  }
  if (const char* list = std::getenv(kSlurmList)) {
    const char* node = std::getenv("SLURM_NODEID");
    const int count = entry_of_slurm_list(list, node != nullptr ? std::atoi(node) : -1);
    if (count > 0) return {count, kSlurmList};
  }
  return {};
}

pid_t launcher_of(const char* variable) {
  pid_t ancestor = getppid();
  while (ancestor > 0 && started_with(ancestor, variable)) ancestor = parent_of(ancestor);
  return ancestor;
}

int share_of_processors(int own, int launchers, int ranks) {
  return std::clamp(std::max(own, launchers) / ranks, 1, own);
}

int node_share(int own) {
  const LocalRanks ranks = local_ranks();
  if (ranks.count == 1) return own;
  const int launchers = processors_of(launcher_of(ranks.variable)), quota = processor_quota();
  return share_of_processors(own, quota > 0 ? std::min(launchers, quota) : launchers, ranks.count);
}

}  // namespace mfs
