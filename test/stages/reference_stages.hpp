// The plain reference's state of every front after each stage.
#pragma once

#include <vector>

#include "test/stages/stage_bench.hpp"

namespace mfs::test {

template <class Scalar>
struct ReferenceStages {
  std::vector<FrontBlocks<Scalar>> assembled, factored, updated;  // by front
  std::vector<ReferenceFront<Scalar>> fronts;                     // after all stages

  ReferenceStages(const StageProblem<Scalar>& problem, const ReferenceRule& rule) {
    for (Vertex f = 0; f < problem.plan->num_fronts; ++f) {
      fronts.push_back(assemble(*problem.plan, problem.scaled(), fronts, f));
      assembled.push_back(blocks_of(fronts[f]));
      variable_factor(fronts[f], rule);
      factored.push_back(blocks_of(fronts[f]));
      variable_update(fronts[f]);
      updated.push_back(blocks_of(fronts[f]));
    }
  }
};

}  // namespace mfs::test
