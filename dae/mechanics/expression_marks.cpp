// Times at which expressions are to be looked at.
#include <algorithm>
#include <cmath>

#include "dae/mechanics/expression.hpp"

namespace mfs::dae {
namespace {

/// Of the way between two comparisons: what is short there is seldom zero again at such a number.
constexpr double kBetween = 0.382;

/// Halvings of the time for one operation: as many as these let be evaluated in all, but not fewer than a
/// pulse takes that is very narrow.
constexpr double kMostEvaluations = 1e7;
constexpr int kLeastHalvings = 300, kMostHalvings = 20'000;

/// Adds where values, which are numbers of a kind of their own, become others, as late as they are what they
/// were.
void add_turns(const std::vector<Sample>& samples, const std::function<double(double)>& value,
               std::vector<double>& turns) {
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i].value == samples[i - 1].value) continue;
    double before = samples[i - 1].t, after = samples[i].t;
    for (;;) {
      const double middle = before + 0.5 * (after - before);
      if (middle <= before || middle >= after) break;
      (value(middle) == samples[i - 1].value ? before : after) = middle;
    }
    turns.push_back(before);
  }
}

/// On both sides of a time that is known but for rounding, and there.
std::vector<Sample> beside(double t, const TimeSpan& span, const std::function<double(double)>& value) {
  const double off = 1e-14 * std::max({std::abs(t), std::abs(span.begin), std::abs(span.end)});
  return {{t - off, value(t - off)}, {t, value(t)}, {t + off, value(t + off)}};
}

}  // namespace

std::vector<Expression::Dependence> Expression::dependences(
    int time, const std::vector<std::optional<double>>& others) const {
  using D = Dependence;
  std::vector<D> all;
  for (const Operation& o : operations_) {
    const auto of = [&](int k) { return k < 0 ? D::constant : all[k]; };
    if (o.op == Op::variable) {
      all.push_back(o.a == time ? D::linear : others[o.a] ? D::constant : D::unknown);
      continue;
    }
    const D a = of(o.a), b = of(o.b), most = std::max({a, b, of(o.c)});
    const bool keeps = o.op == Op::add || o.op == Op::subtract ||
                       (o.op == Op::multiply && std::min(a, b) == D::constant) ||
                       (o.op == Op::divide && b == D::constant);
    all.push_back(most == D::linear && !keeps ? D::other : most);
  }
  return all;
}

std::vector<std::size_t> Expression::uses(std::size_t i) const {
  std::vector<bool> used(i + 1, false);
  used[i] = true;
  std::vector<std::size_t> all;
  for (std::size_t k = i + 1; k-- > 0;) {
    if (!used[k]) continue;
    all.push_back(k);
    const Operation& o = operations_[k];
    if (o.op == Op::variable) continue;
    for (const int other : {o.a, o.b, o.c})
      if (other >= 0) used[other] = true;
  }
  std::reverse(all.begin(), all.end());
  return all;
}

void Expression::add_marks(int time, const std::vector<std::optional<double>>& others, const TimeSpan& span,
                           std::vector<double>& marks) const {
  std::vector<double> variables, at_0, at_1;
  for (const std::optional<double>& number : others) variables.push_back(number.value_or(0.0));
  variables.at(time) = 0.0;
  evaluate(variables, at_0);
  variables[time] = 1.0;
  evaluate(variables, at_1);
  std::vector<Interval> intervals(variables.begin(), variables.end()), result(operations_.size());
  const std::vector<Dependence> dependence = dependences(time, others);
  const auto of = [&](int k) { return k < 0 ? Dependence::constant : dependence[k]; };
  std::vector<double> turns;
  for (std::size_t i = 0; i < operations_.size(); ++i) {
    const Operation& o = operations_[i];
    if (dependence[i] != Dependence::other) continue;
    const std::vector<std::size_t> used = uses(i);
    const auto enclosure = [&](const Interval& t) {
      intervals[time] = t;
      for (const std::size_t k : used) evaluate_one(k, intervals, result);
      return result[i];
    };
    const double halvings = kMostEvaluations / (3.0 * static_cast<double>(used.size() * operations_.size()));
    const int most = std::clamp(static_cast<int>(halvings), kLeastHalvings, kMostHalvings);
    const auto value = [&](double t) { return enclosure(t).low; };
    const bool of_linear = std::max({of(o.a), of(o.b)}) == Dependence::linear;
    if (compares(o.op) && of_linear) {
      const double off = at_0[o.a] - at_0[o.b], rate = at_1[o.a] - at_1[o.b] - off;
      if (std::isfinite(-off / rate)) add_turns(beside(-off / rate, span, value), value, turns);
    } else if (compares(o.op)) {
      add_turns(resolved(enclosure, span, most), value, turns);
    } else if (o.op >= Op::sin || o.op == Op::power ||
               (o.op == Op::divide && of(o.b) != Dependence::constant)) {
      if ((o.op == Op::sin || o.op == Op::cos) && of_linear) continue;
      mark_fast_changes(resolved(enclosure, span, most), kQuarter, kFaster, marks);
    }
  }
  std::sort(turns.begin(), turns.end());
  for (std::size_t i = 0; i < turns.size(); ++i) {
    if (i > 0 && turns[i] > turns[i - 1])
      marks.push_back(turns[i - 1] + kBetween * (turns[i] - turns[i - 1]));
    marks.push_back(turns[i]);
  }
}

std::vector<int> Expression::changing_operations(const std::vector<bool>& move) const {
  std::vector<bool> moves;
  std::vector<int> changing;
  for (const Operation& o : operations_) {
    if (o.op == Op::variable) {
      moves.push_back(move[o.a]);
      continue;
    }
    const auto of = [&](int k) { return k >= 0 && moves[k] ? 1 : 0; };
    const int moving = of(o.a) + of(o.b) + of(o.c);
    moves.push_back(moving > 0);
    if (moving > 1 || (moving == 1 && o.op != Op::add && o.op != Op::subtract && o.op != Op::multiply))
      changing.push_back(static_cast<int>(moves.size()) - 1);
  }
  return changing;
}

}  // namespace mfs::dae
