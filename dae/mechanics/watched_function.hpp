// What ChangeWatch looks at along a step: a function of some arguments, as coordinates and their rates or the
// length of a spring, that is made of operations on intervals (interval.hpp).
#pragma once

#include <memory>
#include <vector>

#include "dae/mechanics/interval.hpp"

namespace mfs::dae {

class WatchedFunction {
 public:
  virtual ~WatchedFunction() = default;

  /// Its arguments and their rates in a state of the system. Along a step arguments follow cubics.
  struct Arguments {
    std::vector<double> value, rate;
  };
  virtual Arguments arguments(const double* q, const double* v) const = 0;
  /// Overwrites `results` by those of all operations, where time, arguments and rates are in these intervals.
  virtual void enclose(const Interval& t, const Interval* arguments, const Interval* rates,
                       std::vector<Interval>& results) const = 0;
  /// Operations that can change suddenly (Expression::changing_operations), and whether one is a comparison.
  virtual std::vector<int> changing_operations() const = 0;
  virtual bool compares(int operation) const = 0;
  /// What an operation's result is to be compared with; 0: the range of its values in the run.
  virtual double range(int /*operation*/) const { return 0.0; }
};

using WatchedFunctions = std::vector<std::shared_ptr<const WatchedFunction>>;

}  // namespace mfs::dae
