// Which fronts are strict, that is, have their pivots searched in all rows of the pivot block instead of
// those of a tile. What a factorization finds is kept in a state for each front, of which the next one makes
// what it is to be:
//
//   found      a pivot of a tile was too small, or let something below it grow: the front is strict from the
//              next factorization on. The present one is repeated, with all ancestors strict, too: what they
//              had from the front was not right, so they may have been taken for strict, or not, for nothing.
//   needs it   a strict front tells by its pivots and the rows that they came from. Where those of the tile
//              would have done, with a margin, the front is no longer strict in the next factorization: it
//              need not be tried without, and repeated where that is in vain.
//
// A front that is found again was released in vain. It is strict then until it has not needed to be in
// kPatience factorizations.
#pragma once

#include <vector>

#include "kernels/dense/pivot_rule.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Bits of the state of a front, 0 at first; multiples of kIdle count the factorizations in which it was
/// strict and need not have been, since the last in which it had to.
constexpr int kStrict = 1, kBecomesStrict = 2, kNeedsStrict = 4, kFoundOnce = 8, kFoundAgain = 16, kIdle = 32;
constexpr int kPatience = 64;

/// A multiplier beyond this, of a row that the pivot search left out, makes its front strict. Ten times what
/// kBorderThreshold allows: strict fronts cost up to as much as the factorization, and what such growth takes
/// from the accuracy of a solve is seen, and mended by refinement.
constexpr double kMostGrowth = 10 / kBorderThreshold;
/// A strict front needs to be where the pivot is more than so many times what the tile has.
constexpr double kNeededGrowth = 1 / kBorderThreshold;

/// The rule for pivots that are searched in a tile while other rows are left out. Where tiny pivots are
/// divided by, the rows that are left out, and the border, are not looked at before a pivot is taken, unless
/// it is no more than rounding: what its multipliers come to tells afterwards (most_left_out).
KOKKOS_INLINE_FUNCTION PivotRule rule_of_tiles(PivotRule rule, bool divides) {
  const double rounding = kEmptyBorder * rule.tiny;
  if (divides && rounding < rule.bound) rule.bound = rounding;
  return rule;
}
/// A multiplier beyond this, of a row that was left out, makes the front strict, and then the whole rule
/// decides. Where tiny pivots are divided by, rows below the tile count as those of the border do, which are
/// looked at, too: in a definite matrix multipliers are as large as its entries are graded, and harmless.
KOKKOS_INLINE_FUNCTION double most_left_out(const PivotRule& rule, bool divides) {
  return divides ? 1 / rule.border_part : kMostGrowth;
}

/// Whether a pivot shows that its front needs to be strict: of sizes `largest` in all rows and `of_tile` in
/// those of the tile, by the rule of tiles.
KOKKOS_INLINE_FUNCTION bool needs_strict(double largest, double of_tile, const PivotRule& rule) {
  return !(of_tile >= rule.bound) || largest > kNeededGrowth * of_tile;
}

/// The state for the next factorization. `repeats`: the one before found fronts that had to be strict, so
/// that what strict ones learned does not count.
KOKKOS_INLINE_FUNCTION int settled_state(int state, bool repeats) {
  const int found = state & (kFoundOnce | kFoundAgain);
  if (state & kBecomesStrict) return kStrict | kFoundOnce | (found ? kFoundAgain : 0);
  if (!(state & kStrict)) return state;
  if (repeats) return state & ~kNeedsStrict;
  if (state & kNeedsStrict) return kStrict | found;
  const int idle = state / kIdle + 1;
  return idle < (found & kFoundAgain ? kPatience : 1) ? kStrict | found | idle * kIdle : found;
}

/// Before a factorization is repeated: all ancestors of fronts that were found are strict, too.
inline void make_ancestors_strict(const SymbolicPlan& plan, std::vector<int>& states) {
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    if (!(states[f] & kBecomesStrict)) continue;
    for (Vertex above = plan.parent[f]; above >= 0; above = plan.parent[above]) states[above] |= kStrict;
  }
}

}  // namespace mfs
