// Version of the library and of what it stands on.
#pragma once

#include <string>
#include <vector>

#include <mfs/error.hpp>
#include <mfs/export.hpp>
#include <mfs/options.hpp>

#define MFS_VERSION_MAJOR 0
#define MFS_VERSION_MINOR 1
#define MFS_VERSION_PATCH 0
#define MFS_VERSION "0.1.0"

namespace mfs {

struct LibraryInfo {
  std::string name;
  std::string version;
};

/// Version of the loaded libmfs (compare with MFS_VERSION of the headers).
MFS_API const char* version();
/// Backends compiled into this library and usable on this machine.
MFS_API std::vector<Backend> backends();
/// What a backend is, whether this library has it or not. The rates are of the machines in
/// docs/performance.md; they choose between ways of which one is much faster, and no result depends on the
/// machine at hand.
struct BackendInfo {
  MemorySpace memory;  ///< where the factors lie; on `device`, refactor_device and solve_device take arrays
  double factor_rate;  ///< operations per second in the factorization of a large matrix
  double flops_per_entry;  ///< operations for which a factorization takes as long as a solve for an entry of
                           ///< L or U
};
/// Throws InvalidInput for what is no backend.
MFS_API BackendInfo backend_info(Backend backend);
/// Kokkos, METIS, CAMD, BLAS, ... with their versions as far as they tell.
MFS_API std::vector<LibraryInfo> libraries();
/// An OpenBLAS that does not know this processor works with kernels of an old one, at a third of the speed.
/// What the environment variable OPENBLAS_CORETYPE should say then, when the program is started; else empty.
MFS_API std::string better_blas_kernels();

}  // namespace mfs
