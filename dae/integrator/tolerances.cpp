#include "dae/integrator/tolerances.hpp"

#include <algorithm>
#include <cmath>

namespace mfs::dae {
namespace {

/// The rtol below which errors fall as it does: the default, so that runs with it are as they are.
constexpr double kProportional = 1e-4;
/// Local errors are not made less than this by an rtol that is more, in parts of a value and of 1 m/s (in
/// parts of 100 m, of a position). With less four_bars_2 did not get past its singular positions, near which
/// rounding is a thousand times as large as elsewhere.
constexpr double kLeastRelative = 1e-10, kLeastAbsolute = 1e-9;
/// Positions, in m, beside velocities, in m/s.
constexpr double kOfPosition = 1e-2;
/// Steps after which a singular position is well behind. With 5 four_bars_40 got stuck at rtol 10^-8.4.
constexpr int kRelaxedSteps = 20;

/// Local errors by which a way is told from what is a hundredth of 1e-5 off.
constexpr double kSmall = 1e-8;

double proportional(const IntegratorOptions& options, double least) {
  const int order = options.method == Method::bdf ? options.max_order : 2;
  const double rtol = options.rtol;
  const double local = rtol * std::pow(std::min(1.0, rtol / kProportional), 1.0 / order);
  return std::max(local, std::min(rtol, least));
}

}  // namespace

void set_local_tolerances(IntegratorOptions& options) {
  double absolute = options.rtol;
  if (options.atol_position == 0.0 && options.atol_velocity == 0.0) {
    absolute = proportional(options, kLeastAbsolute);
    options.rtol = proportional(options, kLeastRelative);
  }
  if (options.atol_position == 0.0) options.atol_position = kOfPosition * absolute;
  if (options.atol_velocity == 0.0) options.atol_velocity = absolute;
}

LocalTolerances::LocalTolerances(const IntegratorOptions& asked, IntegratorOptions& used)
    : asked_(asked), used_(used) {
  tighten();
}

bool LocalTolerances::relax() {
  if (small_ || used_.rtol >= asked_.rtol) return false;
  used_.rtol = used_.atol_velocity = asked_.rtol;
  used_.atol_position = kOfPosition * asked_.rtol;
  relaxed_steps_ = kRelaxedSteps;
  return true;
}

void LocalTolerances::make_small() {
  small_ = used_.rtol > kSmall;
  used_.rtol = std::min(used_.rtol, kSmall);
  used_.atol_velocity = std::min(used_.atol_velocity, kSmall);
  used_.atol_position = std::min(used_.atol_position, kOfPosition * kSmall);
}

void LocalTolerances::tighten() {
  used_ = asked_;
  set_local_tolerances(used_);
}

}  // namespace mfs::dae
