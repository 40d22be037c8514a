// What a device needs to work for an executor.
#pragma once

#include "kernels/cuda/device.hpp"

namespace mfs::dae {

class DeviceQueue {
 public:
  /// Blocks of threads of a fold, and the most bytes that each of them leaves.
  static constexpr int kFoldBlocks = 256, kMostFolded = 64;

  cuda::Stream stream;
  cuda::Event marked;
  cuda::PinnedArena folded{Offset{kFoldBlocks} * kMostFolded};  ///< written by the device, read by the host
};

}  // namespace mfs::dae
