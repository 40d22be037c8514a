// The stages of a tree, for an execution space of the host: subtrees first, each by one worker; then depth
// after depth, small fronts in groups, large fronts each by one worker, with help from those that have
// nothing else to do (kernels/runtime/workers.hpp). Each front that one worker has goes through all chosen
// stages in one go while it is in cache.
#pragma once

#include "kernels/runtime/workers.hpp"
#include "kernels/stages/assemble.hpp"
#include "kernels/stages/front_views.hpp"
#include "kernels/stages/host_ops.hpp"
#include "kernels/stages/solve.hpp"
#include "kernels/stages/stack_pool.hpp"
#include "kernels/stages/variable_factor.hpp"
#include "kernels/stages/variable_update.hpp"
#include "plan/schedule.hpp"
#include "plan/subtrees.hpp"

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

/// What the fronts of an item did is added at once: all workers add to one place.
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
void factor_and_update(const Ops& ops, const FrontStore<Scalar, Value>& store, const Front<Scalar>& front,
                       Vertex f, const PivotRule& rule, Stages stages, FrontTally& tally) {
  const Offset first = store.pivot_begin[f];
  if (stages.factor) {
    const Vertex width = block_width(front.pivots, store.max_block_size);
    factor_front(ops, front, width, rule, store.interchange + first, store.shift + first, store.work + first,
                 tally);
    follow_exchanges(front.pivots, width, store.interchange + first, store.local_row + first);
  }
  if (stages.update) tally.flops.gemm += update_front(ops, front);
}

/// The list of a depth: each large front is an item that is shared, each group of small ones one that is not.
inline WorkList work_list(const DepthSchedule& depth) {
  return {static_cast<Vertex>(depth.large.size()), static_cast<Vertex>(depth.group_begin.size()) - 1};
}

/// Calls large(f, threads that it is worth) for item i of a depth's list, or small(fronts, count).
template <class Large, class Small>
void for_fronts(const DepthSchedule& depth, Vertex i, const Large& large, const Small& small) {
  const Vertex group = i - static_cast<Vertex>(depth.large.size());
  if (group < 0) return large(depth.large[i], depth.share[i]);
  const Vertex begin = depth.group_begin[group];
  small(depth.small.data() + begin, depth.group_begin[group + 1] - begin);
}

/// What a worker does to fronts in a factorization.
template <class Scalar, class Value>
struct FrontWork {
  const FrontStore<Scalar, Value>& store;
  const PivotRule& rule;
  Stages stages;

  /// A front that is this worker's alone, of those that `fronts` gives.
  template <class Fronts>
  void alone(const Fronts& fronts, Vertex f, FrontTally& tally) const {
    const Front<Scalar> front = fronts(f);
    if (stages.assemble) assemble_columns(store, fronts, f, 0, front.rows());
    factor_and_update(SequentialOps(), store, front, f, rule, stages, tally);
  }
  /// A front that others help with.
  void shared(const Worker& worker, Vertex f, int share, FrontTally& tally) const {
    constexpr Vertex kColumns = 64;
    const PlannedFronts<Scalar, Value> fronts{store};
    const Front<Scalar> front = fronts(f);
    const Vertex rows = front.rows();
    if (stages.assemble) {
      worker.for_each_tile((rows + kColumns - 1) / kColumns, [&](Vertex tile) {
        assemble_columns(store, fronts, f, tile * kColumns, std::min((tile + 1) * kColumns, rows));
      });
    }
    factor_and_update(TiledOps(worker, TileSizes(share)), store, front, f, rule, stages, tally);
  }
};

/// The tree as the workers go through it: subtrees, where there are any, then `count` consecutive depths.
struct TreeSchedule {
  const Subtrees* subtrees;  // or null
  const DepthSchedule* depths;
  std::size_t count;

  std::size_t lists() const { return count + before(); }
  std::size_t before() const { return subtrees != nullptr && subtrees->steps > 0 ? 1 : 0; }
  WorkList list(std::size_t k) const {
    return k < before() ? WorkList{0, subtrees->tasks()} : work_list(depths[k - before()]);
  }
};

/// Factors all fronts; done(k) is called when list k is finished, may_begin(k) before it is begun, as
/// Workers::run has them.
template <class Exec, class Scalar, class Value, class Done, class MayBegin = AtOnce>
void factor_tree(const Exec& exec, Workers& workers, StackPool& stacks,
                 const FrontStore<Scalar, Value>& store, const TreeSchedule& tree, const PivotRule& rule,
                 Stages stages, const Done& done, const MayBegin& may_begin = {}) {
  const FrontWork<Scalar, Value> work{store, rule, stages};
  const auto do_subtrees = [&](Vertex task, FrontTally& tally) {
    const Subtrees& subtrees = *tree.subtrees;
    const StackPool::Taken stack(stacks);
    const StackedFronts<Scalar, Value> fronts{store, subtrees.place.data(),
                                              store.storage + subtrees.stack[stack.number()]};
    for (Vertex k = subtrees.begin[task]; k < subtrees.begin[task + 1]; ++k)
      work.alone(fronts, subtrees.front[k], tally);
  };
  workers.run(
      exec, "mfs::factor", tree.lists(), [&](std::size_t k) { return tree.list(k); },
      [&](const Worker& worker, std::size_t k, Vertex i) {
        FrontTally tally;
        if (k < tree.before()) {
          do_subtrees(i, tally);
        } else {
          for_fronts(
              tree.depths[k - tree.before()], i,
              [&](Vertex f, int share) { work.shared(worker, f, share, tally); },
              [&](const Vertex* fronts, Vertex count) {
                for (Vertex m = 0; m < count; ++m)
                  work.alone(PlannedFronts<Scalar, Value>{store}, fronts[m], tally);
              });
        }
        add_to_status(store.status, tally);
      },
      done, may_begin);
}

/// Forward substitution of the tree, or backward substitution in opposite order: its lists follow those of
/// the other. done and may_begin are those of Workers::run.
struct Substitution {
  bool forward, backward, transposed;
};
template <class Exec, class Scalar, class Value, class Done = Unheard, class MayBegin = AtOnce>
void solve_tree(const Exec& exec, Workers& workers, const FrontStore<Scalar, Value>& store,
                const TreeSchedule& tree, const SolveVectors<Scalar>& vectors, const Substitution& what,
                const Done& done = {}, const MayBegin& may_begin = {}) {
  const std::size_t count = tree.lists();
  const std::size_t forward = what.forward ? count : 0, backward = what.backward ? count : 0;
  const auto list_of = [=](std::size_t k) { return k < forward ? k : count - 1 - (k - forward); };
  const auto alone = [&](bool down, const Vertex* fronts, Vertex count) {
    for_fronts_ahead(store, fronts, count, down, what.transposed, [&](Vertex f) {
      if (down) {
        backward_front(SequentialSplit(), store, vectors, f, what.transposed);
      } else {
        forward_front(SequentialSplit(), store, vectors, f, what.transposed);
      }
    });
  };
  const auto shared = [&](const Worker& worker, bool down, Vertex f) {
    if (down) {
      backward_front(TiledSplit{worker}, store, vectors, f, what.transposed);
    } else {
      forward_front(TiledSplit{worker}, store, vectors, f, what.transposed);
    }
  };
  const auto do_subtrees = [&](bool down, Vertex task) {
    const Vertex begin = tree.subtrees->begin[task], end = tree.subtrees->begin[task + 1];
    alone(down, tree.subtrees->front.data() + begin, end - begin);
  };
  workers.run(
      exec, "mfs::solve", forward + backward, [&](std::size_t k) { return tree.list(list_of(k)); },
      [&](const Worker& worker, std::size_t k, Vertex i) {
        const bool down = k >= forward;
        const std::size_t list = list_of(k);
        if (list < tree.before()) return do_subtrees(down, i);
        for_fronts(
            tree.depths[list - tree.before()], i, [&](Vertex f, int) { shared(worker, down, f); },
            [&](const Vertex* fronts, Vertex number) { alone(down, fronts, number); });
      },
      done, may_begin);
}

}  // namespace mfs
