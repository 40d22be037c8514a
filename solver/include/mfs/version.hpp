// Versions of the library and of those that it uses, and its backends.
#pragma once

#include <cstdint>
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

/// A CUDA device, and what Backend::cuda uses of it.
struct DeviceInfo {
  std::string name;
  int compute_capability = 0;  ///< 10 major + minor
  int code = 0;                ///< compute capability that the kernels were compiled for
  int multiprocessors = 0;
  std::int64_t bytes = 0;                 ///< of memory
  std::int64_t shared_memory = 0;         ///< bytes that a thread block may have
  bool tensor_cores = false;              ///< make the products of double precision
  int single_to_double = 0;               ///< how many times as fast it computes in single precision
  Precision precision = Precision::full;  ///< Precision::automatic of double precision matrices
  int tile = 0;        ///< pivots that are eliminated at once in a large front, double precision
  int small_rows = 0;  ///< rows of the largest front that is factored in shared memory as a whole
};

/// Version of the loaded libmfs (compare with MFS_VERSION of the headers).
MFS_API const char* version();
/// Backends compiled into this library and usable on this machine.
MFS_API std::vector<Backend> backends();
/// The CUDA devices of this machine; empty where the library has no Backend::cuda.
MFS_API std::vector<DeviceInfo> devices();
/// Facts of a backend, whether it is usable on this machine or not. The rates were measured on the machines
/// in docs/performance.md. Callers choose between algorithms by them, so that no choice depends on the
/// machine.
struct BackendInfo {
  MemorySpace memory;  ///< where the factors lie; with `device`, refactor_device and solve_device can be used
  double factor_rate;  ///< operations per second in the factorization of a large matrix
  double flops_per_entry;  ///< operations that a factorization does while a solve uses one entry of L or U
};
/// Throws InvalidInput where the value is none of the enumerators.
MFS_API BackendInfo backend_info(Backend backend);
/// Names and versions of Kokkos, METIS, CAMD and BLAS, as far as these tell them.
MFS_API std::vector<LibraryInfo> libraries();
/// The value that the environment variable OPENBLAS_CORETYPE should have when the program is started, because
/// OpenBLAS does not know this processor and uses kernels of an old one, at a third of the speed. Empty where
/// it does.
MFS_API std::string better_blas_kernels();

}  // namespace mfs
