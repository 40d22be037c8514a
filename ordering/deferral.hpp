// Where multipliers stand in the elimination order (the constraint order of saddle-point matrices: de Niet
// and Wubs 2009; Tuma 2002). An unknown with a weak diagonal gets a pivot from the elimination of a partner,
// an unknown with a good diagonal that it is coupled to:
//
//          u   l                  u    l
//     u    k   b     u first      k    b
//     l    b   0     ------->     .  -b^2/k        so l may stand anywhere behind u,
//                                                  and no two l share a partner
//
// An order that was found for fill alone puts many weak unknowns before the partner that the matching gave
// them. Most of these have another one before them; those that have none move, to just behind a partner.
#pragma once

#include <vector>

#include "ordering/graph.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// `order` (position -> vertex of `partition`) with the vertices moved back whose weak unknowns lack a
/// partner before them, and how many vertices that are.
struct Deferral {
  std::vector<Vertex> order;
  Vertex moved = 0;
};
Deferral defer_weak_unknowns(const WeakUnknowns& weak, const Partition& partition,
                             const std::vector<Vertex>& order);

}  // namespace mfs
