// Sees from the steps of a run that it will not come to its end.
#pragma once

#include <cmath>
#include <cstdint>

namespace mfs::dae {

class StepWatch {
 public:
  enum class Verdict { go_on, forces_jump, ever_faster, end_too_far };

  StepWatch(double t0, double t_end) : t_end_(t_end), looked_at_(t0) {}

  /// After step `number` (1, 2, ...), which has ended at `t` and was tried again so many times.
  ///
  /// Many steps that are tried again and many more that are needed are those of a force that jumps wherever
  /// the motion goes, as friction -sign(rate), which holds it. Steps that are still needed and get twice as
  /// many whenever twice as many have been taken, again and again, are those of a motion by exp(t) or tan(t):
  /// where it turns a body no error ends that. A motion by sin(t^6) is none of those yet. What would take
  /// years whatever a step costs, once the motion had time to settle, has an end that is too far.
  Verdict judge(std::int64_t number, double t, int rejections) {
    tried_again_ += rejections;
    if (number % kLooksBack != 0) return Verdict::go_on;
    left_ = kLooksBack * (t_end_ - t) / (t - looked_at_);
    const bool often = tried_again_ >= kTriedAgain * kLooksBack;
    tried_again_ = 0;
    looked_at_ = t;
    if (number == next_) {
      doubled_ = left_ >= kGrowth * left_before_ ? doubled_ + 1 : 0;
      left_before_ = left_;
      next_ *= 2;
      if (doubled_ >= kMostDoubled && left_ > kMostLeft) return Verdict::ever_faster;
    }
    if (number >= kSettled && left_ > kNever) return Verdict::end_too_far;
    return often && left_ > kMostLeft ? Verdict::forces_jump : Verdict::go_on;
  }
  /// Steps to the end, by the last kLooksBack of them.
  double left() const { return left_; }

  static constexpr int kLooksBack = 2000;

 private:
  static constexpr double kTriedAgain = 0.25, kMostLeft = 1e7, kGrowth = 1.8, kNever = 1e15;
  static constexpr std::int64_t kSettled = 20'000;
  static constexpr int kMostDoubled = 3;

  double t_end_, looked_at_;
  int tried_again_ = 0;  ///< steps, since time was looked_at_
  double left_ = 0.0, left_before_ = HUGE_VAL;
  std::int64_t next_ = kLooksBack;
  int doubled_ = 0;  ///< times in a row
};

}  // namespace mfs::dae
