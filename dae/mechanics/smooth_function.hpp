// Functions of one variable that are twice continuously differentiable: of time, for prescribed motions and
// loads, whose second derivative enters the constraints on accelerations; of length, for the force of a
// spring.
#pragma once

#include <memory>
#include <vector>

#include "dae/mechanics/interval.hpp"
#include "dae/mechanics/time_span.hpp"

namespace mfs::dae {

/// A function's value and its first two derivatives.
struct Jet {
  double value = 0.0, first = 0.0, second = 0.0;
};

class SmoothFunction {
 public:
  virtual ~SmoothFunction() = default;
  virtual Jet at(double x) const = 0;
  /// The value and the first derivative, or the value alone, where those that are left out may be infinite.
  virtual Jet slope(double x) const { return at(x); }
  virtual double value(double x) const { return at(x).value; }
  /// Adds times at which it is to be looked at, as it may be other there than its values farther off let
  /// expect, where x is time and goes through `span`.
  virtual void add_marks(const TimeSpan& /*span*/, std::vector<double>& /*marks*/) const {}

  /// The operations that it is made of, as WatchedFunction: one, unless it knows better.
  virtual std::vector<int> changing_operations() const { return {0}; }
  virtual bool compares(int /*operation*/) const { return false; }
  virtual double range(int /*operation*/) const { return 0.0; }
  virtual void enclose(const Interval& x, std::vector<Interval>& results) const = 0;
};

using Function = std::shared_ptr<const SmoothFunction>;

Function constant_function(double value);
/// value + slope x.
Function linear_function(double value, double slope);
/// offset + amplitude sin(2 pi frequency x + phase); phase in radians. Throws InvalidInput unless frequency >
/// 0.
Function harmonic_function(double offset, double amplitude, double frequency, double phase);
/// From `before` (x <= begin) to `after` (x >= end) by the quintic 10 s^3 - 15 s^4 + 6 s^5 of
/// s = (x - begin) / (end - begin). Throws InvalidInput unless begin < end.
Function smooth_step(double begin, double end, double before, double after);
/// The natural cubic spline through (x[i], y[i]), continued by straight lines (there its second derivative is
/// zero). Throws InvalidInput unless there are two points or more, x ascends strictly and all is finite.
Function spline_function(std::vector<double> x, std::vector<double> y);

}  // namespace mfs::dae
