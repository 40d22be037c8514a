// The functions of libcudss, found at run time: the program that measures it runs without it as well. And
// what a system takes of it.
#pragma once

#include <stdexcept>

#ifndef MFS_CUDSS

namespace mfs::perf {

[[noreturn]] inline void refuse_cudss() {
  throw std::runtime_error("built without cuDSS: configure with -DMFS_CUDSS_INCLUDE=<folder of cudss.h>");
}

}  // namespace mfs::perf

#else

#include <cuda_runtime.h>
#include <cudss.h>
#include <dlfcn.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "perf/device_array.hpp"

namespace mfs::perf {

inline void check(cudssStatus_t status, const char* what) {
  if (status != CUDSS_STATUS_SUCCESS)
    throw std::runtime_error(std::string(what) + ": cuDSS status " + std::to_string(status));
}

class CudssLibrary {
 public:
  /// From `folder`, which also holds the threading layer. Throws std::runtime_error.
  explicit CudssLibrary(const std::string& folder)
      : library_(open(folder + "/libcudss.so")),
        threading_layer(find(folder + "/libcudss_mtlayer_gomp.so")) {}

 private:
  // Of the wheel there is the name with the version only, of the Debian package both.
  static std::string find(const std::string& path) {
    for (const char* suffix : {"", ".1", ".0"}) {
      if (void* const found = dlopen((path + suffix).c_str(), RTLD_LAZY)) {
        dlclose(found);
        return path + suffix;
      }
    }
    throw std::runtime_error(dlerror());
  }
  static void* open(const std::string& path) { return dlopen(find(path).c_str(), RTLD_NOW); }
  template <class Function>
  Function* symbol(const char* name, Function*) const {
    void* const found = dlsym(library_, name);
    if (!found) throw std::runtime_error(std::string("libcudss has no ") + name);
    return reinterpret_cast<Function*>(found);
  }

  void* library_;  // stays loaded: what it registered with the CUDA runtime lives as long as the process

 public:
  std::string threading_layer;
#define MFS_CUDSS_FUNCTION(name) decltype(&::name) const name = symbol(#name, decltype (&::name)())
  MFS_CUDSS_FUNCTION(cudssCreate);
  MFS_CUDSS_FUNCTION(cudssDestroy);
  MFS_CUDSS_FUNCTION(cudssSetThreadingLayer);
  MFS_CUDSS_FUNCTION(cudssConfigCreate);
  MFS_CUDSS_FUNCTION(cudssConfigDestroy);
  MFS_CUDSS_FUNCTION(cudssConfigSet);
  MFS_CUDSS_FUNCTION(cudssDataCreate);
  MFS_CUDSS_FUNCTION(cudssDataDestroy);
  MFS_CUDSS_FUNCTION(cudssDataGet);
  MFS_CUDSS_FUNCTION(cudssMatrixCreateCsr);
  MFS_CUDSS_FUNCTION(cudssMatrixCreateDn);
  MFS_CUDSS_FUNCTION(cudssMatrixDestroy);
  MFS_CUDSS_FUNCTION(cudssExecute);
  MFS_CUDSS_FUNCTION(cudssGetProperty);
#undef MFS_CUDSS_FUNCTION
};

/// A general matrix on the device, or a uniform batch of one pattern, and what cuDSS keeps for it.
class CudssSystem {
 public:
  /// The arrays lie on the device; they and the library must outlive this. `threading_layer`: null: no
  /// threads of the host.
  CudssSystem(const CudssLibrary& library, const char* threading_layer, std::int64_t n, std::int64_t entries,
              int* offsets, int* columns, double* values)
      : lib_(library), n_(n) {
    check(lib_.cudssCreate(&handle_), "cudssCreate");
    if (threading_layer)
      check(lib_.cudssSetThreadingLayer(handle_, threading_layer), "cudssSetThreadingLayer");
    check(lib_.cudssConfigCreate(&config_), "cudssConfigCreate");
    check(lib_.cudssDataCreate(handle_, &data_), "cudssDataCreate");
    check(lib_.cudssMatrixCreateCsr(&matrix_, n_, n_, entries, offsets, nullptr, columns, values, CUDA_R_32I,
                                    CUDA_R_32I, CUDA_R_64F, CUDSS_MTYPE_GENERAL, CUDSS_MVIEW_FULL,
                                    CUDSS_BASE_ZERO),
          "cudssMatrixCreateCsr");
  }
  ~CudssSystem() {
    if (matrix_) lib_.cudssMatrixDestroy(matrix_);
    for (cudssMatrix_t vectors : vectors_) lib_.cudssMatrixDestroy(vectors);
    if (data_) lib_.cudssDataDestroy(handle_, data_);
    if (config_) lib_.cudssConfigDestroy(config_);
    if (handle_) lib_.cudssDestroy(handle_);
    cudaDeviceSynchronize();
  }
  CudssSystem(const CudssSystem&) = delete;
  CudssSystem& operator=(const CudssSystem&) = delete;

  template <class T>
  void set(cudssConfigParam_t parameter, T value, const char* what) {
    check(lib_.cudssConfigSet(config_, parameter, &value, sizeof value), what);
  }
  /// What this cuDSS does not know stays zero.
  template <class T>
  T get(cudssDataParam_t parameter) const {
    T value{};
    std::size_t written = 0;
    lib_.cudssDataGet(handle_, data_, parameter, &value, sizeof value, &written);
    return value;
  }
  /// Right-hand sides or solutions in an array of the device, until this ends.
  cudssMatrix_t vectors(double* values, int columns) {
    cudssMatrix_t made = nullptr;
    check(lib_.cudssMatrixCreateDn(&made, n_, columns, n_, values, CUDA_R_64F, CUDSS_LAYOUT_COL_MAJOR),
          "cudssMatrixCreateDn");
    vectors_.push_back(made);
    return made;
  }
  /// Waits for the end.
  void execute(int phase, cudssMatrix_t solution, cudssMatrix_t rhs, const char* what) {
    check(lib_.cudssExecute(handle_, phase, config_, data_, matrix_, solution, rhs), what);
    check(cudaDeviceSynchronize(), what);
  }

 private:
  const CudssLibrary& lib_;
  const std::int64_t n_;
  cudssHandle_t handle_ = nullptr;
  cudssConfig_t config_ = nullptr;
  cudssData_t data_ = nullptr;
  cudssMatrix_t matrix_ = nullptr;
  std::vector<cudssMatrix_t> vectors_;
};

}  // namespace mfs::perf

#endif
