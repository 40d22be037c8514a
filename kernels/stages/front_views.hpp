// The fronts as a worker sees them: each where the plan has it, or in a subtree, where contribution blocks
// lie on a stack (plan/subtrees.hpp).
#pragma once

#include "kernels/stages/front_store.hpp"

namespace mfs {

template <class Scalar, class Value>
struct PlannedFronts {
  const FrontStore<Scalar, Value>& store;
  Front<Scalar> operator()(Vertex f) const { return store.front(f); }
};

/// But for the blocks of the subtree's root, whose place is negative.
template <class Scalar, class Value>
struct StackedFronts {
  const FrontStore<Scalar, Value>& store;
  const Offset* place;
  Scalar* stack;
  Front<Scalar> operator()(Vertex f) const {
    Front<Scalar> front = store.front(f);
    if (place[f] >= 0) front.contribution = stack + place[f];
    return front;
  }
};

}  // namespace mfs
