#include "dae/integrator/newton_norms.hpp"

#include <cmath>

#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

constexpr int kLevels = StepEquations::kLevels;
/// The largest |H_i| of all rows, that of the constraints of each level, the sum of weighted squares.
constexpr std::size_t kNumbers = 1 + kLevels + 1;

struct Largest {
  MFS_HOST_DEVICE Numbers<kNumbers> operator()(Numbers<kNumbers> a, const Numbers<kNumbers>& b) const {
    for (std::size_t k = 0; k + 1 < kNumbers; ++k)
      if (b.of[k] > a.of[k]) a.of[k] = b.of[k];
    a.of[kNumbers - 1] += b.of[kNumbers - 1];
    return a;
  }
};

/// Of row i, or, behind all rows, of an entry of [q, v].
struct Look {
  const double* h;
  std::size_t rows, first_constraint, m;
  const double *q, *v, *weights;
  double* y;
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
      const double value = k < n ? q[k] : v[k - n], change = (value - y[k]) / weights[k];
      y[k] = value;
      numbers.of[kNumbers - 1] = change * change;
    }
    return numbers;
  }
};

}  // namespace

NewtonNorms newton_norms(const Executor& executor, const StepEquations& equations, const double* h,
                         const StepState& state, const Array<double>& weights, Array<double>& y) {
  const std::size_t n = state.q.size(), rows = static_cast<std::size_t>(equations.size());
  if (y.size() != 2 * n) {
    y.resize(executor, 2 * n);
    fill(executor, 2 * n, 0.0, y.data());
  }
  const Look look{h,
                  rows,
                  static_cast<std::size_t>(equations.first_constraint()),
                  state.lambda.size(),
                  state.q.data(),
                  state.v.data(),
                  weights.data(),
                  y.data(),
                  n};
  const Numbers<kNumbers> found = fold(executor, rows + 2 * n, Numbers<kNumbers>{}, look, Largest{});
  const double sum = found.of[kNumbers - 1];
  return {found.of[0],
          {found.of[1], found.of[2], found.of[3]},
          n == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(2 * n))};
}

}  // namespace mfs::dae
