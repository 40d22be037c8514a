// Other direct solvers of the host as perf_host measures them: UMFPACK, KLU and CHOLMOD, which it is linked
// with, SuperLU and MUMPS where they are, and oneMKL's PARDISO, which it loads.
#pragma once

#include <string>
#include <vector>

#include "perf/measure.hpp"

namespace mfs::perf {

/// The solvers that this program was built with. "cholmod" takes symmetric positive definite matrices only.
std::vector<std::string> linked_peers();

/// What makes a solver of linked_peers(). Their threads are those of the BLAS. Throws std::invalid_argument.
MakeCandidate linked_peer(const std::string& name);

/// Two of them, each where this program was built with it.
std::unique_ptr<Candidate> make_superlu(const System& system);
std::unique_ptr<Candidate> make_mumps(const System& system);

/// PARDISO from `library`, a libmkl_rt.so or another library with the functions pardiso and
/// MKL_Set_Num_Threads. Throws std::runtime_error where it cannot be loaded.
MakeCandidate load_pardiso(const std::string& library, int threads);

}  // namespace mfs::perf
