// Problems for the stages: a tree of fronts of wanted sizes, or a real matrix with a simple tree, together
// with values, scales and the factorization by the plain reference.
#pragma once

#include <algorithm>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "plan/symbolic_plan.hpp"
#include "test/reference/multifrontal.hpp"
#include "test/reference/random.hpp"
#include "test/reference/sparse.hpp"

namespace mfs::test {

/// A front of an artificial tree; fronts are listed deepest depth first.
struct FrontShape {
  Vertex pivots;
  Vertex border;  // at most the unknowns of its ancestors; children may make it wider
  Vertex parent;  // -1: root
};

template <class Scalar>
struct StageProblem {
  std::shared_ptr<const Pattern> pattern;
  std::vector<Scalar> values;
  std::vector<double> row_scale, column_scale;
  std::shared_ptr<const SymbolicPlan> plan;

  ScaledMatrix<Scalar> scaled() const { return {*pattern, values, row_scale, column_scale}; }
};

/// Puts the matrix of a problem where `factors` (kernels/factors.hpp) want it.
template <class Scalar, class Factors>
void fill(const StageProblem<Scalar>& problem, Factors& factors) {
  std::copy(problem.values.begin(), problem.values.end(), factors.matrix_values());
  std::copy(problem.row_scale.begin(), problem.row_scale.end(), factors.row_scale());
  std::copy(problem.column_scale.begin(), problem.column_scale.end(), factors.column_scale());
}

/// The same problem in another kind of number: entries keep their size, complex ones get a random phase.
template <class Scalar>
StageProblem<Scalar> in_numbers_of(const StageProblem<double>& problem);

struct ProblemOptions {
  std::uint64_t seed = 1;
  double density = 1.0;  // of the entries between the pivots of a front, and between them and its border
  Vertex max_block_size = 64;
  AssemblyTurns turns = {};
  double kept = 0.0;  // of the rows of a pivot block, those whose large entry is on its diagonal
};

/// Fronts of the given shapes. Numbering of unknowns, rows and borders is random; each pivot block has one
/// large entry per row, in a random column of the block (but see `kept`), so that rows are exchanged all the
/// time and nothing grows.
StageProblem<double> artificial_problem(const std::vector<FrontShape>& shapes, const ProblemOptions& options);

Pattern pattern_of(const SparseMatrix& matrix);

/// The matrix on the given tree.
StageProblem<double> matrix_problem(const SparseMatrix& matrix, const SeparatorTree& tree,
                                    Vertex max_block_size);

/// The tree of fronts for a symmetric pattern in which every unknown is its own front: the elimination tree.
SeparatorTree one_unknown_per_front(const Pattern& pattern);

/// Two fronts: one with the wanted pivots and border, and the root that its border lies in.
std::vector<FrontShape> leaf_and_root(Vertex pivots, Vertex border);
/// A tree of five depths with fronts of all kinds, borders that pass by their parent, and two roots.
std::vector<FrontShape> mixed_tree();
/// 2^levels - 1 fronts; those of a depth have as many pivots, and borders in their ancestors.
std::vector<FrontShape> binary_tree(Vertex levels, Vertex pivots, Vertex border);
/// One root with 200 children of one unknown each, some of them without a border.
std::vector<FrontShape> broom();
/// Three generations with contribution blocks so large that those of one do not fit beside those of the next
/// where factors will be: their assembly takes turns. Between the root and eight leaves is a front of at most
/// 340 rows, three others there have 400.
std::vector<FrontShape> fork();
/// A root with 130 children of 1 to 90 pivots and borders of 100 to 300 rows.
std::vector<FrontShape> crowd();
/// A chain of fronts, each the only child of the next.
std::vector<FrontShape> chain();

}  // namespace mfs::test
