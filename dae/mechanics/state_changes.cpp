#include "dae/mechanics/state_changes.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace mfs::dae {
namespace {

/// By how much of its range a result has to leave what it is at the ends of a step, and where on the way
/// there the step is to end instead.
constexpr double kLeaves = 0.25, kFirst = 0.25;
/// What is rounding beside a result.
constexpr double kRounding = 1e-9;
/// What changes so often that it was seen so many times, in steps that were not so many more, lasts for no
/// moment, and is not looked at for so many steps.
constexpr int kMostSeen = 30, kIgnored = 200;
/// What is rounding beside an argument; a rate is not told by less.
constexpr double kResolved = 1e-13;
/// Parts of a step that are looked at for one operation.
constexpr int kMostParts = 400;
/// What changes in less than this part of a step has been met by the one before.
constexpr double kMet = 1e-3;
/// Of what lasts until then, where a step ends in it: what is short there is seldom as at its ends.
constexpr double kWithin = 0.382;
/// How near to a change a step ends before it, in parts of the step.
constexpr double kNear = 1e-9;

double distance(const Interval& from, double x) {
  return std::max({0.0, from.low - x, x - from.high});
}
double excess(const Interval& x, const Interval& allowed) {
  return std::max({0.0, allowed.low - x.low, x.high - allowed.high});
}

struct Part {
  double begin, end;
  double excess;
  bool operator<(const Part& other) const { return excess < other.excess; }
};

}  // namespace

/// Results of an expression along a step of which parts 0 to 1 are asked for.
class StateChanges::Along {
 public:
  explicit Along(const Watched& watched) : watched_(watched) {}

  const std::vector<Interval>& between(double begin, double end) {
    const End &from = watched_.from, &to = watched_.to;
    const std::size_t n = from.arguments.value.size();
    const double h = to.t - from.t;
    const auto line = [](double x, double y, double s) { return x + s * (y - x); };
    const auto on_line = [&](double x, double y) { return hull(line(x, y, begin), line(x, y, end)); };
    q_.resize(n);
    v_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double q = from.arguments.value[i], v = from.arguments.rate[i], v_to = to.arguments.rate[i];
      const double way = to.arguments.value[i] - q, leaving = h * v, arriving = h * v_to;
      const auto cubic = [&](double s) {
        return q +
               s * (leaving + s * (3 * way - 2 * leaving - arriving + s * (leaving + arriving - 2 * way)));
      };
      const auto bend = [&](double s) {
        return std::abs(2 * (3 * way - 2 * leaving - arriving) + 6 * s * (leaving + arriving - 2 * way));
      };
      const double off = (end - begin) * (end - begin) / 8 * std::max(bend(begin), bend(end));
      q_[i] = widened(hull(cubic(begin), cubic(end)), off);
      const double beside = way - 0.5 * (leaving + arriving);
      const double bow = std::abs(beside) > kResolved * std::abs(q) ? 6 * beside / h : 0.0;
      const auto rate = [&](double s) { return line(v, v_to, s) + bow * s * (1 - s); };
      v_[i] = widened(hull(rate(begin), rate(end)), 0.25 * std::abs(bow) * (end - begin) * (end - begin));
    }
    watched_.function->enclose(on_line(from.t, to.t), q_.data(), v_.data(), results_);
    return results_;
  }
  double at(int operation, double s) { return between(s, s)[operation].low; }

  /// The last part of the step at which `holds` after `first`, where it does, and before `last`.
  template <class Condition>
  static double last_of(double first, double last, const Condition& holds) {
    while (last - first > kNear) {
      const double middle = 0.5 * (first + last);
      (holds(middle) ? first : last) = middle;
    }
    return first;
  }

  /// Where a step is to end that does not tell by its `ends` that the result leaves `allowed`, or 1.
  double until_change(int operation, const Interval& ends, const Interval& allowed) {
    const double outside = leaves(operation, allowed);
    if (outside == 1.0) return 1.0;
    const double far = distance(ends, at(operation, outside));
    const auto is_near = [&](double s) { return distance(ends, at(operation, s)) <= kFirst * far; };
    const double part = last_of(0.0, outside, is_near);
    if (part >= kMet) return part;
    return kWithin * last_of(outside, 1.0, [&](double s) { return !is_near(s); });
  }

 private:
  /// Where the result leaves `allowed`, or 1.
  double leaves(int operation, const Interval& allowed) {
    std::priority_queue<Part> parts;
    const auto add = [&](double begin, double end) {
      const double off = excess(between(begin, end)[operation], allowed);
      if (off > 0) parts.push({begin, end, off});
    };
    add(0.0, 1.0);
    for (int i = 0; i < kMostParts && !parts.empty(); ++i) {
      const Part part = parts.top();
      parts.pop();
      const double middle = 0.5 * (part.begin + part.end);
      if (distance(allowed, at(operation, middle)) > 0) return middle;
      if (part.end - part.begin < kNear) continue;
      add(part.begin, middle);
      add(middle, part.end);
    }
    return 1.0;
  }

  const Watched& watched_;
  std::vector<Interval> q_, v_, results_;
};

StateChanges::StateChanges(const WatchedFunctions& functions) {
  for (const auto& function : functions) {
    Watched watched{function, {}, {}, {}};
    for (const int number : function->changing_operations()) watched.operations.push_back({number});
    if (!watched.operations.empty()) watched_.push_back(std::move(watched));
  }
}

void StateChanges::go_on(double t, const double* q, const double* v) {
  for (Watched& watched : watched_) {
    watched.from = watched.to = {t, watched.function->arguments(q, v)};
    const std::vector<Interval> results = Along(watched).between(0.0, 0.0);
    for (Operation& operation : watched.operations) {
      const Interval& now = results[operation.number];
      operation.results = hull(operation.results, now);
      operation.before = now.low;
      operation.seen = std::max(0, operation.seen - 1);
      operation.ignored = std::max(0, operation.ignored - 1);
    }
  }
}

ChangeWatch::Verdict StateChanges::look(double t, const double* q, const double* v) {
  Verdict verdict;
  for (Watched& watched : watched_) {
    watched.to = {t, watched.function->arguments(q, v)};
    Along along(watched);
    const std::vector<Interval> after = along.between(1.0, 1.0), between = along.between(0.0, 1.0);
    for (Operation& operation : watched.operations) {
      const int k = operation.number;
      const Interval ends = hull(operation.before, after[k]);
      if (watched.function->compares(k) && ends.width() > 0) verdict.turned = true;
      if (operation.ignored > 0) continue;
      const double given = watched.function->range(k);
      const double range = given > 0 ? given : std::max(operation.results.width(), ends.width());
      const double size = std::max(std::abs(ends.low), std::abs(ends.high));
      const Interval allowed = widened(ends, std::max(kLeaves * range, kRounding * size));
      if (excess(between[k], allowed) == 0) continue;
      const double part = along.until_change(k, ends, allowed);
      if (part < 1.0 && ++operation.seen > kMostSeen) operation.ignored = kIgnored;
      verdict.part = std::min(verdict.part, part);
    }
  }
  return verdict;
}

}  // namespace mfs::dae
