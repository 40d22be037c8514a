#include "dae/integrator/jumps.hpp"

#include <cmath>
#include <vector>

#include <mfs/error.hpp>

#include "dae/integrator/initial_conditions.hpp"

namespace mfs::dae {
namespace {

/// What changes in a moment of some shortest steps by more than so many times what a step may leave of a
/// constraint jumps: smooth motions would have to be faster than any machine.
constexpr double kJump = 1e3;
/// What part of the largest force changes in such a moment only where one jumps or has a pole.
constexpr double kSudden = 0.1;

}  // namespace

std::string find_jump(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options) {
  const std::vector<double> no_multipliers(static_cast<std::size_t>(system.constraints()), 0.0);
  const std::vector<double> no_accelerations(state.a.size(), 0.0);  // leave F the forces alone
  StateView there{state.t, state.q.data(), state.v.data(), no_accelerations.data(), no_multipliers.data()};
  Residual before = make_residual(system), after = before;
  try {
    system.evaluate(there, before);
    there.t += moment;
    system.evaluate(there, after);
  } catch (const InvalidInput& e) {
    return e.what();
  }
  for (int row = 0; row < system.constraints(); ++row) {
    const auto same = [&](const std::vector<double>& now, const std::vector<double>& then, double bound) {
      return std::abs(then[row] - now[row]) <= kJump * bound;
    };
    if (!same(before.position, after.position, options.constraint_position) ||
        !same(before.velocity, after.velocity, options.constraint_velocity) ||
        !same(before.acceleration, after.acceleration, options.constraint_acceleration))
      return system.constraint_name(row) + " jumps";
  }
  // A force that is near zero changes by as large a part of itself, but accelerates nothing like that.
  if (largest_size(state.a) * moment <= kJump * options.constraint_velocity) return {};
  const double bound = kSudden * largest_size(before.force);
  for (int i = 0; i < system.coordinates(); ++i)
    if (std::abs(after.force[i] - before.force[i]) > bound)
      return "the force on " + system.coordinate_name(i) + " jumps or has a pole";
  return {};
}

}  // namespace mfs::dae
