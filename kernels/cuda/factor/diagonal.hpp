// The pivots of a factorization as its tiles leave them: on the diagonal, inverted.
#pragma once

#include "kernels/runtime/dispatch.hpp"
#include "kernels/stages/front_store.hpp"

namespace mfs::cuda {

/// to[position] = 1 / pivot, for all n positions; device memory.
template <class S, class Value>
void gather_diagonal(const Kokkos::Cuda& exec, const FrontStore<S, Value>& store, Vertex fronts, S* to) {
  for_each_index(
      exec, "mfs::diagonal", store.n, KOKKOS_LAMBDA(Offset position) {
        const Vertex after = static_cast<Vertex>(position) + 1;
        const Vertex f = lower_bound(store.pivot_begin, fronts + 1, after) - 1;
        const Front<S> front = store.front(f);
        to[position] = front.lower[(position - store.pivot_begin[f]) * (front.lower_ld + Offset(1))];
      });
}

}  // namespace mfs::cuda
