// The one seam to cuBLAS: products that are large enough to fill the device one by one.
#pragma once

#include <array>
#include <memory>

#include "kernels/cuda/runtime/device.hpp"

namespace mfs::cuda {

class DeviceBlas {
 public:
  /// Works in `stream`, which must outlive it, with memory of its own. Throws BackendError("cuBLAS"),
  /// OutOfMemory.
  explicit DeviceBlas(const Stream& stream);
  ~DeviceBlas();

  /// C (m x n) -= A (m x k) B (k x n), column-major, in device memory; S as device code calls it.
  template <class S>
  void gemm_minus(int m, int n, int k, const S* a, int lda, const S* b, int ldb, S* c, int ldc) const;

  /// Of device memory.
  Offset bytes() const { return workspace_.bytes(); }

 private:
  struct Destroy {
    void operator()(void* handle) const;
  };
  /// What the library is asked for: sizes, leading dimensions, and what the operands are multiples of.
  using Shape = std::array<unsigned, 9>;
  struct Algorithms;
  const Stream& stream_;
  DeviceArena workspace_;
  std::unique_ptr<Algorithms> chosen_;  // by shape: to choose one takes as long as a small product
  std::unique_ptr<void, Destroy> handle_;
};

}  // namespace mfs::cuda
