// The stages of all depths, for an execution space of the host: small fronts in groups, each front through
// all chosen stages in one go while it is in cache; large fronts each by one worker, with help from those
// that have nothing else to do (kernels/runtime/workers.hpp).
#pragma once

#include "kernels/runtime/workers.hpp"
#include "kernels/stages/assemble.hpp"
#include "kernels/stages/host_ops.hpp"
#include "kernels/stages/solve.hpp"
#include "kernels/stages/variable_factor.hpp"
#include "kernels/stages/variable_update.hpp"
#include "plan/schedule.hpp"

namespace mfs {

/// Which stages to run: production runs all, tests run one.
struct Stages {
  bool assemble = true, factor = true, update = true;
};

/// Divides the pivot block as SymbolicPlan::block_width does.
inline Vertex block_width(Vertex pivots, Vertex max_block_size) {
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

/// While others may add to it.
inline double flops_done(FactorStatus& status) {
  return Kokkos::atomic_fetch_add(&status.getrf, 0.0) + Kokkos::atomic_fetch_add(&status.trsm, 0.0) +
         Kokkos::atomic_fetch_add(&status.gemm, 0.0);
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

/// The list of a depth: each large front is an item that is shared, each group of small ones one that is not.
inline WorkList work_list(const DepthSchedule& depth) {
  return {static_cast<Vertex>(depth.large.size()), static_cast<Vertex>(depth.group_begin.size()) - 1};
}

/// Calls large(f, threads that it is worth) or small(f) for each front of item i of a depth's list.
template <class Large, class Small>
void for_each_front(const DepthSchedule& depth, Vertex i, const Large& large, const Small& small) {
  const Vertex group = i - static_cast<Vertex>(depth.large.size());
  if (group < 0) return large(depth.large[i], depth.share[i]);
  for (Vertex k = depth.group_begin[group]; k < depth.group_begin[group + 1]; ++k) small(depth.small[k]);
}

/// Factors all fronts of `count` consecutive depths; done(k) is called when depths[k] is finished.
template <class Exec, class Scalar, class Value, class Done>
void factor_depths(const Exec& exec, Workers& workers, const FrontStore<Scalar, Value>& store,
                   const DepthSchedule* depths, std::size_t count, const PivotRule& rule, Stages stages,
                   const Done& done) {
  const auto factor_small = [&](Vertex f) {
    if (stages.assemble) assemble_columns(store, f, 0, store.front(f).rows());
    factor_and_update(SequentialOps(), store, f, rule, stages);
  };
  const auto factor_large = [&](const Worker& worker, Vertex f, int share) {
    constexpr Vertex kColumns = 64;
    const Vertex rows = store.front(f).rows();
    if (stages.assemble) {
      worker.for_each_tile((rows + kColumns - 1) / kColumns, [&](Vertex tile) {
        assemble_columns(store, f, tile * kColumns, std::min((tile + 1) * kColumns, rows));
      });
    }
    factor_and_update(TiledOps(worker, TileSizes(share)), store, f, rule, stages);
  };
  workers.run(
      exec, "mfs::factor", count, [&](std::size_t k) { return work_list(depths[k]); },
      [&](const Worker& worker, std::size_t k, Vertex i) {
        for_each_front(
            depths[k], i, [&](Vertex f, int share) { factor_large(worker, f, share); }, factor_small);
      },
      done);
}

/// Forward substitution of consecutive depths, or backward substitution of the same in opposite order.
struct Substitution {
  bool forward, backward, transposed;
};
template <class Exec, class Scalar, class Value>
void solve_depths(const Exec& exec, Workers& workers, const FrontStore<Scalar, Value>& store,
                  const DepthSchedule* depths, std::size_t count, const SolveVectors<Scalar>& vectors,
                  const Substitution& what) {
  const std::size_t forward = what.forward ? count : 0, backward = what.backward ? count : 0;
  const auto depth_of = [=](std::size_t k) -> const DepthSchedule& {
    return k < forward ? depths[k] : depths[count - 1 - (k - forward)];
  };
  workers.run(
      exec, "mfs::solve", forward + backward, [&](std::size_t k) { return work_list(depth_of(k)); },
      [&](const Worker& worker, std::size_t k, Vertex i) {
        const auto solve_front = [&](const auto& split, Vertex f) {
          if (k < forward) {
            forward_front(split, store, vectors, f, what.transposed);
          } else {
            backward_front(split, store, vectors, f, what.transposed);
          }
        };
        for_each_front(
            depth_of(k), i, [&](Vertex f, int) { solve_front(TiledSplit{worker}, f); },
            [&](Vertex f) { solve_front(SequentialSplit(), f); });
      },
      [](std::size_t) {});
}

}  // namespace mfs
