// A probe where the factors lie, against plain loops in long double.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "kernels/factors.hpp"
#include "kernels/stages/probe_step.hpp"
#include "test/stages/artificial_problem.hpp"

namespace mfs::test {

template <class Value>
std::vector<Value> probing_vector(const StageProblem<Value>& problem) {
  std::vector<Value> b;
  for (Vertex i = 0; i < problem.plan->n; ++i)
    b.push_back(Value(static_cast<RealOf<Value>>(probing_entry(i) / problem.row_scale[i])));
  return b;
}

/// What a first step that finds x does.
template <class Value>
ProbeStep step_to(const StageProblem<Value>& problem, const std::vector<Value>& x) {
  using Sum = std::complex<long double>;
  const std::vector<Value> b = probing_vector(problem);
  const Pattern& pattern = *problem.pattern;
  ProbeStep step{0, 0, 0, 0};
  for (Vertex i = 0; i < pattern.n; ++i) {
    Sum product = 0;
    double size = 0;
    for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
      const Sum term = Sum(problem.values[k]) * Sum(x[pattern.columns[k]]);
      product += term;
      size += static_cast<double>(std::abs(term));
    }
    const double scale = problem.row_scale[i];
    step.left = std::max(step.left, static_cast<double>(std::abs(Sum(b[i]) - product)) * scale);
    step.product = std::max(step.product, static_cast<double>(std::abs(product)) * scale);
    step.size = std::max(step.size, size * scale);
    step.length = std::max<double>(step.length, std::abs(x[i]) / problem.column_scale[i]);
  }
  return step;
}

/// `gain`: of a step, at least.
template <class Value>
void expect_probes(const StageProblem<Value>& problem, Factors<Value>& factors, double gain) {
  std::vector<Value> x = probing_vector(problem);
  factors.apply_inverse(x.data(), x.data(), 1, false);
  const ProbeStep expected = step_to(problem, x);
  for (int round = 0; round < 2; ++round) {
    const ProbeStep first = factors.resident()->probe(true);
    EXPECT_NEAR(first.length, expected.length, 1e-12 * expected.length);
    EXPECT_NEAR(first.product, expected.product, 1e-12 * expected.size);
    EXPECT_NEAR(first.size, expected.size, 1e-12 * expected.size);
    EXPECT_NEAR(first.left, expected.left, 1e-3 * expected.left);
    const ProbeStep second = factors.resident()->probe(false);
    EXPECT_LE(second.length, first.length / gain);
    EXPECT_LE(second.left, first.left / gain);
  }
}

}  // namespace mfs::test
