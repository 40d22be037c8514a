// This process's part of the processors of its node, where a launcher of MPI has started several there.
//
//   launcher          may use 8 processors          mask of the launcher: 8
//   |- rank 0         not bound                     own mask 8            8 / 2 = 4
//   |- wrapper        bound to 0-3 by launcher
//      |- rank 1      bound to 0-3 as the wrapper   own mask 4, 8 / 2 =   4
//
// Nothing here is collective: a solver of a subdomain is made by one rank, at a time of its own.
#pragma once

#include <sys/types.h>

namespace mfs {

/// Processes of one launcher on this node, and the environment variable that says so; 1 and null where none
/// does.
struct LocalRanks {
  int count = 1;
  const char* variable = nullptr;
};
LocalRanks local_ranks();

/// Entry `node` of a list as Slurm writes it, "2(x3),1" for 2, 2, 2, 1; the largest where there is no such
/// entry; 0 where it is no such list.
int entry_of_slurm_list(const char* list, int node);

/// The nearest ancestor of this process that does not have `variable` in the environment that it was started
/// with: not a rank, nor a script around one. 0 where it is not to be seen.
pid_t launcher_of(const char* variable);

/// Threads for a process that may use `own` processors, as one of `ranks` whose launcher may use `launchers`
/// (0: unknown): an equal share of these, at most its own, at least 1.
int share_of_processors(int own, int launchers, int ranks);

/// The share of this process, which may use `own` processors. Throws std::bad_alloc.
int node_share(int own);

}  // namespace mfs
