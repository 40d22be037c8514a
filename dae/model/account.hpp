// What has to be followed through time, not read off one state: the work of drives, loads and dampers, and
// how many turns a joint has made.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "dae/model/model.hpp"

namespace mfs::dae {

/// The integral of `count` functions of time from their values at a sequence of times: over each interval, of
/// the polynomial through its end and the three values before.
class RunningIntegral {
 public:
  explicit RunningIntegral(std::size_t count) : sum_(count) {}
  /// Times ascend; what is not after the last is left out.
  void add(double t, const std::vector<double>& values);
  /// From the first time to t, which is not before the last time but one.
  std::vector<double> at(double t) const;

 private:
  struct Sample {
    double t;
    std::vector<double> values;
  };
  std::vector<double> polynomial(double t) const;
  void add_integral(double from, double to, double sign, std::vector<double>& sum) const;

  std::vector<Sample> last_;  // four at most, the latest at the end
  std::vector<double> sum_;
};

/// Work since the beginning, J.
struct Work {
  double dissipated = 0, input = 0;
};

class Account {
 public:
  /// `model` has to live as long. `along_steps`: states of all steps will be shown, so that work can be
  /// summed.
  Account(const MultibodyModel& model, bool along_steps);

  /// The states of steps and outputs, as time goes on.
  void follow(const State& state);

  Work work(double t) const;
  /// The angles of model.joints[joint], turns included: each is the one nearest to where the rate takes it
  /// from the last state that was shown.
  std::vector<double> angles(std::size_t joint, const State& state) const;
  /// Of `energy`, J, now; the balance begins with zero.
  double balance(const Energy& energy, double t) const;
  void begin_balance(const Energy& energy);
  bool has_begun() const { return has_begun_; }

  /// Elements that bring in energy or take it away. The system's energy is constant where there are none.
  static std::vector<ModelElement> active_elements(const MultibodyModel& model);

 private:
  struct Turn {
    double t = 0;
    std::vector<double> angle, rate;
  };

  const MultibodyModel& model_;
  std::vector<ModelElement> active_;
  RunningIntegral work_;
  std::vector<Turn> turns_;  // of each joint
  double begin_ = 0;         // the sum of all energies
  bool has_begun_ = false;
};

}  // namespace mfs::dae
