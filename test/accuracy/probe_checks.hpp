// A probe where the factors lie, against plain loops in long double.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>
#include <string>
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

/// Steps of GCR with the inverse of `factors`, one scalar product at a time.
template <class Value>
class PlainSteps {
  using Sum = std::complex<long double>;
  using Vector = std::vector<Sum>;

 public:
  PlainSteps(const StageProblem<Value>& problem, Factors<Value>& factors)
      : problem_(problem), factors_(factors), b_(scaled(probing_vector(problem))), x_(b_.size()), r_(b_) {}

  ProbeStep next() {
    std::vector<Value> inverse;
    for (std::size_t i = 0; i < r_.size(); ++i)
      inverse.push_back(narrowed(r_[i] / Sum(problem_.row_scale[i])));
    factors_.apply_inverse(inverse.data(), inverse.data(), 1, false);
    Vector d(inverse.begin(), inverse.end()), product = scaled_product(d);
    for (std::size_t k = 0; k < directions_.size(); ++k) {
      const Sum part = dot(products_[k], product) / dot(products_[k], products_[k]);
      for (std::size_t i = 0; i < d.size(); ++i) {
        d[i] -= part * directions_[k][i];
        product[i] -= part * products_[k][i];
      }
    }
    const Sum part = dot(product, r_) / dot(product, product);
    for (std::size_t i = 0; i < d.size(); ++i) {
      x_[i] += part * d[i];
      r_[i] -= part * product[i];
    }
    std::vector<Value> direction;
    for (const Sum& entry : d) direction.push_back(narrowed(entry));
    ProbeStep step = step_to(problem_, direction);
    step.left = 0;
    for (const Sum& entry : r_) step.left = std::max(step.left, static_cast<double>(std::abs(entry)));
    directions_.push_back(d);
    products_.push_back(product);
    return step;
  }

 private:
  static Value narrowed(const Sum& number) {
    return from_parts<Value>(static_cast<double>(number.real()), static_cast<double>(number.imag()));
  }
  static Sum dot(const Vector& a, const Vector& b) {
    Sum sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::conj(a[i]) * b[i];
    return sum;
  }
  Vector scaled(const std::vector<Value>& b) const {
    Vector scaled(b.begin(), b.end());
    for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] *= problem_.row_scale[i];
    return scaled;
  }
  Vector scaled_product(const Vector& x) const {
    const Pattern& pattern = *problem_.pattern;
    Vector product(x.size());
    for (Vertex i = 0; i < pattern.n; ++i) {
      for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k)
        product[i] += Sum(problem_.values[k]) * x[pattern.columns[k]];
      product[i] *= problem_.row_scale[i];
    }
    return product;
  }

  const StageProblem<Value>& problem_;
  Factors<Value>& factors_;
  Vector b_, x_, r_;
  std::vector<Vector> directions_, products_;
};

/// With factors that are not those of the matrix. `rounding`: of theirs. What differs by rounding is larger
/// in each step, so it is compared as long as much is left.
template <class Value>
void expect_steps_together(const StageProblem<Value>& problem, Factors<Value>& factors, double rounding) {
  ResidentFactors<Value>& resident = *factors.resident();
  for (int round = 0; round < 2; ++round) {
    // All at first: a probe goes on from vectors that other solves use, too.
    PlainSteps<Value> plain(problem, factors);
    std::vector<ProbeStep> steps;
    do steps.push_back(plain.next());
    while (steps.back().left > 1e-4 && steps.size() < 12);
    EXPECT_GE(steps.size(), 4u);
    double left = 1;
    for (std::size_t step = 0; step < 30; ++step) {
      SCOPED_TRACE("step " + std::to_string(step));
      const std::optional<ProbeStep> found = resident.probe_together(step == 0);
      ASSERT_TRUE(found);
      left = found->left;
      if (step >= steps.size()) continue;
      const ProbeStep& expected = steps[step];
      EXPECT_NEAR(found->left, expected.left, rounding * expected.left);
      EXPECT_NEAR(found->length, expected.length, rounding * expected.length);
      EXPECT_NEAR(found->product, expected.product, rounding * expected.size);
      EXPECT_NEAR(found->size, expected.size, rounding * expected.size);
    }
    EXPECT_LE(left, 1e-12);
  }
  int steps = 1;  // until there is no more room
  for (resident.probe_together(true); resident.probe_together(false);) ASSERT_LE(++steps, 1000);
  EXPECT_GE(steps, 30);
  EXPECT_TRUE(resident.probe_together(true));
}

}  // namespace mfs::test
