// Scaling and matching: makes the diagonal of the matrix that is factored strong, before anything is ordered.
//
//   1. equilibration   powers of two for rows and columns, so that the largest entry of each is about 1
//   2. diagonal test   is every diagonal entry there and not small beside the rest of its row and column?
//   3. matching        where it is weak: the permutation that maximises the product of the diagonal (Duff and
//                      Koster 2001), with the scaling that comes with it (matched entries about 1, all others
//                      at most about 1)
//   4. use of it       unsymmetric pattern: rows are permuted, the matched entries become the diagonal.
//                      nearly symmetric pattern (saddle points): a permutation of rows alone would destroy
//                      the symmetry and with it the fill, so unknowns on a cycle of the matching are paired
//                      instead: they stay together in one pivot block (Duff and Pralet 2005)
//
// All scales are powers of two: scaling changes no digit of any entry. A row scale times a column scale is
// finite wherever the matrix has an entry, though scale times entry may not be: multiply the two scales
// first.
#pragma once

#include <mfs/analysis_options.hpp>

#include "ordering/types.hpp"

namespace mfs {

/// `slot_values` [pattern.nnz()] are A's entries in the order of pattern.columns, all finite; null where only
/// the pattern is known: then nothing is scaled and only missing diagonal entries cause a (structural)
/// matching. Throws SingularMatrix(structural) with one unmatched row and column and the number of unmatched
/// rows.
template <class Scalar>
MatchedScaling match_and_scale(const Pattern& pattern, const Scalar* slot_values,
                               const AnalysisOptions& options, int threads);

}  // namespace mfs
