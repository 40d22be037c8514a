// The stages of one depth, for an execution space of the host: small fronts one per thread, all chosen stages
// in one go while the front is in cache; large fronts one after another, each stage by all threads.
#pragma once

#include "kernels/assemble.hpp"
#include "kernels/host_ops.hpp"
#include "kernels/schedule.hpp"
#include "kernels/solve.hpp"
#include "kernels/variable_factor.hpp"
#include "kernels/variable_update.hpp"

namespace mfs {

/// Which stages to run: production runs all, tests run one.
struct Stages {
  bool assemble = true, factor = true, update = true;
};

/// Divides the pivot block as SymbolicPlan::block_width does.
KOKKOS_INLINE_FUNCTION Vertex block_width(Vertex pivots, Vertex max_block_size) {
  const Vertex blocks = (pivots + max_block_size - 1) / max_block_size;
  return (pivots + blocks - 1) / blocks;
}

inline void add_to_status(FactorStatus* status, const FrontTally& tally) {
  if (tally.perturbed)
    Kokkos::atomic_add(&status->perturbed, static_cast<unsigned long long>(tally.perturbed));
  if (tally.nonfinite)
    Kokkos::atomic_add(&status->nonfinite, static_cast<unsigned long long>(tally.nonfinite));
  Kokkos::atomic_add(&status->getrf, tally.flops.getrf);
  Kokkos::atomic_add(&status->trsm, tally.flops.trsm);
  Kokkos::atomic_add(&status->gemm, tally.flops.gemm);
}

template <class Ops, class Scalar, class Value>
void factor_and_update(const Ops& ops, const FrontStore<Scalar, Value>& store, Vertex f,
                       const PivotRule& rule, Stages stages) {
  const Front<Scalar> front = store.front(f);
  const Offset first = store.pivot_begin[f];
  FrontTally tally;
  if (stages.factor) {
    const Vertex width = block_width(front.pivots, store.max_block_size);
    tally = factor_front(ops, front, width, rule, store.interchange + first, store.shift + first,
                         store.work + first);
    follow_exchanges(front.pivots, width, store.interchange + first, store.local_row + first);
  }
  if (stages.update) tally.flops.gemm += update_front(ops, front);
  add_to_status(store.status, tally);
}

template <class Exec, class Scalar, class Value>
void factor_depth(const Exec& exec, const FrontStore<Scalar, Value>& store, const DepthSchedule& depth,
                  const PivotRule& rule, Stages stages = {}) {
  constexpr Vertex kTileColumns = 64;
  const Vertex* small = depth.small.data();
  for_each_team(exec, "mfs::fronts", static_cast<Vertex>(depth.small.size()),
                [=](const Team<Exec>& team, Vertex i) {
                  const Vertex f = small[i];
                  if (stages.assemble) assemble_columns(team, store, f, 0, store.front(f).rows());
                  factor_and_update(SequentialOps(), store, f, rule, stages);
                });
  for (const Vertex f : depth.large) {
    if (stages.assemble) assemble_large_front(exec, store, f, store.front(f).rows(), kTileColumns);
    factor_and_update(TiledOps<Exec>(exec), store, f, rule, stages);
  }
}

/// Forward substitution of one depth, or backward substitution.
template <class Exec, class Scalar, class Value>
void solve_depth(const Exec& exec, const FrontStore<Scalar, Value>& store, const DepthSchedule& depth,
                 const SolveVectors<Scalar>& vectors, bool forward, bool transposed) {
  const auto solve_front = [=](const auto& split, Vertex f) {
    if (forward) {
      forward_front(split, store, vectors, f, transposed);
    } else {
      backward_front(split, store, vectors, f, transposed);
    }
  };
  for (const Vertex f : depth.large) solve_front(TiledSplit<Exec>{exec}, f);
  const Vertex* small = depth.small.data();
  for_each_team(exec, "mfs::solve", static_cast<Vertex>(depth.small.size()),
                [=](const Team<Exec>&, Vertex i) { solve_front(SequentialSplit(), small[i]); });
}

}  // namespace mfs
