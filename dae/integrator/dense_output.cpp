#include "dae/integrator/dense_output.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "dae/integrator/body_turns.hpp"
#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

using Part = Array<double> StepState::*;

constexpr int kMostStates = kMostPast + 1;

/// Of the polynomial through values at these times: what each of them counts at t (Lagrange).
std::vector<double> lagrange_shares(const std::vector<double>& times, double t) {
  std::vector<double> shares(times.size(), 1.0);
  for (std::size_t i = 0; i < times.size(); ++i)
    for (std::size_t j = 0; j < times.size(); ++j)
      if (j != i) shares[i] *= (t - times[j]) / (times[i] - times[j]);
  return shares;
}

/// Some of the sums over points that PointSums has: six at once, which is what a device folds.
struct SomeSums {
  const double *x, *now;
  double mean[3];  ///< of `now`
  bool last;
  MFS_HOST_DEVICE Numbers<6> operator()(std::size_t point) const {
    const double* const here = x + 3 * point;
    Numbers<6> sums;
    for (int j = 0; j < 3; ++j) {
      const double from_mean = now[3 * point + j] - mean[j];
      sums.of[j] = here[last ? 2 : 0] * from_mean;
      sums.of[3 + j] = last ? here[j] : here[1] * from_mean;
    }
    return sums;
  }
};

/// Vectors of points, those of each state by a matrix.
struct Turn {
  const double* from[kMostStates];
  double matrix[kMostStates][9];
  double shift[3];
  int states;
  double* to;
  MFS_HOST_DEVICE void operator()(std::size_t point) const {
    double sum[3] = {shift[0], shift[1], shift[2]};
    for (int k = 0; k < states; ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) sum[i] += matrix[k][3 * i + j] * from[k][3 * point + j];
    for (int i = 0; i < 3; ++i) to[3 * point + i] = sum[i];
  }
};

/// What is known on both sides of a time: the present state first, as many as positions need.
class KnownStates {
 public:
  KnownStates(const Executor& executor, const StepState& now, const PastStates& past, int degree)
      : executor_(executor), of_rates_(static_cast<std::size_t>(degree) + 1), states_{&now} {
    for (std::size_t k = 0; k < past.size() && states_.size() <= of_rates_; ++k) states_.push_back(&past[k]);
    of_rates_ = std::min(of_rates_, states_.size());
  }

  std::size_t count(Part part) const { return part == &StepState::q ? states_.size() : of_rates_; }

  void interpolate(double t, Part part, std::size_t count, StepState& there) const {
    const std::size_t size = (states_[0]->*part).size();
    std::vector<const double*> values;
    for (std::size_t k = 0; k < count; ++k) values.push_back((states_[k]->*part).data());
    (there.*part).resize(executor_, size);
    combine(executor_, size, 0.0, (there.*part).data(), shares(t, count), values);
  }

  void turn(double t, const PointRange& body, StepState& there) const {
    const auto first = static_cast<std::size_t>(body.first), points = static_cast<std::size_t>(body.count);
    std::vector<PointSums> sums = sums_of(body);
    const TurnedShares of_position = turned_shares(sums, body.count, shares(t, sums.size()));
    sums.resize(of_rates_);
    const TurnedShares of_rates = turned_shares(sums, body.count, shares(t, sums.size()));
    for (const Part part : {&StepState::q, &StepState::v, &StepState::a}) {
      const TurnedShares& turned = part == &StepState::q ? of_position : of_rates;
      Turn turn{{}, {}, {}, static_cast<int>(count(part)), (there.*part).data() + first};
      if (part == &StepState::q) std::copy(turned.shift.begin(), turned.shift.end(), turn.shift);
      for (std::size_t k = 0; k < count(part); ++k) {
        turn.from[k] = (states_[k]->*part).data() + first;
        std::copy(turned.matrix[k].begin(), turned.matrix[k].end(), turn.matrix[k]);
      }
      for_each(executor_, points, turn, 54 * points);
    }
  }

 private:
  std::vector<double> shares(double t, std::size_t count) const {
    std::vector<double> times;
    for (std::size_t k = 0; k < count; ++k) times.push_back(states_[k]->t);
    return lagrange_shares(times, t);
  }
  std::vector<PointSums> sums_of(const PointRange& body) const {
    const auto first = static_cast<std::size_t>(body.first), points = static_cast<std::size_t>(body.count);
    const double* const now = states_[0]->q.data() + first;
    SomeSums some{now, now, {}, true};
    const Numbers<6> of_now = fold(executor_, points, Numbers<6>{}, some, Sum{});
    for (int j = 0; j < 3; ++j) some.mean[j] = of_now.of[3 + j] / body.count;
    std::vector<SomeSums> parts;  // the first six sums of each state, and the last
    for (const StepState* state : states_) {
      some.x = state->q.data() + first;
      for (const bool last : {false, true}) {
        some.last = last;
        parts.push_back(some);
      }
    }
    const std::vector<Numbers<6>> found = folds(executor_, points, Numbers<6>{}, parts, Sum{});
    std::vector<PointSums> sums(states_.size());
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const double *const begin = found[2 * k].of, *const end = found[2 * k + 1].of;
      std::copy_n(begin, 6, sums[k].x_by_now.begin());
      std::copy_n(end, 3, sums[k].x_by_now.begin() + 6);
      std::copy_n(end + 3, 3, sums[k].x.begin());
    }
    return sums;
  }

  const Executor& executor_;
  std::size_t of_rates_;  ///< states that polynomials of v and a go through
  std::vector<const StepState*> states_;
};

}  // namespace

State state_between(double t, const StepState& before, const StepState& after) {
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
    const bool known = before.lambda.size() == after.lambda.size();
    state.lambda.push_back(known ? line(before.lambda.data()[i], last) : last);
  }
  return state;
}

void PastStates::add(StepState& state) {
  if (states_.size() < most_) states_.emplace_back();
  std::rotate(states_.begin(), states_.end() - 1, states_.end());
  std::swap(states_.front(), state);
  known_multipliers_ = std::min(known_multipliers_ + 1, states_.size());
}

void PastStates::forget_multipliers() {
  known_multipliers_ = 0;
  for (StepState& state : states_) state.lambda = Array<double>();
}

void interpolate(const Executor& executor, const std::vector<PointRange>& bodies, double t,
                 const StepState& now, const PastStates& past, int degree, StepState& there) {
  const KnownStates known(executor, now, past, degree);
  std::size_t with_multipliers = 1;
  while (with_multipliers <= past.size() && past[with_multipliers - 1].lambda.size() == now.lambda.size())
    ++with_multipliers;
  there.t = t;
  for (const Part part : {&StepState::q, &StepState::v, &StepState::a})
    known.interpolate(t, part, known.count(part), there);
  known.interpolate(t, &StepState::lambda, std::min(with_multipliers, known.count(&StepState::lambda)),
                    there);
  for (const PointRange& body : bodies) known.turn(t, body, there);
}

}  // namespace mfs::dae
