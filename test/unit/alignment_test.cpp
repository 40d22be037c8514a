// Nodes of a tree that get a multiple of the alignment, and what moves for it.
#include <numeric>

#include <gmock/gmock.h>

#include "plan/alignment.hpp"

namespace mfs::test {
namespace {

using testing::ElementsAre;

std::vector<Vertex> natural(Vertex n) {
  std::vector<Vertex> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

// A chain of nodes with the given numbers of unknowns, in natural order.
SeparatorTree chain_of(const std::vector<Vertex>& sizes) {
  SeparatorTree nodes;
  nodes.node_begin = {0};
  for (std::size_t f = 0; f < sizes.size(); ++f) {
    nodes.node_begin.push_back(nodes.node_begin.back() + sizes[f]);
    nodes.parent.push_back(f + 1 < sizes.size() ? static_cast<Vertex>(f) + 1 : -1);
  }
  nodes.order = natural(nodes.node_begin.back());
  return nodes;
}
std::vector<Vertex> sizes_of(const SeparatorTree& nodes) {
  std::vector<Vertex> sizes(nodes.node_begin.size());
  std::adjacent_difference(nodes.node_begin.begin(), nodes.node_begin.end(), sizes.begin());
  sizes.erase(sizes.begin());
  return sizes;
}

TEST(Alignment, LargeNodesBecomeMultiplesOfTheAlignment) {
  const SeparatorTree nodes = chain_of({100, 261, 258, 300, 7}), aligned = align_nodes(nodes, {});
  EXPECT_THAT(sizes_of(aligned), ElementsAre(100, 256, 256, 304, 10));
  EXPECT_EQ(aligned.order, nodes.order) << "a chain is eliminated as before";
  EXPECT_EQ(aligned.parent, nodes.parent);
}

TEST(Alignment, MovedUnknownsComeFirstInTheParent) {
  SeparatorTree nodes = chain_of({258, 259, 3});
  nodes.parent = {2, 2, -1};
  const SeparatorTree aligned = align_nodes(nodes, {});
  EXPECT_THAT(sizes_of(aligned), ElementsAre(256, 256, 8));
  const std::vector<Vertex> root(aligned.order.end() - 8, aligned.order.end());
  EXPECT_THAT(root, ElementsAre(256, 257, 514, 515, 516, 517, 518, 519));
}

TEST(Alignment, AlignmentKeepsPairsTogether) {
  const SeparatorTree nodes = chain_of({259, 5});
  std::vector<Vertex> pair = natural(264);
  std::swap(pair[255], pair[256]);  // three would part them
  EXPECT_THAT(sizes_of(align_nodes(nodes, pair)), ElementsAre(240, 24));
  pair = natural(264);
  for (Vertex i = 0; i < 258; ++i) pair[i] = i < 129 ? i + 129 : i - 129;  // whatever moves is parted
  EXPECT_THAT(sizes_of(align_nodes(nodes, pair)), ElementsAre(259, 5));
}

}  // namespace
}  // namespace mfs::test
