// From which sizes on work is cut in which way, by what the teams of a space have.
#pragma once

#include <algorithm>
#include <limits>

#include "kernels/portable/small_fronts.hpp"
#include "kernels/portable/steps.hpp"
#include "kernels/portable/substitution.hpp"
#include "plan/device_plan.hpp"

namespace mfs::portable {

constexpr Vertex kNever = std::numeric_limits<Vertex>::max() / 2;

struct Sizes {
  DeviceLimits limits;
  // Of the solve: fronts of up to so many pivots are one team's.
  Vertex whole = 0, solve_tile = 0;
  Vertex most_chunk = 0;     // border rows of a task
  Vertex most_gathered = 0;  // unknowns that a team brings together at a time
  int host_team = 1;         // threads of a team on the host: more than one in tests, without a library only
};

/// One thread of the host has all fronts as a whole. Others share those that are more than a few hundred
/// microseconds of work; tiles of 128 pivots are narrow enough for the panel, which is one thread's, and wide
/// enough for products of OpenBLAS.
inline Sizes sizes_for_library(int threads) {
  Sizes sizes;
  sizes.limits.tile = 128;
  sizes.limits.small_rows = threads == 1 ? kMostSmallRows : 256;
  sizes.limits.small_step = kMostSmallRows;
  sizes.limits.small_part = 0.25 / threads;
  sizes.limits.whole_columns = true;
  sizes.limits.strip = 256;
  sizes.limits.product_rows = sizes.limits.product_columns = 256;
  sizes.whole = threads == 1 ? kNever : 256;
  sizes.solve_tile = sizes.most_chunk = sizes.most_gathered = 256;
  return sizes;
}

/// The largest tile and the largest small front that fit the scratch memory of a team.
template <class S>
Sizes sizes_for_teams(Offset scratch_bytes) {
  Sizes sizes;
  DeviceLimits& limits = sizes.limits;
  limits.tile = kInvertedBlock;
  while (limits.tile < kMostTile && diagonal_bytes<S>(limits.tile + kInvertedBlock) <= scratch_bytes)
    limits.tile += kInvertedBlock;
  limits.small_rows = 1;
  while (limits.small_rows < std::min(kAssemblyTurns.rows, kMostPanelRows) &&
         small_front_bytes<S>(limits.small_rows + 1) <= scratch_bytes)
    ++limits.small_rows;
  limits.strip = kStripRows;
  limits.product_rows = limits.product_columns = OwnDense<S>::kTileRows;
  limits.vendor_depth = limits.tile;
  limits.panel = 8 * limits.tile;
  limits.slab = 4 * limits.panel;
  limits.panelled = 2 * limits.panel;
  limits.panelled_rows = 2 * limits.panel;
  sizes.whole = sizes.solve_tile = sizes.most_chunk = 64;
  sizes.most_gathered = 512;
  return sizes;
}

template <class Exec, class S, class Dense>
Sizes sizes_for(int threads) {
  Sizes sizes = Dense::kSearchesAll ? sizes_for_library(threads) : sizes_for_teams<S>(scratch_bytes<Exec>());
  sizes.limits.wide_products = false;
  sizes.limits.ahead_tiles = Dense::kSearchesAll ? 2 * threads : std::numeric_limits<Offset>::max();
  sizes.limits.many_tiny = kNever;
  if (Dense::kSearchesAll) sizes.limits.panelled = kNever;
  if (!Space<Exec>::Queue::kLibrary) sizes.limits.vendor_entries = std::numeric_limits<Offset>::max();
  return sizes;
}

}  // namespace mfs::portable
