#include "ordering/order_matrix.hpp"

#include <mfs/error.hpp>

#include "ordering/compression.hpp"
#include "ordering/fronts.hpp"
#include "ordering/nested_dissection.hpp"
#include "ordering/user_order.hpp"

namespace mfs {
namespace {

void check_options(const AnalysisOptions& options) {
  if (options.leaf_size < 1) throw InvalidInput("leaf_size", "less than 1");
  if (options.separator_trials < 1) throw InvalidInput("separator_trials", "less than 1");
  if (options.separator_refinement < 1) throw InvalidInput("separator_refinement", "less than 1");
  if (!(options.dense_row > 0)) throw InvalidInput("dense_row", "not positive");
}

}  // namespace

SeparatorTree order_matrix(const Pattern& pattern, const MatchedScaling& matched,
                           const AnalysisOptions& options, int threads, const OrderingProgress& progress) {
  check_options(options);
  const bool user_tree = !options.tree.parent.empty() || !options.tree.offsets.empty();
  if (user_tree) return tree_of_caller(paired_graph(pattern, matched, threads), options);
  if (!options.permutation.empty())
    return tree_of_permutation(paired_graph(pattern, matched, threads), options);

  const CompressedGraph compressed = compressed_graph(pattern, matched, threads);
  const std::vector<Vertex> order = nested_dissection(compressed.graph, options, threads, progress);
  return fronts_of_order(compressed.graph, compressed.partition, order);
}

}  // namespace mfs
