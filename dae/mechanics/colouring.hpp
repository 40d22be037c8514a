// The order in which elements are added up. Elements of one colour share no coordinate, so that several
// threads may add them at the same time; colours follow one another. Each entry of a sum then receives its
// terms in an order that the number of threads has no part in. A coordinate of very many elements, as one of
// a body with hundreds of joints, would ask for as many colours of one element each:
// elements that find none of the 64 free, and those of colours too small to be worth the threads' meeting,
// are left for one thread at the end.
#pragma once

#include <cstddef>
#include <memory>
#include <set>
#include <vector>

#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

/// Fewer elements are not worth waking threads.
constexpr std::size_t kWorthThreads = 16;

struct ElementId {
  int group, element;
};

struct Colouring {
  std::vector<ElementId> order;  ///< all elements, by colour, those for one thread last
  std::vector<std::size_t>
      colour_start;  ///< colours + 1: where each begins in `order`; the last: where the rest begins
};

/// Greedy: each element, group by group, takes the first colour that none of its coordinates (`coordinates`
/// in all) has. Groups whose number is in `left_out` are passed over.
Colouring colour_elements(const std::vector<std::shared_ptr<const ElementGroup>>& groups, int coordinates,
                          const std::set<int>& left_out = {});

}  // namespace mfs::dae
