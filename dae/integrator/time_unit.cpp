#include "dae/integrator/time_unit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include <mfs/error.hpp>

#include "dae/integrator/initial_conditions.hpp"

namespace mfs::dae {
namespace {

/// Units of length in one of time with which that is kept.
constexpr double kSlowest = 1.0 / 4.0, kFastest = 1024.0;
/// How far things move in the unit of time that is chosen.
constexpr double kMoved = 4.0;
/// Longer than that, in parts of the run, it is not: what is as slow stays where it is.
constexpr double kLongest = 1024.0;
/// Times at which forces and motions are looked at, each in its own part of the run. No harmonic with a whole
/// number of periods is zero at all of them.
constexpr int kSamples = 16;
constexpr double kWithinPart = 0.382;

double product(const std::vector<double>& x, const std::vector<double>& y) {
  return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
}

/// How fast the system moves about `q`: rates, in units of its coordinates' scales. What is no number tells
/// nothing and is 0.
class ModelRates {
 public:
  ModelRates(const ConstrainedSystem& system, const State& start)
      : system_(system),
        q_(start.q),
        zero_(q_.size() + static_cast<std::size_t>(system.constraints()), 0.0),
        residual_(make_residual(system)) {
    for (int i = 0; i < system.coordinates(); ++i) scale_.push_back(system.coordinate_scale(i));
    rest_ = force(start.t, zero_);
    const std::vector<double> ones(q_.size(), 1.0);
    mass_ = product(ones, times_mass(start.t, ones));
  }

  double of_velocities(double t, std::vector<double> v) const {
    for (std::size_t i = 0; i < v.size(); ++i) v[i] /= scale_[i];
    return root(product(v, times_mass(t, v)) / mass_);
  }

  /// Of forces as such, on all masses alike, and on those that they act on: a frame has none.
  double of_forces(double t) {
    rest_ = force(t, zero_);
    const double square = product(rest_, rest_), weighted = product(rest_, times_mass(t, rest_));
    return std::max(on_all_masses(), root(square / std::sqrt(weighted * mass_)));
  }
  double of_forces_on_all_masses(double t) {
    rest_ = force(t, zero_);
    return on_all_masses();
  }

  double of_motions(double t) const {
    evaluate(t, zero_);
    if (largest_size(residual_.velocity) == 0.0) return 0.0;
    const std::vector<double> size = constraint_sizes(system_, t, q_, scale_);
    double most = 0.0;
    for (std::size_t row = 0; row < size.size(); ++row)
      if (const double rate = std::abs(residual_.velocity[row]) / size[row]; std::isfinite(rate))
        most = std::max(most, rate);
    return most;
  }

 private:
  static double root(double square) {
    return square > 0.0 && std::isfinite(square) ? std::sqrt(square) : 0.0;
  }

  double on_all_masses() const {
    double sum = 0.0;
    for (const double f : rest_) sum += std::abs(f);
    return root(sum / mass_);
  }
  /// At rest, but with these accelerations.
  void evaluate(double t, const std::vector<double>& a) const {
    system_.evaluate({t, q_.data(), zero_.data(), a.data(), zero_.data()}, residual_);
  }
  /// F there, in the scales of the coordinates.
  std::vector<double> force(double t, const std::vector<double>& a) const {
    evaluate(t, a);
    std::vector<double> f = residual_.force;
    for (std::size_t i = 0; i < f.size(); ++i) f[i] *= scale_[i];
    return f;
  }
  std::vector<double> times_mass(double t, std::vector<double> x) const {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] *= scale_[i];
    std::vector<double> f = force(t, x);
    for (std::size_t i = 0; i < f.size(); ++i) f[i] -= rest_[i];
    return f;
  }

  const ConstrainedSystem& system_;
  const std::vector<double>& q_;
  std::vector<double> scale_;
  const std::vector<double> zero_;
  mutable Residual residual_;
  std::vector<double> rest_;  ///< F at rest, at the time looked at
  double mass_ = 0.0;         ///< of all coordinates
};

double rate_of(const ConstrainedSystem& system, const State& start, double t_end) {
  ModelRates rates(system, start);
  double most = rates.of_velocities(start.t, start.v);
  const auto look_at = [&](double t) {
    try {
      most = std::max({most, rates.of_forces(t), rates.of_motions(t)});
    } catch (const InvalidInput&) {  // the motion need not come by there
    }
  };
  look_at(start.t);
  for (int k = 0; k < kSamples && most < kSlowest; ++k)
    look_at(start.t + (k + kWithinPart) / kSamples * (t_end - start.t));
  for (const double mark : system.marks({start.t, t_end}))
    if (most < kSlowest && mark > start.t && mark < t_end) look_at(mark);
  return most;
}

double unit_for(double rate, double longest) {
  if (rate == 0.0 || (rate >= kSlowest && rate <= kFastest)) return 1.0;
  return std::exp2(std::round(std::log2(std::min(kMoved / rate, longest))));
}

}  // namespace

double time_unit(const ConstrainedSystem& system, const State& start, double t_end) {
  return unit_for(rate_of(system, start, t_end), kLongest * (t_end - start.t));
}

double time_unit_at_rest(const ConstrainedSystem& system, double t, const std::vector<double>& q) {
  const State there{t, q, {}, {}, {}};
  return unit_for(ModelRates(system, there).of_forces(t), HUGE_VAL);
}

double rate_at_rest(const ConstrainedSystem& system, double t, const std::vector<double>& q) {
  const State there{t, q, {}, {}, {}};
  return ModelRates(system, there).of_forces_on_all_masses(t);
}

}  // namespace mfs::dae
