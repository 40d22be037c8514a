// LU by panels (kernels/panels) against the plain multifrontal reference: pivots, their rows, and what
// substitution gives; and what becomes of values with a pivot that panels leave to fronts.
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "kernels/panels/panel_factors.hpp"
#include "kernels/panels/panel_lu.hpp"
#include "ordering/matrix_check.hpp"
#include "test/reference/generators.hpp"
#include "test/stages/artificial_problem.hpp"
#include "test/stages/in_engine.hpp"
#include "test/stages/weak_pivots.hpp"

namespace mfs::test {
namespace {

using panels::kSideBySide;

/// Everything that panels need, for one problem.
template <class Scalar>
struct Panels {
  explicit Panels(const StageProblem<Scalar>& of)
      : problem(of),
        program(plan_panels(*of.plan, *of.pattern)),
        numbers(static_cast<std::size_t>(program.numbers)),
        work(static_cast<std::size_t>(program.most_pivots * kSideBySide)),
        local_row(static_cast<std::size_t>(of.plan->n)),
        moved(static_cast<std::size_t>(of.plan->num_fronts)) {}

  panels::System<Scalar> system() {
    return {*problem.plan,    *problem.pattern, program,    numbers.data(),
            local_row.data(), moved.data(),     work.data()};
  }
  bool factor(const panels::PivotBounds& bounds = {0, 0, 0.01}) {
    largest = panels::take_values(system(), problem.values.data(), problem.row_scale.data(),
                                  problem.column_scale.data());
    return panels::factor(system(), bounds);
  }

  const StageProblem<Scalar>& problem;
  const PanelProgram program;
  std::vector<Scalar> numbers, work;
  std::vector<Vertex> local_row, moved;
  double largest = 0;
};

SparseMatrix dominant(std::int64_t n) {
  return n < 3 ? tridiagonal(n) : random_diagonally_dominant(n, 3, static_cast<std::uint64_t>(n));
}

/// Fronts of all kinds, pivot blocks with more and fewer rows than a panel has columns.
std::vector<StageProblem<double>> problems() {
  std::vector<StageProblem<double>> made{artificial_problem(mixed_tree(), {21, 0.6, 64}),
                                         artificial_problem(broom(), {23}),
                                         artificial_problem(mfs::test::chain(), {24, 0.7})};
  for (const Vertex pivots : {1, 2, 3, 4, 5, 7, 8, 9, 31, 32, 33})
    made.push_back(artificial_problem(leaf_and_root(pivots, 1 + pivots % 5), {25, 0.8}));
  for (const SparseMatrix& a : {dominant(1), dominant(2), dominant(65), grid_2d(9, 11)})
    made.push_back(matrix_problem(a, one_unknown_per_front(check_pattern(a.view(), 1)), 64));
  return made;
}

template <class Scalar>
class PanelsOf : public testing::Test {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(PanelsOf, Scalars);

template <class Scalar>
double largest_difference(const Scalar* a, const Scalar* b, std::size_t count) {
  double most = 0, size = 0;
  for (std::size_t i = 0; i < count; ++i) {
    most = std::max<double>(most, std::abs(a[i] - b[i]));
    size = std::max<double>(size, std::abs(b[i]));
  }
  return most / size;
}

TYPED_TEST(PanelsOf, PivotsAndSolutionsAreThoseOfTheReference) {
  constexpr double kEpsilon = std::numeric_limits<decltype(std::abs(TypeParam()))>::epsilon();
  int moved = 0;
  for (const StageProblem<double>& real : problems()) {
    const StageProblem<TypeParam> problem = in_numbers_of<TypeParam>(real);
    const SymbolicPlan& plan = *problem.plan;
    SCOPED_TRACE("n = " + std::to_string(plan.n) + ", " + std::to_string(plan.num_fronts) + " fronts");
    const auto fronts = factor(plan, problem.scaled(), ReferenceRule());
    Panels<TypeParam> panels(problem);
    ASSERT_TRUE(panels.factor());
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      for (Vertex i = 0; i < plan.pivots(f); ++i)
        EXPECT_EQ(panels.local_row[plan.pivot_begin[f] + i], fronts[f].row_at[i]) << "front " << f;
      moved += panels.moved[f];
    }
    for (const PanelProgram::Panel& panel : panels.program.panels) {
      EXPECT_LE(panel.columns, kMostTogether);
      for (Vertex c = 0; c < panel.columns; ++c) {
        const Vertex i = panel.before + c;
        const TypeParam expected = fronts[panel.front].at(i, i);
        const TypeParam inverse =
            panels.numbers[panel.numbers + c * static_cast<Offset>(panel.rows) + panel.pivot_row + i];
        EXPECT_LT(std::abs(expected * inverse - TypeParam(1)), 1e4 * kEpsilon);
      }
    }
    const auto n = static_cast<std::size_t>(plan.n);
    const std::vector<TypeParam> b = Random(5).vector<TypeParam>(plan.n * kSideBySide);
    for (const bool transposed : {false, true}) {
      std::vector<TypeParam> all = b;  // n x kSideBySide, the numbers of a position together
      substitute(panels.system(), transposed, true, all.data());
      for (Vertex column = 0; column < kSideBySide; ++column) {
        std::vector<TypeParam> v(n), one(n), of_all(n);
        for (std::size_t k = 0; k < n; ++k) {
          one[k] = v[k] = b[k * kSideBySide + static_cast<std::size_t>(column)];
          of_all[k] = all[k * kSideBySide + static_cast<std::size_t>(column)];
        }
        solve_forward(fronts, transposed, v);
        solve_backward(fronts, transposed, v);
        EXPECT_LT(largest_difference(of_all.data(), v.data(), n), 1e5 * kEpsilon);
        if (column > 0) continue;
        substitute(panels.system(), transposed, false, one.data());
        EXPECT_LT(largest_difference(one.data(), v.data(), n), 1e5 * kEpsilon);
      }
    }
  }
  EXPECT_GT(moved, 20) << "no rows are exchanged";
}

// Entries of about the same size. (Of complex numbers the largest may be another by the sum of the parts.)
TEST(Panels, PivotsAreTheLargestOfTheirBlock) {
  for (const Vertex pivots : {2, 5, 13, 31}) {
    std::vector<Entry> entries;
    Random random(static_cast<std::uint64_t>(pivots));
    for (Vertex i = 0; i < pivots + 3; ++i) {
      for (Vertex j = 0; j < pivots + 3; ++j) entries.push_back({i, j, random.entry()});
    }
    const StageProblem<double> problem = two_fronts(pivots, 3, entries, 64);
    Panels<double> panels(problem);
    std::vector<Vertex> without;
    for (const double preference : {1.0, 8.0}) {
      ReferenceRule rule;
      rule.preference = preference;
      const auto fronts = factor(*problem.plan, problem.scaled(), rule);
      ASSERT_TRUE(panels.factor({0, 0, 0.01, preference}));
      for (Vertex i = 0; i < pivots; ++i) EXPECT_EQ(panels.local_row[i], fronts[0].row_at[i]) << i;
      if (pivots > 2) {
        EXPECT_NE(panels.local_row, without) << "as without a preference";
      }
      without = panels.local_row;
    }
  }
}

/// [pivot 1; border 1] with one unknown in each front.
template <class Scalar>
bool passes(Scalar pivot, Scalar border, const panels::PivotBounds& bounds) {
  StageProblem<Scalar> problem =
      in_numbers_of<Scalar>(two_fronts(1, 1, {{0, 0, 1.0}, {0, 1, 1.0}, {1, 0, 1.0}, {1, 1, 5.0}}, 64));
  const SymbolicPlan& plan = *problem.plan;
  for (std::vector<double>* scales : {&problem.row_scale, &problem.column_scale})
    std::fill(scales->begin(), scales->end(), 1.0);
  for (Vertex row = 0; row < 2; ++row) {
    for (Offset k = problem.pattern->offsets[row]; k < problem.pattern->offsets[row + 1]; ++k) {
      if (problem.pattern->columns[k] != plan.column_of[0]) continue;
      problem.values[k] = row == plan.row_of[0] ? pivot : border;
    }
  }
  return Panels<Scalar>(problem).factor(bounds);
}

TYPED_TEST(PanelsOf, APivotPassesByTheRuleOfFronts) {
  const panels::PivotBounds bounds{1e-2, 1e-5, 0.01};
  const auto number = [](double value) { return static_cast<TypeParam>(value); };
  EXPECT_TRUE(passes(number(0.5), number(1), bounds));
  EXPECT_TRUE(passes(number(2e-2), number(1000), bounds)) << "not suspect";
  EXPECT_TRUE(passes(number(1e-3), number(0.09), bounds)) << "suspect, but nothing grows";
  EXPECT_FALSE(passes(number(1e-3), number(0.11), bounds));
  EXPECT_TRUE(passes(number(2e-5), number(0), bounds));
  EXPECT_FALSE(passes(number(0.9e-5), number(0), bounds)) << "may be rounding";
  EXPECT_FALSE(passes(number(0), number(0), {0, 0, 0.01}));
  const double none = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(passes(number(none), number(0), bounds));
  EXPECT_FALSE(passes(number(HUGE_VAL), number(0), bounds));
  EXPECT_FALSE(passes(number(1e-3), number(none), bounds));
}

/// Solutions with one, five and 16 right-hand sides, plain and transposed.
std::vector<double> solutions(Factors<double>& factors, Vertex n) {
  factors.make_room(16);
  std::vector<double> all;
  for (const Vertex columns : {1, 5, 16}) {
    for (const bool transposed : {false, true}) {
      std::vector<double> x = Random(6).vector(static_cast<std::int64_t>(n) * columns);
      factors.apply_inverse(x.data(), x.data(), columns, transposed);
      all.insert(all.end(), x.begin(), x.end());
    }
  }
  return all;
}

std::unique_ptr<Factors<double>> fronts_of(const StageProblem<double>& problem) {
  return make_host_factors<double>(HostSpace::serial, false, problem.plan, problem.pattern, 1);
}
std::unique_ptr<Factors<double>> panels_of(const StageProblem<double>& problem) {
  return make_panel_factors<double>(
      false, fronts_of(problem), problem.plan, problem.pattern,
      std::make_shared<PanelProgram>(plan_panels(*problem.plan, *problem.pattern)));
}

TEST(PanelFactors, ValuesThatDoNotPassHaveFactorsOfFronts) {
  const PivotPolicy policy(1e-8);
  StageProblem<double> weak = zero_pivot_block(5, 7, 64), good = weak;
  Random random(3);
  for (double& value : good.values) value = 1 + 0.5 * random.entry();
  in_engine(1, [&] {
    const Vertex n = weak.plan->n;
    const auto panels = panels_of(weak), fronts = fronts_of(weak), fresh = panels_of(good);
    fill(good, *panels);
    fill(good, *fresh);
    fill(weak, *fronts);
    EXPECT_EQ(panels->factor(policy, {}).status.perturbed, 0u);
    fresh->factor(policy, {});
    const std::vector<double> first = solutions(*panels, n);
    EXPECT_EQ(first, solutions(*fresh, n));
    fill(weak, *panels);
    const Factored expected = fronts->factor(policy, {}), found = panels->factor(policy, {});
    EXPECT_GT(expected.status.perturbed, 0u);
    EXPECT_EQ(found.status.perturbed, expected.status.perturbed);
    EXPECT_EQ(found.largest, expected.largest);
    EXPECT_EQ(solutions(*panels, n), solutions(*fronts, n));
    for (Vertex k = 0; k < n; ++k) {
      EXPECT_EQ(panels->local_row(k), fronts->local_row(k));
      EXPECT_EQ(panels->pivot_shift(k), fronts->pivot_shift(k));
    }
    fill(good, *panels);
    EXPECT_EQ(panels->factor(policy, {}).status.perturbed, 0u);
    EXPECT_EQ(solutions(*panels, n), first) << "something is left of the values before";
  });
}

TEST(PanelFactors, PivotsStatusAndBytesAreThoseOfFronts) {
  for (const StageProblem<double>& problem : problems()) {
    in_engine(1, [&] {
      const auto panels = panels_of(problem), fronts = fronts_of(problem);
      fill(problem, *panels);
      fill(problem, *fronts);
      std::vector<double> told;
      const Factored found = panels->factor(1e-8, [&](double part) { told.push_back(part); });
      const Factored expected = fronts->factor(1e-8, {});
      EXPECT_EQ(told, std::vector<double>{1.0});
      EXPECT_EQ(found.largest, expected.largest);
      for (const auto part : {&FactorStatus::getrf, &FactorStatus::trsm, &FactorStatus::gemm})
        EXPECT_NEAR(found.status.*part, expected.status.*part, 1e-12 * expected.status.*part);
      const auto n = static_cast<std::size_t>(problem.plan->n);
      std::vector<std::complex<double>> pivots(n), of_fronts(n);
      panels->diagonal_pivots(pivots.data());
      fronts->diagonal_pivots(of_fronts.data());
      EXPECT_LT(largest_difference(pivots.data(), of_fronts.data(), n), 1e-10);
      for (Vertex k = 0; k < problem.plan->n; ++k) EXPECT_EQ(panels->local_row(k), fronts->local_row(k));
      const PanelProgram program = plan_panels(*problem.plan, *problem.pattern);
      EXPECT_EQ(panels->bytes(), fronts->bytes() + panel_bytes(*problem.plan, program, sizeof(double)));
    });
  }
}

TEST(PanelProgram, IsMadeWhereItPays) {
  const auto made = [](const StageProblem<double>& problem) {
    return make_panel_program(*problem.plan, *problem.pattern, 16) != nullptr;
  };
  const SparseMatrix grid = grid_2d(12, 13);
  EXPECT_TRUE(made(matrix_problem(grid, one_unknown_per_front(check_pattern(grid.view(), 1)), 64)));
  EXPECT_TRUE(made(artificial_problem(broom(), {23})));
  EXPECT_FALSE(made(artificial_problem(leaf_and_root(300, 200), {22}))) << "one large front";
}

// Of many small fronts other threads could have some.
TEST(PanelProgram, IsMadeOfManySmallFrontsForFewThreads) {
  constexpr Vertex kPairs = 15000;
  const Pattern path = pattern_of(tridiagonal(2 * kPairs));
  SeparatorTree tree;
  tree.order.resize(2 * kPairs);
  std::iota(tree.order.begin(), tree.order.end(), 0);
  tree.node_begin = {0};
  for (Vertex pair = 0; pair < kPairs; ++pair) {
    tree.node_begin.push_back(2 * (pair + 1));
    tree.parent.push_back(pair + 1 < kPairs ? pair + 1 : -1);
  }
  const SymbolicPlan plan = make_symbolic_plan(path, {}, tree, 64, 1);
  EXPECT_NE(make_panel_program(plan, path, 1), nullptr);
  EXPECT_EQ(make_panel_program(plan, path, 64), nullptr);
  EXPECT_FALSE(is_for_one_thread(plan));
}

}  // namespace
}  // namespace mfs::test
