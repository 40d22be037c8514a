#include "dae/mechanics/colouring.hpp"

#include <array>
#include <cstdint>

namespace mfs::dae {
namespace {

constexpr int kColours = 64;  // bits of the set of colours that a coordinate has

int first_free(std::uint64_t used) {
  int colour = 0;
  while (colour < kColours && ((used >> colour) & 1U) != 0) ++colour;
  return colour;
}

}  // namespace

Colouring colour_elements(const std::vector<std::shared_ptr<const ElementGroup>>& groups, int coordinates,
                          const std::set<int>& left_out) {
  std::vector<std::uint64_t> used(static_cast<std::size_t>(coordinates));
  std::array<std::vector<ElementId>, kColours + 1> elements;  // the last: without a colour
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (left_out.count(static_cast<int>(g)) != 0) continue;
    for (int e = 0; e < groups[g]->size(); ++e) {
      const int* first = groups[g]->coordinates(e);
      const int* last = first + groups[g]->local_coordinates();
      std::uint64_t used_here = 0;
      for (const int* i = first; i != last; ++i) used_here |= used[*i];
      const int colour = first_free(used_here);
      elements[colour].push_back({static_cast<int>(g), e});
      if (colour < kColours)
        for (const int* i = first; i != last; ++i) used[*i] |= std::uint64_t{1} << colour;
    }
  }

  Colouring colouring;
  const auto append = [&](const std::vector<ElementId>& some) {
    colouring.order.insert(colouring.order.end(), some.begin(), some.end());
  };
  for (int colour = 0; colour < kColours; ++colour)
    if (elements[colour].size() >= kWorthThreads) {
      colouring.colour_start.push_back(colouring.order.size());
      append(elements[colour]);
    }
  colouring.colour_start.push_back(colouring.order.size());
  for (const auto& some : elements)
    if (some.size() < kWorthThreads || &some == &elements[kColours]) append(some);
  return colouring;
}

}  // namespace mfs::dae
