// The order of the sum: what one colour may hold.
#include "dae/mechanics/colouring.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "test/dae/mechanics/artificial_group.hpp"

namespace mfs::dae {
namespace {

using test::ArtificialGroup;

TEST(Colouring, ElementsOfOneColourShareNoCoordinate) {
  constexpr int kChain = 300, kStar = 200;
  std::vector<int> chain, star;
  for (int k = 0; k < kChain; ++k) chain.insert(chain.end(), {k, k + 1, k + 2});
  for (int k = 0; k < kStar; ++k) star.insert(star.end(), {k + 1, 400});  // all with coordinate 400
  const std::vector<std::shared_ptr<const ElementGroup>> groups{
      std::make_shared<ArtificialGroup>("chain", 3, 0, chain, LocalStructure{}),
      std::make_shared<ArtificialGroup>("star", 2, 0, star, LocalStructure{})};
  const Colouring colouring = colour_elements(groups, 401);

  ASSERT_EQ(colouring.order.size(), static_cast<std::size_t>(kChain + kStar));
  std::set<std::pair<int, int>> seen;
  for (const ElementId id : colouring.order) seen.insert({id.group, id.element});
  EXPECT_EQ(seen.size(), colouring.order.size());

  // Three colours for the chain, each with at most one of the star; the rest of the star is for one thread.
  ASSERT_EQ(colouring.colour_start.size(), 4U);
  EXPECT_GE(colouring.colour_start.back(), static_cast<std::size_t>(kChain));
  EXPECT_LE(colouring.colour_start.back(), static_cast<std::size_t>(kChain + 3));
  for (std::size_t colour = 0; colour + 1 < colouring.colour_start.size(); ++colour) {
    std::set<int> used;
    for (std::size_t k = colouring.colour_start[colour]; k < colouring.colour_start[colour + 1]; ++k) {
      const ElementGroup& group = *groups[colouring.order[k].group];
      for (int i = 0; i < group.local_coordinates(); ++i)
        EXPECT_TRUE(used.insert(group.coordinates(colouring.order[k].element)[i]).second);
    }
  }
}

}  // namespace
}  // namespace mfs::dae
