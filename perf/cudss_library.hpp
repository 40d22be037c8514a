// The functions of libcudss, found at run time: the program that measures it runs without it as well.
#pragma once

#include <cudss.h>
#include <dlfcn.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace mfs::perf {

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

}  // namespace mfs::perf
