// The one seam to cuSOLVER: the LU of a matrix that is large enough to fill the device by itself.
#pragma once

#include <memory>
#include <vector>

#include "kernels/cuda/runtime/device.hpp"

namespace mfs::cuda {

class DeviceLapack {
 public:
  /// What a handle holds of the device (100 MB of an H200, cuSOLVER 12.0).
  static constexpr Offset kHandleBytes = Offset(100) << 20;

  /// Works in `stream`, which must outlive it. Throws BackendError("cuSOLVER"), OutOfMemory.
  explicit DeviceLapack(const Stream& stream);

  /// Takes the memory to work in for getrf of such a matrix, if it has less.
  template <class S>
  void reserve(int n, const S* a, int lda);

  /// A (n x n, column-major, in device memory) = L U in its place, without pivoting: where a pivot is zero,
  /// what follows is no number. S as device code calls it; memory must have been reserved.
  template <class S>
  void getrf(int n, S* a, int lda);

  /// Of device memory.
  Offset bytes() const { return kHandleBytes + (workspace_ ? workspace_->bytes() : 0); }

 private:
  struct DestroyHandle {
    void operator()(void* handle) const;
  };
  struct DestroyParameters {
    void operator()(void* parameters) const;
  };
  std::unique_ptr<void, DestroyHandle> handle_;
  std::unique_ptr<void, DestroyParameters> parameters_;
  std::unique_ptr<DeviceArena> workspace_;  // and at its begin what cuSOLVER says of the pivots
  std::vector<char> host_workspace_;
};

}  // namespace mfs::cuda
