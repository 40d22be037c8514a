// Systems of one pattern in arrays with gaps, and a scalar program for them whose pivots are the diagonal in
// an order by chance.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "kernels/lanes/host_lanes.hpp"
#include "ordering/matching.hpp"
#include "ordering/matrix_check.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {

template <class Scalar>
bool same_bits(const std::vector<Scalar>& a, const std::vector<Scalar>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Scalar)) == 0);
}

inline lanes::LaneProgram lane_program_of(const SparseMatrix& a) {
  const auto pattern = std::make_shared<Pattern>(check_pattern(a.view(), 1));
  MatchedScaling matched;
  Random random(static_cast<std::uint64_t>(a.n));
  for (std::int64_t i = 0; i < a.n; ++i) {
    matched.row_scale.push_back(std::ldexp(1.0, static_cast<int>(random.integer(-2, 3))));
    matched.column_scale.push_back(1 / matched.row_scale.back());
  }
  const auto order = random.permutation(static_cast<Vertex>(a.n));
  return {make_scalar_program(*pattern, order, order, {1 << 24, 1 << 12}).value(), pattern, matched};
}

template <class Scalar>
struct LaneProblem {
  using Real = decltype(std::abs(Scalar()));
  static constexpr double kEpsilon = std::numeric_limits<Real>::epsilon();

  LaneProblem(const SparseMatrix& pattern, int count, std::int64_t columns = 1, std::int64_t gap = 0)
      : program(lane_program_of(pattern)),
        rules{{std::sqrt(kEpsilon), std::sqrt(kEpsilon), 0.01}, kTolerance<Scalar>, 10},
        n(pattern.n),
        nrhs(columns),
        values_stride(pattern.entries() + gap),
        ldb(n + gap),
        ldx(n + 2 * gap),
        b_stride(columns * ldb + gap),
        x_stride(columns * ldx + 3 * gap) {
    values.assign(static_cast<std::size_t>(count * values_stride), none());
    x.assign(static_cast<std::size_t>(count * x_stride), none());
    Random random(5);
    for (int k = 0; k < count; ++k) {
      matrices.push_back(in_scalar<Scalar>(pattern));
      for (Scalar& value : matrices.back().values) value *= static_cast<Scalar>(1 + 0.2 * random.entry());
      auto rhs = right_hand_sides(matrices.back(), nrhs, ldb, static_cast<std::uint64_t>(k));
      rhs.resize(static_cast<std::size_t>(b_stride), none());
      b.insert(b.end(), rhs.begin(), rhs.end());
    }
    put_values();
  }
  void put_values() {
    for (std::size_t k = 0; k < matrices.size(); ++k)
      std::copy(matrices[k].values.begin(), matrices[k].values.end(),
                values.begin() + static_cast<std::int64_t>(k) * values_stride);
  }
  static Scalar none() { return Scalar(std::numeric_limits<float>::quiet_NaN()); }

  lanes::LaneSystems<Scalar> systems(int first, int count) {
    return {count,
            values.data() + first * values_stride,
            values_stride,
            b.data() + first * b_stride,
            x.data() + first * x_stride,
            nrhs,
            ldb,
            ldx,
            b_stride,
            x_stride};
  }

  /// The diagonal entry that is eliminated first, and its largest entry after scaling.
  Scalar& first_pivot(int k) {
    auto& a = matrices[static_cast<std::size_t>(k)];
    const Vertex row = program.program.row_of[0];
    for (auto e = a.offsets[row];; ++e) {
      if (a.columns[e] == row) return a.values[e];
    }
  }
  double largest(int k) const {
    const auto& a = matrices[static_cast<std::size_t>(k)];
    double most = 0;
    for (std::int64_t e = 0; e < a.entries(); ++e)
      most = std::max(most, static_cast<double>(std::abs(a.values[e])) * program.slot_scale[e]);
    return most;
  }

  double error_of(int k) const {
    double worst = 0;
    for (std::int64_t j = 0; j < nrhs; ++j)
      worst = std::max(worst, backward_error(matrices[k], b.data() + k * b_stride + j * ldb,
                                             x.data() + k * x_stride + j * ldx));
    return worst;
  }
  /// Beside the vectors that the right-hand sides were made of (Random by system).
  bool near_reference(int k) const {
    Random random(static_cast<std::uint64_t>(k));
    for (std::int64_t j = 0; j < nrhs; ++j) {
      const auto expected = random.vector<Scalar>(n);
      for (std::int64_t i = 0; i < n; ++i) {
        if (!(std::abs(x[k * x_stride + j * ldx + i] - expected[i]) < 1e3 * kEpsilon)) return false;
      }
    }
    return true;
  }
  bool is_gap(std::int64_t i) const { return i >= nrhs * ldx || i % ldx >= n; }
  bool gaps_are_untouched() const {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const bool nobodys = is_gap(static_cast<std::int64_t>(i) % x_stride);
      if (std::isnan(std::abs(x[i])) != nobodys) return false;
    }
    return true;
  }
  bool untouched(int k) const {
    for (std::int64_t i = 0; i < x_stride; ++i) {
      if (!std::isnan(std::abs(x[k * x_stride + i]))) return false;
    }
    return true;
  }
  bool same_solution(int k, const LaneProblem& other) const {
    return std::memcmp(x.data() + k * x_stride, other.x.data() + k * x_stride,
                       static_cast<std::size_t>(n) * sizeof(Scalar)) == 0;
  }

  lanes::LaneProgram program;
  lanes::LaneRules rules;
  std::int64_t n, nrhs, values_stride, ldb, ldx, b_stride, x_stride;
  std::vector<BasicSparseMatrix<Scalar>> matrices;
  std::vector<Scalar> values, b, x;
};

// Zero, too small beside the largest entry, and too small beside what it divides; NaN and infinity.
template <class Scalar>
void spoil(LaneProblem<Scalar>& problem) {
  using Real = decltype(std::abs(Scalar()));
  const double tiny = std::sqrt(static_cast<double>(std::numeric_limits<Real>::epsilon()));
  problem.first_pivot(1) = Scalar(0);
  problem.first_pivot(2) = static_cast<Scalar>(0.5 * tiny * problem.largest(2));
  problem.rules.pivots.bound = 1e-3;
  problem.first_pivot(3) = static_cast<Scalar>(5e-4 * problem.largest(3));
  problem.first_pivot(4) = Scalar(std::numeric_limits<Real>::quiet_NaN());
  problem.first_pivot(5) = Scalar(std::numeric_limits<Real>::infinity());
  problem.b[6 * problem.b_stride + 2] = Scalar(std::numeric_limits<Real>::quiet_NaN());
  problem.put_values();
}

/// Repeated entries, and a row longer than a block of the residual's sum.
inline SparseMatrix long_rows() {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < 600; ++i) {
    for (const double part : {5.0, 30.0}) entries.push_back({i, i, part});
    if (i > 0) entries.push_back({0, i, 0.01});
    if (i > 0) entries.push_back({i, i - 1, 1.0});
  }
  return from_entries(600, entries);
}

}  // namespace mfs::test
