// How the figures are taken, seen with a solver whose faults are known: a diagonal matrix that is "solved"
// with a wished error.
#include <limits>

#include <gtest/gtest.h>

#include "perf/measure.hpp"

namespace {

using namespace mfs::perf;

System diagonal_system() {
  System system;
  system.a = {3, {0, 1, 2, 3}, {0, 1, 2}, {2.0, 4.0, 8.0}};
  for (int i = 0; i < 3 * kColumns; ++i) system.b.push_back(1.0 + i);
  return system;
}

struct Faults {
  double error = 0;      // relative, of every component; each refinement step divides it by 1e5
  double drift = 0;      // added to the first component of each further factorization
  bool refines = false;  // by steps that it is told
};

class FaultyCandidate final : public Candidate {
 public:
  FaultyCandidate(const System& system, const Faults& faults)
      : system_(system), faults_(faults), x_(system.b.size()) {}
  AnalysisTime analyze() override { return {1, 2}; }
  void factor() override {}
  void refactor() override { ++refactorizations_; }
  void solve(int columns) override {
    double error = faults_.error;
    for (int step = 0; step < steps_; ++step) error *= 1e-5;
    for (int i = 0; i < 3 * columns; ++i) x_[i] = system_.b[i] / system_.a.values[i % 3] * (1 + error);
    x_[0] += refactorizations_ * faults_.drift;
  }
  void read_solution(int columns, double* x) override { std::copy_n(x_.data(), 3 * columns, x); }
  bool refine(int steps) override {
    if (faults_.refines) steps_ = steps;
    return faults_.refines;
  }
  Facts facts() override {
    Facts facts;
    facts.refinement_steps = steps_;
    return facts;
  }
  std::int64_t caller_bytes(int columns) const override { return 1000 + 10 * columns; }

 private:
  const System& system_;
  Faults faults_;
  std::vector<double> x_;
  int refactorizations_ = 0, steps_ = 0;
};

nlohmann::ordered_json measure_with(const Faults& faults) {
  return measure([&](const System& system) { return std::make_unique<FaultyCandidate>(system, faults); },
                 diagonal_system(), 3);
}

TEST(PerfMeasure, AnExactSolver) {
  const nlohmann::ordered_json json = measure_with({});
  EXPECT_EQ(json["status"], "solved");
  EXPECT_EQ(json["reorder_s"], 1);
  EXPECT_EQ(json["symbolic_s"], 2);
  EXPECT_EQ(json["bitwise_equal"], true);
  EXPECT_EQ(json["accurate"], true);
  EXPECT_EQ(json["backward_error_16"], 0);
  EXPECT_FALSE(json.contains("unrefined_solve_1_s"));
}

// This program's device has none of its arrays: what is left is what the caller's are counted as.
TEST(PerfMeasure, MemoryForOneColumnIsWithACallerOfOneColumn) {
  const nlohmann::ordered_json json = measure_with({});
  EXPECT_EQ(json["device_bytes"], 0);
  EXPECT_EQ(json["device_bytes_caller"], 1160);
  EXPECT_EQ(json["device_bytes_1"], 1010 - 1160);
  EXPECT_EQ(json["device_bytes_1_caller"], 1010);
}

TEST(PerfMeasure, SeesBitsThatDiffer) {
  const nlohmann::ordered_json json = measure_with({0, 1e-15, false});
  EXPECT_EQ(json["bitwise_equal"], false);
  EXPECT_EQ(json["accurate"], true);
}

TEST(PerfMeasure, SaysThatASolutionIsWrong) {
  const nlohmann::ordered_json json = measure_with({1e-6, 0, false});
  EXPECT_EQ(json["accurate"], false);
  EXPECT_NEAR(json["backward_error_1"].get<double>(), 0.5e-6, 1e-10);
  EXPECT_NEAR(json["backward_error_16"].get<double>(), 0.5e-6, 1e-10);
}

TEST(PerfMeasure, RefinesByTheFewestStepsThatDo) {
  const nlohmann::ordered_json json = measure_with({1e-4, 0, true});
  EXPECT_EQ(json["refinement_steps"], 2);
  EXPECT_EQ(json["accurate"], true);
  EXPECT_NEAR(json["unrefined_backward_error"].get<double>(), 0.5e-4, 1e-8);
  EXPECT_EQ(measure_with({1e30, 0, true})["accurate"], false);  // and gives up
}

TEST(PerfMeasure, ErrorsOfAColumn) {
  const System system = diagonal_system();
  std::vector<double> x{0.5, 0.5, 0.375};  // A x = 1 2 3 = b
  Errors errors = errors_of(system, x.data(), 1);
  EXPECT_EQ(errors.backward, 0);
  EXPECT_EQ(errors.residual, 0);
  x[2] = 0.5;  // the last residual is 1: componentwise 1 / (4 + 3), by norms 1 / (8 * 0.5 + 3)
  errors = errors_of(system, x.data(), 1);
  EXPECT_DOUBLE_EQ(errors.backward, 1.0 / 7);
  EXPECT_DOUBLE_EQ(errors.residual, 1.0 / 7);
  x[0] = 1.0;  // the first: 1 / (2 + 1), by norms 1 / (8 * 1 + 3)
  errors = errors_of(system, x.data(), 1);
  EXPECT_DOUBLE_EQ(errors.backward, 1.0 / 3);
  EXPECT_DOUBLE_EQ(errors.residual, 1.0 / 11);
  x[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(errors_of(system, x.data(), 1).backward, std::numeric_limits<double>::infinity());
}

}  // namespace
