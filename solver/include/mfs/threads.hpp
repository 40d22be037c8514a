// How many threads a solver has where nobody says it (Options::threads = 0). The first of these that is there
// decides:
//   1. set_default_threads;
//   2. the environment variable MFS_NUM_THREADS, from 1 to 512 (empty or 0: as if it were not there);
//   3. the processors that this process may use, by its affinity mask and the quota of its control groups (a
//      container's limit, rounded up), divided by the processes that the launcher of MPI has
//      started beside it on this node. Their number stands in the environment (of Open MPI, MPICH, Intel MPI,
//      MVAPICH, Cray PALS and Slurm's srun), so nobody has to be asked. A process that its launcher has bound
//      to processors of its own keeps them all.
// All are looked at when a solver is made; what it was made with, it keeps.
#pragma once

#include <mfs/export.hpp>

namespace mfs {

/// Threads of every solver of this process that is made from now on with Options::threads = 0; 0 takes it
/// back. May be called from any thread. Throws InvalidInput below 0 or above 512.
MFS_API void set_default_threads(int threads);

/// The threads of a solver that is made now with Options::threads = 0 (Backend::serial has one). Throws
/// InvalidInput where MFS_NUM_THREADS is no such number, OutOfMemory.
MFS_API int default_threads();

}  // namespace mfs
