// Pairs of unknowns from a matching of rows to columns (Duff and Pralet 2005).
//
// On a nearly symmetric pattern a matched entry off the diagonal is not moved to the diagonal. The matching's
// cycles are cut into pairs instead, and a pair is eliminated inside one pivot block:
//
//   cycle of four    0 -> 1 -> 2 -> 3 -> 0    the better of (0 1) (2 3) and (1 2) (3 0)
//   cycle of three   0 -> 1 -> 2 -> 0         (1 2), and 0 alone where its diagonal is fine;
//                                             otherwise all three together
//
// Two unknowns with a good diagonal each need no pair and stay alone. In a pair with one good diagonal, the
// other unknown may instead be eliminated later than a partner (ordering/deferral.hpp): its partners are
// listed.
#pragma once

#include <vector>

#include "ordering/scaling.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// A diagonal entry is weak where its exponent, scaled, is below the largest of its row and column by this
/// much: where it is smaller by a factor of about 100.
constexpr int kWeakExponent = -7;

/// MatchedScaling::pair and MatchedScaling::weak.
struct Pairs {
  std::vector<Vertex> pair;
  WeakUnknowns weak;
};

/// The pairs for the matching `row_of_column` of a matrix scaled so that matched entries are
/// about 1. Empty where pairs would be poor (values far from symmetric): then rows should be permuted
/// instead. The same for any number of threads.
Pairs pair_unknowns(const Pattern& pattern, const RawVector<Exponent>& exponents, const PowerScaling& scaling,
                    const std::vector<Vertex>& row_of_column, int threads);

}  // namespace mfs
