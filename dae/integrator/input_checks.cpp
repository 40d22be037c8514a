#include "dae/integrator/input_checks.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "dae/integrator/bdf.hpp"
#include "dae/mechanics/number_text.hpp"

namespace mfs::dae {
namespace {

/// At 1e-13 steps stay near 1e-11 of the time to integrate.
constexpr double kLeastRtol = 1e-12;
/// Weeks of small mechanisms.
constexpr double kMostSteps = 1e10;

void check(bool good, const char* option, const std::string& what) {
  if (!good) throw InvalidInput(option, what);
}

}  // namespace

void check_options(const IntegratorOptions& o) {
  check(o.rtol >= 0.0 && o.rtol <= 1.0, "rtol", "must be 0 ... 1");
  check(o.rtol == 0.0 || o.rtol >= kLeastRtol || o.fixed_step > 0.0, "rtol",
        "must be zero or at least 1e-12: rounding is all that steps would see with less");
  for (const auto& [name, value] :
       {std::pair<const char*, double>{"atol_position", o.atol_position}, {"atol_velocity", o.atol_velocity}})
    check(value >= 0.0, name, "must be zero or positive");
  check(o.rtol > 0.0 || (o.atol_position > 0.0 && o.atol_velocity > 0.0), "rtol",
        "must be positive where atol_position or atol_velocity is not");
  check(o.constraint_position > 0.0, "constraint_position", "must be positive");
  check(o.constraint_velocity > 0.0, "constraint_velocity", "must be positive");
  check(o.constraint_acceleration > 0.0, "constraint_acceleration", "must be positive");
  check(o.max_order >= 1 && o.max_order <= Bdf::kMostOrder, "max_order", "must be 1 ... 5");
  for (const auto& [name, value] : {std::pair<const char*, double>{"initial_step", o.initial_step},
                                    {"max_step", o.max_step},
                                    {"min_step", o.min_step},
                                    {"fixed_step", o.fixed_step}})
    check(value >= 0.0 && std::isfinite(value), name, "must be zero or positive");
  check(o.max_step == 0.0 || o.min_step <= o.max_step, "min_step", "must not be more than max_step");
  check(o.rho_inf >= 0.0 && o.rho_inf <= 1.0, "rho_inf", "must be 0 ... 1");
  check(o.newton_iterations >= 1, "newton_iterations", "must be at least 1");
  check(o.krylov_steps >= 0, "krylov_steps", "must be zero or positive");
  check(o.threads >= 0, "threads", "must be zero or positive");
  check(o.analysis_threads >= 0, "analysis_threads", "must be zero or positive");
}

void check_step_number(const IntegratorOptions& o, double time) {
  for (const auto& [name, step] :
       {std::pair<const char*, double>{"max_step", o.max_step}, {"fixed_step", o.fixed_step}})
    check(step == 0.0 || time / step <= kMostSteps, name,
          "would make at least " + number_text(time / step) + " steps");
}

void check_vector(const std::vector<double>& values, int n, const char* name) {
  if (values.size() != static_cast<std::size_t>(n))
    throw InvalidInput(name,
                       std::to_string(values.size()) + " values for " + std::to_string(n) + " coordinates");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw InvalidInput(name, "not a finite number", static_cast<std::int64_t>(i));
}

void check_times(double t0, double t_end, const std::vector<double>& outputs) {
  check(std::isfinite(t0) && std::isfinite(t_end) && t_end > t0, "t_end", "must be finite and after t0");
  const auto refuse = [](double t, const char* why) {
    throw InvalidInput("outputs", "time " + number_text(t) + " " + why);
  };
  double last = -std::numeric_limits<double>::infinity();
  for (const double t : outputs) {
    if (!(t >= t0 && t <= t_end)) refuse(t, "is not within t0 ... t_end");
    if (!(t > last)) refuse(t, "does not come after the one before");
    last = t;
  }
}

}  // namespace mfs::dae
