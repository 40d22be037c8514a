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
#pragma once

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

}  // namespace mfs::dae
