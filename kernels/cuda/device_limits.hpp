// For which sizes work is cut on a device (DeviceLimits), by what blocks of its kernels may have of shared
// memory.
#pragma once

#include <mfs/error.hpp>

#include <string>

#include "kernels/cuda/factor/block_lu.hpp"
#include "kernels/cuda/factor/products.hpp"
#include "kernels/cuda/factor/small_fronts.hpp"
#include "kernels/cuda/factor/strips.hpp"
#include "kernels/cuda/runtime/device.hpp"
#include "kernels/cuda/solve/substitution.hpp"
#include "kernels/cuda/solve/tile_inverses.hpp"
#include "kernels/dense/device_lapack.hpp"
#include "kernels/factors.hpp"
#include "plan/device_plan.hpp"

namespace mfs::cuda {

/// Roots of so many pivots go to cuSOLVER, whose handle may take this part of the factors' memory.
constexpr Vertex kLeastRoot = 1024;
constexpr Offset kHandleShare = 10;

/// Tiles and strips as large as `memory` bytes a block allow, a wider tile before longer strips: it makes
/// half as many passes over what is right of it.
template <class S>
bool cut_tiles(std::size_t memory, DeviceLimits& limits) {
  for (const Vertex tile : {kTile<S>, kNarrowTile<S>}) {
    for (const Vertex strip : {kStrip, kShortStrip}) {
      limits.tile = tile;
      limits.strip = strip;
      if (block_lu_bytes<S>(tile) <= memory && strip_bytes<S>(tile / kInverted, strip) <= memory) return true;
    }
  }
  return false;
}

/// For kernels with the numbers S on a device of so many multiprocessors, a block of which may have `memory`
/// bytes. Throws BackendError where that is too little.
template <class S>
DeviceLimits device_limits(int multiprocessors, std::size_t memory, Vertex least_root) {
  static_assert(kSmallRows<S> <= kAssemblyTurns.rows);
  static_assert(strip_bytes<S>(kTile<S> / kInverted, kStrip) <= kMostSharedMemory);
  static_assert(small_front_bytes<S>(kSmallRows<S>) <= kMostSharedMemory);
  static_assert(substitution_bytes<S, kSolveColumns>() <= kMostSharedMemory);
  static_assert(substitution_bytes<S, 1>() <= kLeastSharedMemory);
  static_assert(sizeof(TileInverseWork<S>) <= kLeastSharedMemory);
  static_assert(ShortShape::bytes<S>() <= kLeastSharedMemory);
  static_assert(!kWideProducts<S> || WideShape::bytes<S>() <= kLeastSharedMemory);
  DeviceLimits limits{kTile<S>, kSmallRows<S>, kWideProducts<S>, kStrip, multiprocessors};
  if (memory < kLeastSharedMemory || !cut_tiles<S>(memory, limits)) {
    throw BackendError("CUDA", 0,
                       "a block of this device may have " + std::to_string(memory) +
                           " bytes of shared memory; the kernels need " + std::to_string(kLeastSharedMemory));
  }
  while (small_front_bytes<S>(limits.small_rows) > memory) limits.small_rows -= 16;
  limits.panel_entries = strict_panel_entries<S>(std::min(memory, kMostSharedMemory));
  limits.least_root = least_root;
  return limits;
}
/// Of the current device.
template <class S>
DeviceLimits device_limits(Vertex least_root) {
  return device_limits<S>(multiprocessors(), static_cast<std::size_t>(shared_memory_per_block()), least_root);
}
template <class S>
Vertex least_root_for(const SymbolicPlan& plan) {
  const Offset factors = plan.factor_entries * static_cast<Offset>(sizeof(S));
  return DeviceLapack::kHandleBytes <= factors / kHandleShare ? kLeastRoot : kNoRoots;
}

}  // namespace mfs::cuda
