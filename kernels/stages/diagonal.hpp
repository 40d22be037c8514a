// The entries of the factors on the diagonal.
#pragma once

#include "kernels/runtime/dispatch.hpp"
#include "kernels/stages/front_store.hpp"

namespace mfs {

template <class S, class Value>
struct GatherDiagonal {
  FrontStore<S, Value> store;
  Vertex fronts;
  S* to;
  KOKKOS_FUNCTION void operator()(Offset position) const {
    const Vertex after = static_cast<Vertex>(position) + 1;
    const Vertex f = lower_bound(store.pivot_begin, fronts + 1, after) - 1;
    const Front<S> front = store.front(f);
    to[position] = front.lower[(position - store.pivot_begin[f]) * (front.lower_ld + Offset(1))];
  }
};
/// to[position] = the entry of the factors there, a pivot or its inverse, for all n positions; in the memory
/// of the space.
template <class Exec, class S, class Value>
void gather_diagonal(const Exec& exec, const FrontStore<S, Value>& store, Vertex fronts, S* to) {
  for_each_index(exec, "mfs::diagonal", store.n, GatherDiagonal<S, Value>{store, fronts, to});
}

}  // namespace mfs
