// What the device kernels work on beside the FrontStore: pivoting state and the lists of the DevicePlan.
#pragma once

#include "kernels/cuda/runtime/device_scalar.hpp"
#include "kernels/dense/panel_lu.hpp"
#include "kernels/stages/front_store.hpp"
#include "kernels/stages/strict_fronts.hpp"
#include "plan/device_plan.hpp"

namespace mfs::cuda {

template <class S, class Value>
struct DeviceStore {
  FrontStore<S, Value> fronts;

  int* strict;            // by front: its state
  int* found_strict;      // fronts that became strict in this factorization
  int* pivots_needed;     // whether a root of this factorization should have been searched for pivots
  const double* largest;  // scaled entry of the matrix
  PivotRule pivots;       // relative to it
  int tile;               // pivots of a diagonal tile, at most kTile<S>
  bool substitutes;       // with U, whose diagonal blocks are left as they are, else inverted
  int tall;               // strict fronts of more pivots are factored by launches for each panel,
  bool by_panels;         // where those are launched
  int* panel_rows;        // by task of such a launch: the rows that those of its panel were exchanged with
  S* panel_border;        // at StepTask::border_at: border rows of its panel

  const Vertex *small_fronts, *tiny_fronts;
  const AssemblyPart* assemble;
  const FrontPart *exchange, *wide_tiles, *unpivoted;
  const SolvePart* solve;
  const StepTask* steps;
  const ProductTask* products;
  const Offset* row_begin;
  const Vertex *source_begin, *destination;
  const Offset* child_row_begin;
  const Vertex* child_row;
  const Vertex* entry_place;
  const Offset *solve_lower, *solve_upper;  // where segments have other places in a solve
  const Offset* block_read;  // where the contribution block of a front is read, from `storage` on
  const char* divided;       // by front; null where none is
  Vertex* row_place;         // n, where some front is divided: local_row the other way round

  __device__ PivotRule rule() const { return pivots.times(*largest); }
  __device__ PivotRule tile_rule() const { return rule_of_tiles(rule(), substitutes); }
  __device__ bool is_strict(Vertex f) const { return strict[f] & kStrict; }
  __device__ bool goes_by_panels(Vertex f, int front_pivots) const {
    return by_panels && front_pivots > tall && is_strict(f);
  }
  /// U is made when all pivots are known, in segments of its own.
  __device__ bool is_divided(Vertex f) const { return divided && divided[f]; }
  __device__ void make_strict(Vertex f) const {
    if (!(atomicOr(strict + f, kBecomesStrict) & kBecomesStrict)) atomicAdd(found_strict, 1);
  }
  __device__ void need_strict(Vertex f) const { atomicOr(strict + f, kNeedsStrict); }
};

/// The task that `place` belongs to: the last of `count` whose `first` member is not beyond it. One warp
/// searches 32 tasks at a time.
template <class Task>
__device__ int find_task(const Task* tasks, int count, Vertex Task::*first, int place) {
  const int lane = threadIdx.x % 32;
  int begin = 0;
  while (count > 1) {
    const int step = (count + 31) / 32, candidate = lane * step;
    const bool before = candidate < count && tasks[begin + candidate].*first <= place;
    const int last = 31 - __clz(__ballot_sync(0xffffffffu, before));
    begin += last * step;
    count = min(step, count - last * step);
  }
  return begin;
}

/// What a block may have on devices of compute capability 9.0, and on the least that are supported (8.6).
constexpr std::size_t kMostSharedMemory = 227 * 1024, kLeastSharedMemory = 99 * 1024;

/// Pivots per block column where a block may have kMostSharedMemory; where it may have less, perhaps half of
/// it (device_limits).
template <class S>
constexpr int kTile = sizeof(S) <= 8 ? 128 : 64;
/// Rows of the largest front that is factored in shared memory as a whole, there.
template <class S>
constexpr int kSmallRows = sizeof(S) <= 8 ? 160 : 96;

}  // namespace mfs::cuda
