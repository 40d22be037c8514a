// The loop of refinement over vectors that are made up: each part's errors are given, and what the loop asks
// for is written down.
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "accuracy/iterative_refinement.hpp"

namespace mfs::test {
namespace {

using testing::ElementsAre;

class GivenErrors {
 public:
  explicit GivenErrors(std::vector<std::vector<double>> errors)
      : errors_(std::move(errors)), at_(errors_.size(), 0) {}

  Vertex parts() const { return static_cast<Vertex>(errors_.size()); }
  void measure(double* errors) const {
    for (const std::vector<double>& of_part : errors_) *errors++ = of_part.at(0);
  }
  void correct(const Vertex* parts, Vertex count) {
    corrected.emplace_back(parts, parts + count);
    added = 0;
  }
  double add_correction(Vertex part, Vertex place) {
    EXPECT_EQ(place, added++);
    return errors_.at(part).at(++at_.at(part));
  }
  double drop_remainders(Vertex part, Vertex, double error) {
    stalled.push_back(part);
    return part == drops ? 0 : error;
  }
  void take_back(Vertex part) { taken_back.push_back(part); }

  std::vector<std::vector<Vertex>> corrected;
  std::vector<Vertex> stalled, taken_back;
  Vertex drops = -1, added = 0;

 private:
  std::vector<std::vector<double>> errors_;
  std::vector<std::size_t> at_;
};

std::vector<double> refine(GivenErrors& vectors, const SolveControls& controls) {
  IterativeRefinement<GivenErrors> refinement(vectors, controls);
  refinement.measure();
  refinement.run();
  EXPECT_EQ(refinement.steps(), static_cast<int>(vectors.corrected.size()));
  std::vector<double> left;
  for (Vertex part = 0; part < vectors.parts(); ++part) left.push_back(refinement.error(part));
  EXPECT_EQ(refinement.worst_error(), *std::max_element(left.begin(), left.end()));
  return left;
}

TEST(IterativeRefinement, EachPartEndsByItself) {
  GivenErrors vectors({{1e-3, 1e-6, 1e-9, 1e-13}, {1e-14}, {1e-3, 1e-13}, {1e-3, 6e-4}, {1e-3, 2e-3}});
  EXPECT_THAT(refine(vectors, {1e-12, 10}), ElementsAre(1e-13, 1e-14, 1e-13, 6e-4, 1e-3));
  EXPECT_THAT(vectors.corrected, ElementsAre(ElementsAre(0, 2, 3, 4), ElementsAre(0), ElementsAre(0)));
  EXPECT_THAT(vectors.stalled, ElementsAre(3, 4));
  EXPECT_THAT(vectors.taken_back, ElementsAre(4)) << "what is worse is not kept, what is better is";
}

TEST(IterativeRefinement, GoesOnWithoutRemainders) {
  GivenErrors vectors({{1, 1}, {1, 1}});
  vectors.drops = 1;
  EXPECT_THAT(refine(vectors, {1e-12, 10}), ElementsAre(1, 0));
  EXPECT_THAT(vectors.taken_back, ElementsAre(0));
}

TEST(IterativeRefinement, MakesNoMoreStepsThanItMay) {
  GivenErrors vectors({{1, 0.25, 0.0625, 0.015625}});
  EXPECT_THAT(refine(vectors, {1e-12, 2}), ElementsAre(0.0625));
  GivenErrors none({{1, 0.25}});
  EXPECT_THAT(refine(none, {1e-12, 0}), ElementsAre(1));
}

TEST(IterativeRefinement, NeitherNaNNorInfinityIsBetter) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double after : {infinity, std::numeric_limits<double>::quiet_NaN()}) {
    GivenErrors vectors({{1e-3, after}, {infinity, 1e-13}});
    EXPECT_THAT(refine(vectors, {1e-12, 10}), ElementsAre(1e-3, 1e-13));
    EXPECT_THAT(vectors.taken_back, ElementsAre(0));
  }
}

}  // namespace
}  // namespace mfs::test
