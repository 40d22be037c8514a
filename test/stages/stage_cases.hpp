// Problems for tests of the stages, with the plain reference's answer: fronts of all kinds of sizes - one
// row, around a vector register, past a panel, past a tile - and trees. Made once, as the reference takes its
// time.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "test/stages/reference_stages.hpp"

namespace mfs::test {

/// Of the largest entry: pivots are large, so nothing grows.
template <class Scalar>
constexpr double kTolerance = 4000 * static_cast<double>(std::numeric_limits<RealOf<Scalar>>::epsilon());

template <class Scalar>
struct Case {
  std::string name;
  StageProblem<Scalar> problem;
  ReferenceStages<Scalar> reference;
  Case(std::string name_, const StageProblem<double>& problem_)
      : name(std::move(name_)),
        problem(in_numbers_of<Scalar>(problem_)),
        reference(problem, ReferenceRule()) {}
};

/// Pivots x border sizes; fewer of them unless `thorough`.
template <class Scalar, bool thorough>
const std::vector<Case<Scalar>>& front_sizes() {
  static const auto* const cases = [] {
    auto* made = new std::vector<Case<Scalar>>;
    for (const Vertex p :
         thorough ? std::vector<Vertex>{1, 2, 31, 32, 33, 65, 257} : std::vector<Vertex>{1, 33, 257}) {
      for (const Vertex b :
           thorough ? std::vector<Vertex>{0, 1, 2, 31, 32, 33, 65, 257} : std::vector<Vertex>{0, 1, 65}) {
        made->emplace_back(
            std::to_string(p) + " pivots, border " + std::to_string(b),
            artificial_problem(leaf_and_root(p, b), {static_cast<std::uint64_t>(1000 * p + b)}));
      }
    }
    return made;
  }();
  return *cases;
}

/// Four trees, to which a test may add its own.
template <class Scalar>
std::vector<Case<Scalar>> four_trees() {
  std::vector<Case<Scalar>> made;
  made.emplace_back("mixed tree", artificial_problem(mixed_tree(), {1, 1.0}));
  made.emplace_back("mixed tree, sparse entries", artificial_problem(mixed_tree(), {2, 0.2}));
  made.emplace_back("broom", artificial_problem(broom(), {3, 0.5}));
  made.emplace_back("chain", artificial_problem(chain(), {4, 0.7}));
  return made;
}

/// Fronts whose diagonal has a third of the largest entry beside it in its row.
template <class Scalar>
std::vector<Case<Scalar>> weak_diagonals() {
  std::vector<Case<Scalar>> made;
  for (const Vertex p : {5, 33, 65}) {
    StageProblem<double> problem = artificial_problem(leaf_and_root(p, 9), {11, 1.0, 64, {}, 1.0});
    const auto size = [&](Offset k) {
      return std::abs(problem.values[k]) * problem.column_scale[problem.pattern->columns[k]];
    };
    for (Vertex row = 0; row < problem.pattern->n; ++row) {
      const Offset begin = problem.pattern->offsets[row], end = problem.pattern->offsets[row + 1];
      Offset diagonal = begin;
      for (Offset k = begin; k < end; ++k) diagonal = size(k) > size(diagonal) ? k : diagonal;
      double most = 0;
      for (Offset k = begin; k < end; ++k) most = k == diagonal ? most : std::max(most, size(k));
      problem.values[diagonal] *= most / 3 / size(diagonal);
    }
    made.emplace_back("weak diagonal of " + std::to_string(p) + " pivots", problem);
  }
  return made;
}

}  // namespace mfs::test
