#include "dae/integrator/dense_output.hpp"

#include <cstddef>

namespace mfs::dae {

State state_between(double t, const StepState& before, const Array<double>& lambda, const StepState& after) {
  const double h = after.t - before.t, x = (t - before.t) / h, y = x * x * x;
  const auto line = [x](double from, double to) { return from + x * (to - from); };
  State state{t, {}, {}, {}, {}};
  for (std::size_t i = 0; i < after.q.size(); ++i) {
    const double q0 = before.q.data()[i], v0 = before.v.data()[i], a0 = before.a.data()[i];
    const double q1 = after.q.data()[i], v1 = after.v.data()[i], a1 = after.a.data()[i];
    state.q.push_back(q0 + h * v0 * (x - y * (6 - x * (8 - 3 * x))) +
                      0.5 * h * h * a0 * x * x * (1 - x * (3 - x * (3 - x))) +
                      (q1 - q0) * y * (10 - x * (15 - 6 * x)) - h * v1 * y * (4 - x * (7 - 3 * x)) +
                      0.5 * h * h * a1 * y * (1 - x * (2 - x)));
    state.v.push_back(v0 + h * a0 * x * (1 - x * (2 - x)) + (v1 - v0) * x * x * (3 - 2 * x) -
                      h * a1 * x * x * (1 - x));
    state.a.push_back(line(a0, a1));
  }
  for (std::size_t i = 0; i < after.lambda.size(); ++i) {
    const double last = after.lambda.data()[i];
    state.lambda.push_back(lambda.size() == after.lambda.size() ? line(lambda.data()[i], last) : last);
  }
  return state;
}

}  // namespace mfs::dae
