#include "dae/statics/steady_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "dae/integrator/scaled_system.hpp"
#include "dae/statics/block_vectors.hpp"

namespace mfs::dae {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::Matrix4d;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// How far what turns fastest turns until it is looked at again, rad.
constexpr double kLook = 0.2;
/// How many times as long a precession is followed for as much, at most.
constexpr double kMostTurns = 1000.0;
/// Changes of matrices that steps of a motion by kMotionRtol leave, in parts of what they are.
constexpr double kUnchanged = 1e-3;
/// The same of constraints, while something has turned some hundred times as far as it is looked at.
constexpr double kHeld = 5e-3;
/// A change of the turn of all, in parts of its square, that may be a slow precession: other axes are tried.
constexpr double kTurnsAbout = 1e-5;
/// Slower than that part of what turns fastest are free motions alone. Steps leave some stiffness of them, in
/// parts of the square of that.
constexpr double kFree = 1e-3, kLeftOfFree = 0.1;
/// Of modes without stiffness s is rounding: in parts of the largest s^2.
constexpr double kRounding = 1e-9;

/// What modes see in a state: T y of each, and its image under M, D, K and Phi_q, or s A + B.
struct Seen {
  MatrixXcd y;
  std::array<MatrixXcd, 3> image;
  MatrixXcd violation;
  MatrixXd terms;  ///< sums of what each violation is made of, without signs
};

VectorXcd complex_product(const Pattern& pattern, const std::vector<double>& values, const VectorXcd& x) {
  VectorXcd image(pattern.rows);
  image.real() = product(pattern, values, x.real());
  image.imag() = product(pattern, values, x.imag());
  return image;
}

/// In `state`, which `axes` come to in `time`.
Seen look(const ConstrainedSystem& system, const TurningAxes& axes, const State& state, double time,
          const std::vector<Mode>& modes, Damping damping) {
  const TurnedSystem turned(system, axes);
  Tangent tangent = make_tangent(turned);
  turned.evaluate({state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()}, tangent,
                  {Block::force_a, Block::force_v, Block::force_q, Block::position_q, Block::velocity_q});
  if (damping == Damping::left_out)
    std::fill(tangent[Block::force_v].begin(), tangent[Block::force_v].end(), 0.0);
  const auto count = static_cast<Index>(modes.size()), n = static_cast<Index>(system.coordinates());
  Seen seen;
  seen.y.resize(n, count);
  for (Index k = 0; k < count; ++k)
    seen.y.col(k) = Eigen::Map<const VectorXcd>(modes[static_cast<std::size_t>(k)].x.data(), n);
  for (const TurningAxes::Part& part : axes.parts()) {
    const Matrix4d turn = Matrix4d(part.w * time).exp();
    const MatrixXcd before = seen.y.middleRows(part.first, part.size);
    seen.y.middleRows(part.first, part.size) = turn.topLeftCorner(part.size, part.size) * before;
  }
  const auto image = [&](Block block, const MatrixXcd& y) {
    const Pattern& pattern = turned.tangent_pattern()[block];
    MatrixXcd images(pattern.rows, count);
    for (Index k = 0; k < count; ++k) images.col(k) = complex_product(pattern, tangent[block], y.col(k));
    return images;
  };
  for (std::size_t b = 0; b < kForceByAVQ.size(); ++b) seen.image[b] = image(kForceByAVQ[b], seen.y);
  VectorXcd s(count);
  for (Index k = 0; k < count; ++k) s[k] = modes[static_cast<std::size_t>(k)].s;
  const auto violation = [&](const MatrixXcd& y, const VectorXcd& rates) {
    MatrixXcd sum = image(Block::position_q, y);
    const MatrixXcd change = image(Block::velocity_q, y);
    for (int row = 0; row < system.constraints(); ++row)
      if (system.is_nonholonomic(row)) sum.row(row) = sum.row(row) * rates.asDiagonal() + change.row(row);
    return sum;
  };
  seen.violation = violation(seen.y, s);
  for (const Block block : {Block::position_q, Block::velocity_q})
    for (double& value : tangent[block]) value = std::abs(value);
  seen.terms = violation(seen.y.cwiseAbs().cast<Complex>(), s.cwiseAbs().cast<Complex>()).real();
  return seen;
}

/// y_j^T (M, D, K) y_k.
std::array<MatrixXcd, 3> reduced(const Seen& seen) {
  std::array<MatrixXcd, 3> matrices;
  for (std::size_t b = 0; b < matrices.size(); ++b) matrices[b] = seen.y.adjoint() * seen.image[b];
  return matrices;
}

/// Whether the matrices are the same in both states for all modes. Of those of modes j and k as much may have
/// changed as is nothing beside the forces that make them. `turns`: how fast anything turns; `rate`: the
/// axes.
bool are_same(const Seen& now, const Seen& then, const std::vector<Mode>& modes, double turns, double rate) {
  const auto largest = [](const MatrixXd& of) { return of.size() == 0 ? 0.0 : of.maxCoeff(); };
  const MatrixXd terms = then.terms.array() + kUnchanged * largest(then.terms);
  if (((then.violation - now.violation).cwiseAbs().array() > kHeld * terms.array()).any()) return false;
  const std::array<MatrixXcd, 3> before = reduced(now), after = reduced(then);
  const VectorXd mass = before[0].diagonal().cwiseAbs(), stiffness = before[2].diagonal().cwiseAbs();
  double rounding = 0.0;
  for (const Mode& mode : modes) rounding = std::max(rounding, kRounding * std::norm(mode.s));
  for (Index k = 0; k < mass.size(); ++k) {
    const Complex s = modes[static_cast<std::size_t>(k)].s;
    const double least =
        std::max(rounding, std::abs(s) > kFree * turns ? rate * rate : kLeftOfFree * turns * turns);
    for (Index j = 0; j < mass.size(); ++j) {
      const auto sum = [&](const std::array<MatrixXcd, 3>& of) {
        return s * s * of[0](j, k) + s * of[1](j, k) + of[2](j, k);
      };
      const double forces = (std::norm(s) + least) * std::sqrt(mass[j] * mass[k]) +
                            std::abs(s * before[1](j, k)) + std::sqrt(stiffness[j] * stiffness[k]);
      if (std::abs(sum(after) - sum(before)) > kUnchanged * forces) return false;
    }
  }
  return true;
}

bool is_steady(const ConstrainedSystem& system, const TurningAxes& axes, const State& state,
               const State& later, const std::vector<Mode>& modes, Damping damping) {
  if (modes.empty()) return true;
  return are_same(look(system, axes, state, 0.0, modes, damping),
                  look(system, axes, later, later.t - state.t, modes, damping), modes,
                  TurningAxes::fastest(system, state), axes.rate());
}

}  // namespace

ModesInMotion find_modes_in_motion(const ConstrainedSystem& system, const State& state, const Later& later,
                                   int count, int threads, Damping damping,
                                   const std::function<bool()>& go_on, Backend backend) {
  const double fastest = TurningAxes::fastest(system, state);
  const State soon = fastest > 0.0 ? later(state.t + kLook / fastest) : state;
  const auto with = [&](const TurningAxes& axes, const State& then) {
    ModesInMotion found{find_modes(system, state, axes, count, threads, damping, go_on, backend), axes,
                        false};
    found.steady = is_steady(system, axes, state, then, found.modes, damping);
    return found;
  };
  ModesInMotion first = with(TurningAxes(system, state), soon);
  if (first.steady && (!first.axes.turn_along() || first.axes.change() <= kTurnsAbout)) return first;
  if (first.axes.turn_along())
    if (ModesInMotion found = with(TurningAxes::of_ground(system, state), soon); found.steady) return found;
  // What precesses slowly beside its spin has to be followed for longer.
  const double rate = TurningAxes::precessing(system, state, soon).rate();
  const State then = later(state.t + kLook / std::clamp(rate, fastest / kMostTurns, fastest));
  if (ModesInMotion found = with(TurningAxes::precessing(system, state, then), then); found.steady)
    return found;
  first.steady = first.steady && first.axes.steady();
  return first;
}

}  // namespace mfs::dae
