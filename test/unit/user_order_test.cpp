// The caller's own permutation or tree.
#include "ordering/user_order.hpp"

#include <gmock/gmock.h>

#include <numeric>
#include <random>

#include <mfs/error.hpp>

#include "ordering/order_matrix.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAre;

SeparatorTree order_path(Vertex n, const AnalysisOptions& options, const MatchedScaling& matched = {}) {
  return order_matrix(pattern_of(n, path(n)), matched, options, 1);
}

AnalysisOptions with_permutation(std::vector<std::int64_t> permutation) {
  AnalysisOptions options;
  options.permutation = std::move(permutation);
  return options;
}

AnalysisOptions with_tree(std::vector<std::int64_t> permutation, std::vector<std::int64_t> offsets,
                          std::vector<std::int64_t> parent) {
  AnalysisOptions options = with_permutation(std::move(permutation));
  options.tree = {std::move(offsets), std::move(parent)};
  return options;
}

void expect_invalid(Vertex n, const AnalysisOptions& options, const std::string& argument, std::int64_t row,
                    std::int64_t column = -1) {
  try {
    order_path(n, options);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.argument(), argument) << error.what();
    EXPECT_EQ(error.row(), row) << error.what();
    EXPECT_EQ(error.column(), column) << error.what();
  }
}

TEST(UserOrder, BadPermutationsAreRefused) {
  expect_invalid(3, with_permutation({0, 1}), "permutation", -1);
  expect_invalid(3, with_permutation({0, 1, 2, 3}), "permutation", -1);
  expect_invalid(3, with_permutation({0, 3, 1}), "permutation", 1);
  expect_invalid(3, with_permutation({0, 1, -1}), "permutation", 2);
  expect_invalid(3, with_permutation({2, 0, 2}), "permutation", 2);
}

TEST(UserOrder, BadTreesAreRefused) {
  const std::vector<std::int64_t> order{0, 2, 1};
  expect_invalid(3, with_tree({}, {0, 3}, {-1}), "permutation", -1);
  expect_invalid(3, with_tree(order, {0, 3}, {1, -1}), "tree", -1);
  expect_invalid(3, with_tree(order, {}, {-1}), "tree", -1);
  expect_invalid(3, with_tree(order, {0}, {}), "tree", -1);
  expect_invalid(3, with_tree(order, {1, 3}, {-1}), "tree", 0);
  expect_invalid(3, with_tree(order, {0, 2, 1, 3}, {2, 2, -1}), "tree", 1);
  expect_invalid(3, with_tree(order, {0, 1, 4}, {1, -1}), "tree", 1);
  expect_invalid(3, with_tree(order, {0, 1, 2}, {1, -1}), "tree", -1);
  expect_invalid(3, with_tree(order, {0, 1, 3}, {0, -1}), "tree", 0);
  expect_invalid(3, with_tree(order, {0, 1, 3}, {2, -1}), "tree", 0);
  expect_invalid(3, with_tree(order, {0, 1, 3}, {-2, -1}), "tree", 0);
}

TEST(UserOrder, ATreeAcrossWhichTheMatrixReachesIsRefused) {
  // 0 and 1 are neighbours on the path but stand in different branches.
  expect_invalid(3, with_tree({0, 1, 2}, {0, 1, 2, 3}, {2, 2, -1}), "tree", 0, 1);
  expect_invalid(2, with_tree({0, 1}, {0, 1, 2}, {-1, -1}), "tree", 0, 1);
}

TEST(UserOrder, ATreeIsTakenAsItIs) {
  const SeparatorTree tree = order_path(3, with_tree({0, 2, 1}, {0, 1, 2, 3}, {2, 2, -1}));
  EXPECT_THAT(tree.order, ElementsAre(0, 2, 1));
  EXPECT_THAT(tree.node_begin, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(tree.parent, ElementsAre(2, 2, -1));
}

TEST(UserOrder, ATreeIsRenumberedBreadthFirst) {
  // A branch of two nodes and one of a single node: the single one must come second.
  const SeparatorTree tree = order_path(5, with_tree({4, 0, 1, 3, 2}, {0, 1, 2, 3, 4, 5}, {3, 2, 4, 4, -1}));
  expect_valid_tree(tree, plain_graph(5, path(5)));
  EXPECT_EQ(tree.num_nodes(), 5);
  EXPECT_EQ(tree.order.back(), 2);
}

TEST(UserOrder, EmptyNodesVanish) {
  const SeparatorTree tree = order_path(3, with_tree({0, 2, 1}, {0, 1, 1, 2, 2, 3, 3}, {1, 4, 3, 4, 5, -1}));
  expect_valid_tree(tree, plain_graph(3, path(3)));
  EXPECT_EQ(tree.num_nodes(), 3);
}

TEST(UserOrder, PairsMoveToTheNodeNearTheRoot) {
  const AnalysisOptions options = with_tree({0, 2, 1}, {0, 1, 2, 3}, {2, 2, -1});
  MatchedScaling matched;
  matched.pair = {1, 0, 2};
  const SeparatorTree left = order_path(3, options, matched);
  EXPECT_THAT(left.order, ElementsAre(2, 0, 1));
  EXPECT_THAT(left.node_begin, ElementsAre(0, 1, 3));
  EXPECT_THAT(left.parent, ElementsAre(1, -1));
  matched.pair = {0, 2, 1};
  EXPECT_THAT(order_path(3, options, matched).order, ElementsAre(0, 2, 1));
}

TEST(UserOrder, PairsTakeTheLaterPlaceOfAPermutation) {
  const Vertex n = 400;
  MatchedScaling matched;
  matched.pair.resize(n);
  std::iota(matched.pair.begin(), matched.pair.end(), 0);
  std::swap(matched.pair[0], matched.pair[n - 1]);
  std::vector<std::int64_t> permutation(n);
  std::iota(permutation.begin(), permutation.end(), 0);
  const SeparatorTree tree = order_path(n, with_permutation(permutation), matched);
  EXPECT_EQ(tree.order[n - 2], 0);
  EXPECT_EQ(tree.order[n - 1], n - 1);
}

TEST(UserOrder, APermutationKeepsItsFill) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 80);
    const Entries entries = random_entries(generator, n, 1.5, 1.0, false);
    std::vector<std::int64_t> permutation(n);
    std::iota(permutation.begin(), permutation.end(), 0);
    std::shuffle(permutation.begin(), permutation.end(), generator);
    const SeparatorTree tree = order_matrix(pattern_of(n, entries), {}, with_permutation(permutation), 1);
    const auto graph = plain_graph(n, entries);
    expect_valid_tree(tree, graph);
    EXPECT_EQ(plain_fill(graph, tree.order),
              plain_fill(graph, std::vector<Vertex>(permutation.begin(), permutation.end())));
  }
}

TEST(UserOrder, PairsStayTogetherUnderAPermutation) {
  const Vertex n = 200;
  MatchedScaling matched;
  matched.pair.resize(n);
  std::iota(matched.pair.begin(), matched.pair.end(), 0);
  std::swap(matched.pair[3], matched.pair[4]);
  std::swap(matched.pair[100], matched.pair[101]);
  std::vector<std::int64_t> permutation(n);
  std::iota(permutation.begin(), permutation.end(), 0);
  std::rotate(permutation.begin(), permutation.begin() + 4, permutation.end());
  const SeparatorTree tree = order_path(n, with_permutation(permutation), matched);
  expect_valid_tree(tree, plain_graph(n, path(n)));
  std::vector<Vertex> node_of(n);
  for (Vertex k = 0; k < tree.num_nodes(); ++k) {
    for (Vertex p = tree.node_begin[k]; p < tree.node_begin[k + 1]; ++p) node_of[tree.order[p]] = k;
  }
  EXPECT_EQ(node_of[3], node_of[4]);
  EXPECT_EQ(node_of[100], node_of[101]);
}

}  // namespace
}  // namespace mfs::test
