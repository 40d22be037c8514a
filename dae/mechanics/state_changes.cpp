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
/// Parts of a step that are looked at for one operation.
constexpr int kMostParts = 400;
/// What changes in less than this part of a step has been met by the one before.
constexpr double kMet = 1e-3;
/// Of what lasts until then, where a step ends in it: what is short there is seldom as at its ends.
constexpr double kWithin = 0.382;
/// How near to a change a step ends before it, in parts of the step.
constexpr double kNear = 1e-9;

Interval widened(const Interval& x, double by) {
  return {x.low - by, x.high + by};
}
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
    const std::vector<double>&from = watched_.from, &to = watched_.to;
    const std::size_t n = from.size() / 2;
    const double h = to[0] - from[0];
    const auto line = [&](std::size_t i, double s) { return from[i] + s * (to[i] - from[i]); };
    q_.resize(n);
    v_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t q = 1 + i, v = 1 + n + i;
      const double way = to[q] - from[q], leaving = h * from[v], arriving = h * to[v];
      const auto cubic = [&](double s) {
        return from[q] +
               s * (leaving + s * (3 * way - 2 * leaving - arriving + s * (leaving + arriving - 2 * way)));
      };
      const auto bend = [&](double s) {
        return std::abs(2 * (3 * way - 2 * leaving - arriving) + 6 * s * (leaving + arriving - 2 * way));
      };
      const double off = (end - begin) * (end - begin) / 8 * std::max(bend(begin), bend(end));
      q_[i] = widened(hull(cubic(begin), cubic(end)), off);
      v_[i] = hull(line(v, begin), line(v, end));
    }
    watched_.function->enclose(hull(line(0, begin), line(0, end)), q_.data(), v_.data(), results_);
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

StateChanges::StateChanges(const std::vector<const StateFunction*>& functions) {
  for (const StateFunction* function : functions) {
    std::vector<int> operations = function->changing_operations();
    if (!operations.empty()) watched_.push_back({function, std::move(operations), {}, {}, {}, {}});
  }
}

std::vector<double> StateChanges::ends(const StateFunction& function, double t, const double* q,
                                       const double* v) {
  std::vector<double> ends = {t};
  for (const int i : function.coordinates()) ends.push_back(q[i]);
  for (const int i : function.coordinates()) ends.push_back(v[i]);
  return ends;
}

void StateChanges::go_on(double t, const double* q, const double* v) {
  for (Watched& watched : watched_) {
    watched.from = watched.to = ends(*watched.function, t, q, v);
    const std::vector<Interval> results = Along(watched).between(0.0, 0.0);
    const bool begins = watched.range.empty();
    watched.before.clear();
    watched.seen = std::max(0, watched.seen - 1);
    watched.ignored = std::max(0, watched.ignored - 1);
    for (std::size_t k = 0; k < watched.operations.size(); ++k) {
      const Interval& now = results[watched.operations[k]];
      begins ? watched.range.push_back(now) : void(watched.range[k] = hull(watched.range[k], now));
      watched.before.push_back(now.low);
    }
  }
}

ChangeWatch::Verdict StateChanges::look(double t, const double* q, const double* v) {
  Verdict verdict;
  for (Watched& watched : watched_) {
    watched.to = ends(*watched.function, t, q, v);
    Along along(watched);
    const std::vector<Interval> after = along.between(1.0, 1.0), between = along.between(0.0, 1.0);
    for (std::size_t k = 0; k < watched.operations.size(); ++k) {
      const int operation = watched.operations[k];
      const Interval ends = hull(watched.before[k], after[operation]);
      if (watched.function->compares(operation) && ends.width() > 0) verdict.turned = true;
      if (verdict.part < 1.0 || watched.ignored > 0) continue;
      const double range = std::max(watched.range[k].width(), ends.width());
      const double size = std::max(std::abs(ends.low), std::abs(ends.high));
      const Interval allowed = widened(ends, std::max(kLeaves * range, kRounding * size));
      if (excess(between[operation], allowed) == 0) continue;
      verdict.part = along.until_change(operation, ends, allowed);
      if (verdict.part < 1.0 && ++watched.seen > kMostSeen) watched.ignored = kIgnored;
    }
  }
  return verdict;
}

}  // namespace mfs::dae
