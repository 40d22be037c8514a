#include "dae/model/account.hpp"

#include <cmath>

#include "dae/model/measure.hpp"

namespace mfs::dae {
namespace {

constexpr std::size_t kSamples = 4;  // of a cubic, which Gauss' rule of two points integrates exactly

double sum_of(const Energy& energy) {
  return energy.kinetic + energy.potential + energy.elastic;
}

}  // namespace

std::vector<double> RunningIntegral::polynomial(double t) const {
  std::vector<double> value(sum_.size());
  for (std::size_t i = 0; i < last_.size(); ++i) {
    double lagrange = 1;
    for (std::size_t j = 0; j < last_.size(); ++j)
      if (j != i) lagrange *= (t - last_[j].t) / (last_[i].t - last_[j].t);
    for (std::size_t k = 0; k < value.size(); ++k) value[k] += lagrange * last_[i].values[k];
  }
  return value;
}

void RunningIntegral::add_integral(double from, double to, double sign, std::vector<double>& sum) const {
  const double half = 0.5 * (to - from), middle = 0.5 * (from + to), offset = half / std::sqrt(3.0);
  for (const double t : {middle - offset, middle + offset}) {
    const std::vector<double> value = polynomial(t);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += sign * half * value[k];
  }
}

void RunningIntegral::add(double t, const std::vector<double>& values) {
  if (!last_.empty() && t <= last_.back().t) return;
  if (last_.size() == kSamples) last_.erase(last_.begin());
  last_.push_back({t, values});
  if (last_.size() > 1) add_integral(last_[last_.size() - 2].t, t, 1.0, sum_);
}

std::vector<double> RunningIntegral::at(double t) const {
  std::vector<double> sum = sum_;
  if (!last_.empty() && t != last_.back().t) add_integral(t, last_.back().t, -1.0, sum);
  return sum;
}

std::vector<ModelElement> Account::active_elements(const MultibodyModel& model) {
  std::vector<ModelElement> active;
  for (const auto* actions : {&model.motions, &model.forces})
    for (const ModelAction& action : *actions)
      active.insert(active.end(), action.elements.begin(), action.elements.end());
  for (const FlexibleBody& body : model.flexible_bodies)
    if (body.solid->is_damped()) active.push_back({body.solid, 0});
  return active;
}

Account::Account(const MultibodyModel& model, bool along_steps)
    : model_(model), work_(2), turns_(model.joints.size()) {
  if (along_steps) active_ = active_elements(model);
}

void Account::follow(const State& state) {
  if (!active_.empty()) {
    const Power now = power(active_, state);
    work_.add(state.t, {now.dissipated, now.input});
  }
  for (std::size_t i = 0; i < model_.joints.size(); ++i) {
    if (angles_of(model_.joints[i].kind) == 0) continue;
    std::vector<double> angle = angles(i, state);
    turns_[i] = {state.t, std::move(angle), joint_motion(model_.joints[i], state).angle_rate};
  }
}

Work Account::work(double t) const {
  if (active_.empty()) return {};
  const std::vector<double> sum = work_.at(t);
  return {sum[0], sum[1]};
}

std::vector<double> Account::angles(std::size_t joint, const State& state) const {
  const double turn = 2 * std::acos(-1.0);
  JointMotion motion = joint_motion(model_.joints[joint], state);
  const Turn& last = turns_[joint];
  for (std::size_t k = 0; k < last.angle.size(); ++k) {
    const double expected = last.angle[k] + 0.5 * (last.rate[k] + motion.angle_rate[k]) * (state.t - last.t);
    motion.angle[k] += turn * std::round((expected - motion.angle[k]) / turn);
  }
  return motion.angle;
}

void Account::begin_balance(const Energy& energy) {
  begin_ = sum_of(energy);
  has_begun_ = true;
}

double Account::balance(const Energy& energy, double t) const {
  const Work done = work(t);
  return sum_of(energy) + done.dissipated - done.input - begin_;
}

}  // namespace mfs::dae
