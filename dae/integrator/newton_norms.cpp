#include "dae/integrator/newton_norms.hpp"

#include <cmath>

#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

constexpr int kLevels = StepEquations::kLevels;
/// The largest |H_i| of all rows, that of the constraints of each level and that of forces that are followed;
/// then sums: of weighted squares, of -F_i dq_i, of M_i and of M_i over the squared weight of v_i.
constexpr std::size_t kFollowed = 1 + kLevels, kLargest = kFollowed + 1, kSquares = kLargest,
                      kWork = kSquares + 1, kMass = kWork + 1, kWeightedMass = kMass + 1,
                      kNumbers = kWeightedMass + 1;

struct Largest {
  MFS_HOST_DEVICE Numbers<kNumbers> operator()(Numbers<kNumbers> a, const Numbers<kNumbers>& b) const {
    for (std::size_t k = 0; k < kLargest; ++k)
      if (b.of[k] > a.of[k]) a.of[k] = b.of[k];
    for (std::size_t k = kLargest; k < kNumbers; ++k) a.of[k] += b.of[k];
    return a;
  }
};

/// Of row i, or, behind all rows, of an entry of [q, v].
struct Look {
  const double* h;
  std::size_t rows, first_constraint, m;
  const double *q, *v, *weights;
  const double *inertia, *ringing, *followed;
  double* before;
  std::size_t n;
  MFS_HOST_DEVICE Numbers<kNumbers> operator()(std::size_t i) const {
    Numbers<kNumbers> numbers{};
    if (i < rows) {
      const double size = std::isfinite(h[i]) ? std::abs(h[i]) : HUGE_VAL;
      numbers.of[0] = size;
      const std::size_t end = first_constraint + kLevels * m;
      if (i >= first_constraint && i < end) numbers.of[1 + (i - first_constraint) / m] = size;
    } else {
      const std::size_t k = i - rows;
      const double value = k < n ? q[k] : v[k - n], change = (value - before[k]) / weights[k];
      if (k < n) {
        numbers.of[kWork] = -ringing[k] * before[2 * n + k] * (value - before[k]);
        before[2 * n + k] = h[k];
        numbers.of[kFollowed] = followed[k] * std::abs(h[k]);
      } else {
        numbers.of[kMass] = inertia[k - n];
        numbers.of[kWeightedMass] = inertia[k - n] / (weights[k] * weights[k]);
      }
      before[k] = value;
      numbers.of[kSquares] = change * change;
    }
    return numbers;
  }
};

}  // namespace

NewtonNorms newton_norms(const Executor& executor, const StepEquations& equations, const double* h,
                         const StepState& state, const Array<double>& weights, Array<double>& before) {
  const std::size_t n = state.q.size(), rows = static_cast<std::size_t>(equations.size());
  if (before.size() != 3 * n) {
    before.resize(executor, 3 * n);
    fill(executor, 3 * n, 0.0, before.data());
  }
  const Look look{h,
                  rows,
                  static_cast<std::size_t>(equations.first_constraint()),
                  state.lambda.size(),
                  state.q.data(),
                  state.v.data(),
                  weights.data(),
                  equations.inertia().data(),
                  equations.ringing().data(),
                  equations.followed().data(),
                  before.data(),
                  n};
  const Numbers<kNumbers> found = fold(executor, rows + 2 * n, Numbers<kNumbers>{}, look, Largest{});
  const double sum = found.of[kSquares], mass = found.of[kMass];
  const double energy = std::abs(found.of[kWork]) * found.of[kWeightedMass];
  return {found.of[0],
          {found.of[1], found.of[2], found.of[3]},
          n == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(2 * n)),
          mass > 0.0 ? std::sqrt(energy) / mass : 0.0,
          found.of[kFollowed]};
}

}  // namespace mfs::dae
