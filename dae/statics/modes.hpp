// Small motions about a state: q + x exp(s t), with
//
//   (s^2 M + s D + K) x + Phi_q^T mu = 0,   Phi_q x = 0,        M = F_a, D = F_v, K = F_q
//
// where K holds what loads, springs and the multipliers' forces change with q. s = -damping + i frequency.
// D and K need not be symmetric, so that dampers, followers and controllers are in it as they are. Where the
// state moves D and K are those of turning_axes.hpp. Whether these are constant steady_motion.hpp tells; else
// modes are those of one moment.
//
// Constraints on velocities, A v = 0, ask for s A x + B x = 0 besides, B = d(A v)/dq, and have a part in F as
// those on positions have: what rolls in steady motion has modes as a rotor has (Neimark and Fufaev, Dynamics
// of Nonholonomic Systems, 1972).
//
// Systems of few degrees of freedom are reduced to them and solved whole, and each mode is made exact
// (polished_modes.hpp). For others Arnoldi's method
// (Spectra) finds the modes nearest to zero, of the operator that solves for the response of the state
// (x, s x) to a disturbance:
//
//   (K + c D + c^2 M) x + Phi_q^T mu = -M b - D a - c M a,  Phi_q x = 0,  y = a + c x;     1 / (s - c)
//
// are its eigenvalues. What has been found is taken out and the method begins anew until nothing new comes,
// so that modes of equal frequency, as those of a square beam, are all found. Those that are far slower than
// c are found again about their own rate (slow_modes.hpp).
#pragma once

#include <complex>
#include <functional>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "dae/statics/turning_axes.hpp"

namespace mfs::dae {

struct Mode {
  std::complex<double> s;               ///< 1/s
  std::vector<std::complex<double>> x;  ///< n; the largest in the scales of coordinates is 1
  /// Of s, in parts of it: what rounding of stiff parts may leave. About 1 and more where it may be free.
  double rounding = 0.0;
};

/// Whether D is in it.
enum class Damping { as_it_is, left_out };

/// The `count` modes (or all that there are) nearest to s = 0 about `state`, which has t, q, v, a and lambda.
/// Of two that are conjugate one is given, with a positive imaginary part; of two real ones of opposite sign
/// the positive one, which grows. `go_on` is asked again and again; false ends it with those found by then.
/// About a motion with constraints on velocities the system has to be one of few degrees of freedom. Throws
/// InvalidInput, with the constraint's name where the position is singular, mfs::Error where Arnoldi's method
/// does not converge, and what mfs::Solver throws.
std::vector<Mode> find_modes(const ConstrainedSystem& system, const State& state, int count, int threads,
                             Damping damping = Damping::as_it_is, const std::function<bool()>& go_on = {},
                             Backend backend = Backend::openmp);

/// The same in `axes`, of `system` and `state`.
std::vector<Mode> find_modes(const ConstrainedSystem& system, const State& state, const TurningAxes& axes,
                             int count, int threads, Damping damping, const std::function<bool()>& go_on,
                             Backend backend);

/// |s| / (2 pi), Hz.
double natural_frequency(const Mode& mode);
/// -Re s / |s|: 1 and more do not swing, below 0 it grows.
double damping_ratio(const Mode& mode);

}  // namespace mfs::dae
