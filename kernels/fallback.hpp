// When a factorization takes a slower way that other values may not need.
#pragma once

#include <algorithm>

namespace mfs {

/// A slower way: once it was needed it stays active, but now and then it is tried without, as other values
/// may not need it: at once, and if that is in vain after 8 and then after each 64 factorizations.
class Fallback {
 public:
  bool active() const { return active_; }
  /// Around each factorization.
  void begin() {
    retried_ = active_ && ++active_for_ >= interval_;
    if (retried_) active_ = false;
  }
  void activate() { active_ = true; }
  void end() {
    if (retried_ || !active_) active_for_ = 0;
    interval_ = !active_ ? 1 : retried_ ? std::min(kGrowth * interval_, kLongestInterval) : interval_;
  }

 private:
  static constexpr int kGrowth = 8, kLongestInterval = 64;
  bool active_ = false, retried_ = false;
  int active_for_ = 0, interval_ = 1;
};

}  // namespace mfs
