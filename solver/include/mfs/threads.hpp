// The number of threads of a solver with Options::threads = 0. The first of these that is set decides:
//   1. set_default_threads;
//   2. the environment variable MFS_NUM_THREADS, from 1 to 512 (empty or 0: as if it were not there);
//   3. the processors that this process may use, divided by the number of ranks that MPI's launcher has
//   started
//      on this node. The affinity mask says which processors those are, and the quota of the control groups
//      (the limit of a container, rounded up) how many at most. The number of ranks is read from the
//      environment (of Open MPI, MPICH, Intel MPI, MVAPICH, Cray PALS and Slurm's srun). A rank that its
//      launcher has bound to processors of its own keeps them all.
// The number is found when a solver is made, and stays.
#pragma once

#include <mfs/export.hpp>

namespace mfs {

/// Sets the threads of every solver of this process that is made from now on with Options::threads = 0. 0
/// takes the setting back. May be called from any thread. Throws InvalidInput below 0 or above 512.
MFS_API void set_default_threads(int threads);

/// The threads of a solver that is made now with Options::threads = 0, from 1 to 512; a solver with
/// Backend::serial has one. Throws InvalidInput where MFS_NUM_THREADS is not a number from 0 to 512,
/// OutOfMemory.
MFS_API int default_threads();

}  // namespace mfs
