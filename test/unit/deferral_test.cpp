#include "ordering/deferral.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "test/unit/test_matrices.hpp"

namespace {

using mfs::defer_weak_unknowns;
using mfs::Deferral;
using mfs::Offset;
using mfs::trivial_partition;
using mfs::Vertex;
using mfs::WeakUnknowns;
using mfs::test::all_served;
using testing::ElementsAre;

WeakUnknowns weak_unknowns(const std::vector<std::pair<Vertex, std::vector<Vertex>>>& lists) {
  WeakUnknowns weak;
  weak.begin.push_back(0);
  for (const auto& [unknown, partners] : lists) {
    weak.unknown.push_back(unknown);
    weak.partner.insert(weak.partner.end(), partners.begin(), partners.end());
    weak.begin.push_back(static_cast<Offset>(weak.partner.size()));
  }
  return weak;
}

TEST(Deferral, StaysBehindItsMate) {
  const Deferral d = defer_weak_unknowns(weak_unknowns({{2, {0}}}), trivial_partition(3), {0, 2, 1});
  EXPECT_THAT(d.order, ElementsAre(0, 2, 1));
  EXPECT_EQ(d.moved, 0);
}

TEST(Deferral, MovesToJustBehindItsMate) {
  const Deferral d = defer_weak_unknowns(weak_unknowns({{3, {1}}}), trivial_partition(4), {3, 0, 1, 2});
  EXPECT_THAT(d.order, ElementsAre(0, 1, 3, 2));
  EXPECT_EQ(d.moved, 1);
}

TEST(Deferral, TakesAnotherPartnerThatComesBefore) {
  const Deferral d = defer_weak_unknowns(weak_unknowns({{3, {2, 0}}}), trivial_partition(4), {0, 3, 1, 2});
  EXPECT_THAT(d.order, ElementsAre(0, 3, 1, 2));
}

TEST(Deferral, MovesBehindTheFirstPartnerThatIsFree) {
  const Deferral d = defer_weak_unknowns(weak_unknowns({{3, {2, 1}}}), trivial_partition(4), {3, 1, 0, 2});
  EXPECT_THAT(d.order, ElementsAre(1, 3, 0, 2));
}

TEST(Deferral, PartnersAreHandedOnAlongAPath) {
  // 5 has only 0 before it, which 6 holds; 6 can have 1 instead, which 7 holds; 7 can have 2.
  const auto weak = weak_unknowns({{5, {4, 0}}, {6, {0, 1}}, {7, {1, 2}}});
  const Deferral d = defer_weak_unknowns(weak, trivial_partition(8), {0, 1, 2, 5, 6, 7, 3, 4});
  EXPECT_EQ(d.moved, 0);
  const auto without_two = weak_unknowns({{5, {4, 0}}, {6, {0, 1}}, {7, {1}}});
  EXPECT_THAT(defer_weak_unknowns(without_two, trivial_partition(8), {0, 1, 2, 5, 6, 7, 3, 4}).order,
              ElementsAre(0, 1, 2, 6, 7, 3, 4, 5));
}

TEST(Deferral, AVertexMovesWithAllItsUnknowns) {
  // Unknowns 0 and 1 are one vertex, the first; 1 lacks a partner before it.
  const mfs::Partition partition = mfs::partition_by_leader({0, 0, 2, 3});
  const Deferral d = defer_weak_unknowns(weak_unknowns({{1, {2}}}), partition, {0, 1, 2});
  EXPECT_THAT(d.order, ElementsAre(1, 0, 2));
}

TEST(Deferral, EveryWeakUnknownIsServedAndTheOthersKeepTheirOrder) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex good = 1 + static_cast<Vertex>(generator() % 40);
    const Vertex multipliers = static_cast<Vertex>(generator() % (good + 1)), n = good + multipliers;
    std::vector<Vertex> mates(good);
    std::iota(mates.begin(), mates.end(), 0);
    std::shuffle(mates.begin(), mates.end(), generator);
    std::vector<std::pair<Vertex, std::vector<Vertex>>> lists;
    for (Vertex k = 0; k < multipliers; ++k) {
      lists.push_back({good + k, {mates[k]}});
      for (Vertex u = 0; u < good; ++u) {
        if (u != mates[k] && generator() % 6 == 0) lists.back().second.push_back(u);
      }
    }
    const WeakUnknowns weak = weak_unknowns(lists);
    std::vector<Vertex> order(n);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), generator);

    const Deferral d = defer_weak_unknowns(weak, trivial_partition(n), order);
    ASSERT_TRUE(std::is_permutation(d.order.begin(), d.order.end(), order.begin()));
    EXPECT_TRUE(all_served(weak, d.order));
    if (d.moved == 0) {
      EXPECT_EQ(d.order, order);
    }
    const auto goods = [&](std::vector<Vertex> vertices) {
      vertices.erase(std::remove_if(vertices.begin(), vertices.end(), [&](Vertex v) { return v >= good; }),
                     vertices.end());
      return vertices;
    };
    EXPECT_EQ(goods(d.order), goods(order));
    EXPECT_EQ(d.moved == 0, all_served(weak, order));
  }
}

}  // namespace
