// Sees that BDF of order 3 to 5 works where it is not stable.
//
// These orders let undamped oscillations grow: by up to 1.05, 1.19 and 1.38 a step, from w h = 0.3, 0.4 and
// 0.72 up to 1.9, 4.7 and beyond (the roots of the formulas for y' = i w y). What grows is cut by the error
// control: the step shrinks until w h leaves the range, and with the many frequencies of a flexible body it
// ends at that of the highest. Orders 1 and 2 are stable for all w h.
//
// A step of an oscillation multiplies its differences by 1 - exp(-i w h): each difference is 2 sin(w h / 2)
// times the one before, and the second difference of one points against it. So where the highest differences,
// which are what limits the step, have had a ratio of more than kUnstable over some steps, and those of order
// k + 1 and k - 1 point against each other, an oscillation in that range limits the step. Where a smooth
// motion does, the ratio is below 0.3 at the usual tolerances. (CVODE's and IDA's STALD has the same purpose
// and takes the roots from differences of five steps: Hindmarsh, UCRL-ID-110933 (1992).)
//
// A motion may be an oscillation itself, as the waves that run down a swinging chain: at a loose tolerance
// its steps are as long as w h = 0.8, where order 5 lets nothing grow yet that would matter, but orders 3 and
// 4 do. Order 2 needs half of that, and after an oscillation that only order 5 had let grow its steps become
// longer than before. So what order 2 comes to tells a false alarm of order 5.
#pragma once

#include <algorithm>

namespace mfs::dae {

class StabilityWatch {
 public:
  /// Weighted norms of the differences of order k + 1, k and k - 1 at the new time, and of the sum of the
  /// first and the last of them.
  void add(double highest, double middle, double lowest, double sum) {
    const auto renew = [](double& mean, double value) { mean += kNew * (value - mean); };
    renew(highest_, highest * highest);
    renew(middle_, middle * middle);
    renew(along_, 0.5 * (sum * sum - highest * highest - lowest * lowest));
    ++steps_;
  }
  bool unstable() const {
    return steps_ >= kSteps && highest_ > kUnstable * kUnstable * middle_ && along_ < 0.0;
  }
  void forget() { *this = {}; }

 private:
  static constexpr double kUnstable = 0.6;
  static constexpr double kNew = 0.1;  ///< share of the newest step in the means
  static constexpr int kSteps = 20;    ///< with fewer, nothing is said

  double highest_ = 0.0, middle_ = 0.0, along_ = 0.0;
  int steps_ = 0;
};

/// For how long orders above 2 are left after an alarm.
class OrderHold {
 public:
  /// Whether they are not to be taken now.
  bool holds() const { return held_ > 0; }
  /// Whether an alarm means nothing, for some time after a false one.
  bool ignores_alarms() const { return ignored_ > 0; }
  /// An alarm after a step of `step`: twice as long as the last time. `doubtful`: it may be false.
  void begin(double step, bool doubtful) {
    held_ = next_held_;
    next_held_ = std::min(2 * next_held_, kMost);
    step_before_ = step;
    doubtful_ = doubtful;
    longest_ = 0.0;
    steps_ = 0;
  }
  /// A step of `step` has been taken. After a false alarm the hold ends, and alarms are ignored, twice as
  /// long as after the last one.
  void add(double step) {
    if (ignored_ > 0) --ignored_;
    if (held_ == 0) return;
    --held_;
    longest_ = std::max(longest_, step);
    if (!doubtful_ || ++steps_ < kJudged || longest_ >= kPays * step_before_) return;
    held_ = 0;
    next_held_ = std::max(next_held_ / 2, kFirst);
    ignored_ = next_ignored_;
    next_ignored_ = std::min(2 * next_ignored_, kMost);
  }

 private:
  static constexpr int kFirst = 50, kMost = 5000;  ///< steps
  static constexpr int kJudged = 10;               ///< steps of order 2 before an alarm is called false
  static constexpr double kPays = 0.75;            ///< what they have to come to, in parts of the one before

  int held_ = 0, next_held_ = kFirst;
  int ignored_ = 0, next_ignored_ = 2 * kFirst;
  bool doubtful_ = false;
  double step_before_ = 0.0, longest_ = 0.0;
  int steps_ = 0;
};

}  // namespace mfs::dae
