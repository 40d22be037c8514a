#include "solver/analysis.hpp"

#include <complex>

#include "ordering/matching.hpp"
#include "ordering/matrix_check.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs {

namespace {

template <class Scalar>
void keep_caller_order(const CsrView<Scalar>& matrix, const Pattern& pattern, Analysis& analysis) {
  if (pattern.slot_of_entry.empty()) return;
  analysis.caller_offsets.resize(static_cast<size_t>(pattern.n) + 1);
  for (Offset i = 0; i <= pattern.n; ++i) analysis.caller_offsets[i] = matrix.row_offsets[i];
  analysis.caller_columns.reserve(pattern.slot_of_entry.size());
  for (const Offset slot : pattern.slot_of_entry) analysis.caller_columns.push_back(pattern.columns[slot]);
}

// A small graph is ordered before other threads are awake.
int ordering_threads(Vertex n, int threads) {
  constexpr Vertex kSmallMatrix = 5000;
  return n < kSmallMatrix ? 1 : threads;
}

}  // namespace

template <class Scalar>
void reanalyze(Analysis& analysis, const Scalar* slot_values, const AnalysisOptions& options,
               const PlanNeeds& needs, int threads, const PhaseProgress& progress, const ListCost* list) {
  const Stopwatch order_watch;
  const Pattern& pattern = *analysis.pattern;
  const int awake = ordering_threads(pattern.n, threads);
  MatchedScaling matched = match_and_scale(pattern, slot_values, options, awake);
  progress("ordering", 0.0);
  const bool looks_for_blocks = !list && !brings_order(options);
  auto blocks = looks_for_blocks ? find_diagonal_blocks(pattern, matched, needs.largest_block) : nullptr;
  SeparatorTree tree = order_matrix(
      blocks ? blocks->pattern : pattern, matched, options, awake,
      [&](double fraction) { progress("ordering", fraction); }, list, list ? TreeHeight::any : needs.height,
      blocks ? Parts::apart : Parts::bundled);
  if (blocks) tree = in_block_order(tree, *blocks);
  const double time_order = order_watch.seconds();

  const Stopwatch symbolic_watch;
  progress("symbolic", 0.0);
  if (!brings_order(options)) tree = align_nodes(tree, matched.pair);
  analysis.plan = std::make_shared<SymbolicPlan>(make_symbolic_plan(
      pattern, blocks.get(), matched.row_order, tree, options.max_block_size, awake, needs.turns));
  analysis.blocks = std::move(blocks);
  analysis.matched = std::move(matched);
  analysis.time_order = time_order;
  analysis.time_symbolic = symbolic_watch.seconds();
}

template <class Scalar>
Analysis analyze_matrix(const CsrView<Scalar>& matrix, const AnalysisOptions& options, const PlanNeeds& needs,
                        int threads, const PhaseProgress& progress,
                        const std::function<void(const Pattern&)>& checked, const ListCost* list) {
  Analysis analysis;
  const Stopwatch check_watch;
  progress("matching", 0.0);
  analysis.pattern = std::make_shared<Pattern>(check_pattern(matrix, threads));
  keep_caller_order(matrix, *analysis.pattern, analysis);
  RawVector<Scalar> summed;
  const Scalar* slot_values = matrix.values;
  if (matrix.values) {
    check_values(matrix, threads, &analysis.values.emplace());
    if (!analysis.pattern->slot_of_entry.empty()) {
      summed.resize(static_cast<std::size_t>(analysis.pattern->nnz()));
      sum_into_slots(*analysis.pattern, matrix, summed.data(), threads);
      slot_values = summed.data();
    }
  }
  checked(*analysis.pattern);
  const double time_check = check_watch.seconds();
  reanalyze(analysis, slot_values, options, needs, threads, progress, list);
  analysis.time_order += time_check;
  return analysis;
}

#define MFS_INSTANTIATE(S)                                                                              \
  template Analysis analyze_matrix<S>(const CsrView<S>&, const AnalysisOptions&, const PlanNeeds&, int, \
                                      const PhaseProgress&, const std::function<void(const Pattern&)>&, \
                                      const ListCost*);                                                 \
  template void reanalyze<S>(Analysis&, const S*, const AnalysisOptions&, const PlanNeeds&, int,        \
                             const PhaseProgress&, const ListCost*);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
