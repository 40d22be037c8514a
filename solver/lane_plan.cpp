#include "solver/lane_plan.hpp"

#include <cmath>
#include <complex>
#include <utility>

#include "kernels/dense/pivot_rule.hpp"
#include "plan/level_schedule.hpp"
#include "solver/option_checks.hpp"
#include "solver/solve_rules.hpp"

namespace mfs {

namespace {

/// Where each entry of the factors takes more products than this in the mean, fronts are faster: they read an
/// entry once for many products. Lanes took 0.64 of the time at 47 (poisson2d:200) and 0.67 at 33 (kkt:5),
/// and 1.12 at 74 (convdiff3d:16); `perf_batch` on a 2-core EPYC with AVX-512, 2026-11-25.
constexpr Offset kMostProducts = 40;
/// The factors of all lanes then take 25 MB a thread, in double precision.
constexpr Offset kMostEntries = 400'000;

/// Products that a device does in the time of a level: the smallest team has a thread for each task of a
/// slice and takes as long for fewer. A task has two or three products (chain:91: 224 000 products and 30 000
/// entries in 96 000 tasks).
constexpr Offset kProductsOfLevel = kSliceTasks * 5 / 2;

static_assert(kMostEntries <= kMostScheduledEntries &&
              kMostEntries * kMostProducts <= kMostScheduledProducts);

/// Positions of the plan, each subtree's together, so that what a column needs has just been made.
std::vector<Vertex> order_by_subtrees(const SymbolicPlan& plan) {
  std::vector<Vertex> waiting, fronts, order;  // fronts: each before its children
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    if (plan.parent[f] < 0) waiting.push_back(f);
  }
  while (!waiting.empty()) {
    const Vertex f = waiting.back();
    waiting.pop_back();
    fronts.push_back(f);
    waiting.insert(waiting.end(), plan.children.begin() + plan.child_begin[f],
                   plan.children.begin() + plan.child_begin[f + 1]);
  }
  for (auto f = fronts.rbegin(); f != fronts.rend(); ++f) {
    for (Vertex k = plan.pivot_begin[*f]; k < plan.pivot_begin[*f + 1]; ++k) order.push_back(k);
  }
  return order;
}

bool lanes_do(const Options& options, const Report& report) {
  return !report.single_precision && options.solve.row_floor == 0;
}

// Scales of a lane have the precision of its numbers.
template <class Scalar>
bool in_range(const std::vector<double>& scales) {
  for (const double scale : scales) {
    if (!std::isnormal(static_cast<RealOf<Scalar>>(scale))) return false;
  }
  return true;
}

}  // namespace

template <class Scalar>
std::optional<lanes::LaneProgram> plan_lanes(const Options& options, const Report& report,
                                             const Analysis& analysis, const Factorization<Scalar>& factors) {
  const MatchedScaling& matched = analysis.matched;
  const bool good_pivots = report.perturbed_pivots == 0 && !matched.beyond_range;
  if (!good_pivots || !lanes_do(options, report)) return std::nullopt;
  if (!in_range<Scalar>(matched.row_scale) || !in_range<Scalar>(matched.column_scale)) return std::nullopt;
  std::vector<Vertex> row_of, column_of;
  for (const Vertex k : order_by_subtrees(*analysis.plan)) {
    row_of.push_back(factors.pivot_row(k));
    column_of.push_back(analysis.plan->column_of[k]);
  }
  auto program = make_scalar_program(*analysis.pattern, std::move(row_of), std::move(column_of),
                                     {kMostEntries, kMostProducts});
  if (!program) return std::nullopt;
  lanes::LaneProgram made(std::move(*program), analysis.pattern, matched);
  if (!in_range<Scalar>(made.slot_scale)) return std::nullopt;
  return made;
}

std::optional<ListCost> lane_cost(const Options& options, const Report& report, bool on_device) {
  if (!lanes_do(options, report)) return std::nullopt;
  return ListCost{kMostEntries, kMostProducts, on_device ? kProductsOfLevel : 0};
}

template <class Scalar>
lanes::LaneRules lane_rules(const Options& options) {
  const PivotRule rule = pivot_rule<RealOf<Scalar>>(pivot_tolerance_of<Scalar>(options.factor, false), 1.0);
  return {{rule.bound, rule.tiny, rule.border_part},
          tolerance_of<Scalar>(options.solve),
          options.solve.max_refinement_steps};
}

#define MFS_INSTANTIATE(S)                                                                                 \
  template std::optional<lanes::LaneProgram> plan_lanes<S>(const Options&, const Report&, const Analysis&, \
                                                           const Factorization<S>&);                       \
  template lanes::LaneRules lane_rules<S>(const Options&);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
