#include <mfs/version.hpp>

#include <camd.h>
#include <metis.h>

#include <Kokkos_Core.hpp>

#include "kernels/cuda/cuda_factors.hpp"
#include "kernels/dense/blas.hpp"
#include "solver/backend.hpp"
#include "solver/option_checks.hpp"

namespace mfs {

namespace {

std::string dotted(int major, int minor, int patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

}  // namespace

const char* version() {
  return MFS_VERSION;
}

std::vector<Backend> backends() {
  std::vector<Backend> present;
  for (const Backend backend : {Backend::serial, Backend::openmp, Backend::cuda, Backend::kokkos}) {
    if (rules_of(backend).present()) present.push_back(backend);
  }
  return present;
}

std::vector<DeviceInfo> devices() {
  std::vector<DeviceInfo> found;
  for (const cuda::DeviceFacts& facts : cuda::devices()) {
    found.push_back({facts.name, facts.compute_capability, facts.code, facts.multiprocessors, facts.bytes,
                     facts.shared_memory, facts.tensor_cores, facts.single_to_double,
                     automatic_precision(facts.single_to_double), facts.tile, facts.small_rows});
  }
  return found;
}

BackendInfo backend_info(Backend backend) {
  return rules_of(backend).info();
}

std::string better_blas_kernels() {
  return blas::better_kernels();
}

std::vector<LibraryInfo> libraries() {
  return {{"Kokkos", dotted(KOKKOS_VERSION / 10000, KOKKOS_VERSION / 100 % 100, KOKKOS_VERSION % 100)},
          {"METIS", dotted(METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR)},
          {"CAMD", dotted(CAMD_MAIN_VERSION, CAMD_SUB_VERSION, CAMD_SUBSUB_VERSION)},
          {"BLAS", blas::library_name()}};
}

}  // namespace mfs
