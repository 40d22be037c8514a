// Problems whose pivots are too small in a known way.
#pragma once

#include "test/reference/sparse.hpp"
#include "test/stages/artificial_problem.hpp"

namespace mfs::test {

/// A problem of one front of `pivots` and a root that its border lies in, with the entries given by position.
StageProblem<double> two_fronts(Vertex pivots, Vertex border, const std::vector<Entry>& entries,
                                Vertex max_block_size);

/// Two fronts, the pivot block of the first zero, its border random.
StageProblem<double> zero_pivot_block(Vertex pivots, Vertex border, Vertex max_block_size, double corner = 1);

/// Two fronts, the pivot block of the first a product of small integers of the given rank; the second has
/// `corner` on its diagonal.
StageProblem<double> low_rank_pivot_block(std::uint64_t seed, Vertex pivots, Vertex rank, Vertex border,
                                          Vertex max_block_size, double corner);

/// Two fronts, the first of `pivots` pivots, whose first `half` columns have their large entries `half` rows
/// below the diagonal; `own` is the size of their entries in the first `half` rows.
StageProblem<double> pivots_below_the_tile(Vertex pivots, Vertex half, double own);

/// Multiplies some rows of the matrix by a power of two from 2^-10 to 2^-39.
void weaken_rows(StageProblem<double>& problem, std::uint64_t seed);

}  // namespace mfs::test
