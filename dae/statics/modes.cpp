#include "dae/statics/modes.hpp"

#include <Spectra/GenEigsSolver.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <mfs/error.hpp>

#include "dae/integrator/scaled_system.hpp"
#include "dae/statics/block_vectors.hpp"
#include "dae/statics/constrained_matrix.hpp"
#include "dae/statics/independent_system.hpp"

namespace mfs::dae {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Degrees of freedom and coordinates up to which the system is reduced to them.
constexpr int kDenseFreedoms = 150, kDenseCoordinates = 600;
/// An eigenvalue of the operator that is smaller than this part of the largest is that of a motion without
/// inertia.
constexpr double kWithoutInertia = 1e-10;
/// c, in typical frequencies of the system: so small that modes are in the order of their distance from zero,
/// so large that a free motion does not make the matrix singular.
constexpr double kShift = 1e-4;
/// c of the reduced system, in the same: that one whose response times c is least, and less than the last. It
/// is the first where no motion is free, and then modes are exact that are far slower than the typical ones.
/// Free motions, which go on and on, and in turning axes faster and faster, are all that counts beside it,
/// and a growing motion may have one of the others.
constexpr double kShiftsOfReduced[] = {kShift, 0.37, 0.61, 0.97}, kMostResponse = 1e12;
/// Of the eigenpairs of the operator: asked for, and in the end.
constexpr double kTolerance = 1e-11, kAccepted = 1e-6;
constexpr int kMostRestarts = 100, kMostRounds = 50;
/// Of B, 1/s: less is at rest.
constexpr double kAtRest = 1e-9;
/// Of the largest stiffness.
constexpr double kRounding = 1e-14;
/// Powers of the response to inertia that are taken to tell the rate of the slowest modes.
constexpr int kLooksAtRate = 3;

/// M, D and K in a state, Phi_q, and what constraints on velocities, s A x + B x = 0, have of positions.
class Matrices {
 public:
  Matrices(const ConstrainedSystem& system, const State& state, Damping damping)
      : pattern_(system.tangent_pattern()), tangent_(make_tangent(system)) {
    system.evaluate(StateView{state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()},
                    tangent_,
                    {Block::force_a, Block::force_v, Block::force_q, Block::position_q, Block::velocity_q});
    if (damping == Damping::left_out)
      std::fill(tangent_[Block::force_v].begin(), tangent_[Block::force_v].end(), 0.0);
    for (int j = 0; j < system.constraints(); ++j)
      (system.is_nonholonomic(j) ? rolling_ : held_).push_back(j);
  }
  /// Of constraints on velocities: the first that has B; -1: none, so that A x = 0 is all that they ask for.
  int first_moving() const {
    const Pattern& p = pattern_[Block::velocity_q];
    for (const int j : rolling_)
      for (int k = p.row_start[j]; k < p.row_start[j + 1]; ++k)
        if (std::abs(tangent_[Block::velocity_q][k]) > kAtRest) return j;
    return -1;
  }
  /// A and B.
  std::pair<MatrixXd, MatrixXd> rolling() const {
    return {dense(Block::position_q, rolling_), dense(Block::velocity_q, rolling_)};
  }
  /// Phi_q of the others.
  MatrixXd held() const { return dense(Block::position_q, held_); }
  const Tangent& tangent() const { return tangent_; }
  VectorXd times(Block block, const VectorXd& x) const {
    return product(pattern_[block], tangent_[block], x);
  }
  MatrixXd dense(Block block) const {
    const Pattern& p = pattern_[block];
    MatrixXd matrix = MatrixXd::Zero(p.rows, p.columns);
    for (int i = 0; i < p.rows; ++i)
      for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k) matrix(i, p.column[k]) = tangent_[block][k];
    return matrix;
  }
  double shift() const { return kShift * typical_frequency(); }
  /// 1/s: the median over coordinates that have both a mass and a stiffness that is no rounding, as the
  /// stiffest and the heaviest have it where no coordinate has both; 1 where nothing is stiff.
  double typical_frequency() const {
    const VectorXd m = diagonal(Block::force_a), k = diagonal(Block::force_q);
    const double least = m.size() > 0 ? kRounding * k.maxCoeff() : 0.0;
    std::vector<double> all;
    for (Index i = 0; i < m.size(); ++i)
      if (m[i] > 0 && k[i] > least) all.push_back(std::sqrt(k[i] / m[i]));
    if (all.empty()) {
      const double stiffest = k.maxCoeff(), heaviest = m.maxCoeff();
      return stiffest > 0 && heaviest > 0 ? std::sqrt(stiffest / heaviest) : 1.0;
    }
    return median(std::move(all));
  }

 private:
  VectorXd diagonal(Block block) const { return diagonal_sizes(pattern_[block], tangent_[block]); }
  MatrixXd dense(Block block, const std::vector<int>& rows) const {
    const MatrixXd whole = dense(block);
    MatrixXd part(static_cast<Index>(rows.size()), whole.cols());
    for (std::size_t i = 0; i < rows.size(); ++i) part.row(static_cast<Index>(i)) = whole.row(rows[i]);
    return part;
  }

  const TangentPattern& pattern_;
  Tangent tangent_;
  std::vector<int> held_, rolling_;  // rows of constraints on positions, on velocities alone
};

/// Eigenvalues 1 / (s - c) and, as columns, the x of their vectors.
struct Eigenpairs {
  VectorXcd theta;
  MatrixXcd x;
  double c = 0.0;
};

/// The rate of the slowest modes, 1/s, by which s x is divided beside x: without it one of the two is next to
/// nothing where time is in hours or microseconds. `square`: of 1 / rate.
double rate_of_slowest(double square) {
  return square > 0 && std::isfinite(square) ? 1 / std::sqrt(square) : 1.0;
}

/// As columns, an orthonormal basis of what independent rows leave free.
MatrixXd free_of(const MatrixXd& rows) {
  if (rows.rows() == 0) return MatrixXd::Identity(rows.cols(), rows.cols());
  const Eigen::HouseholderQR<MatrixXd> qr(rows.transpose());
  return MatrixXd(qr.householderQ()).rightCols(rows.cols() - rows.rows());
}

/// What `response_to(c)`, empty where that has none, is for the c that suits it, and that c.
template <class ResponseTo>
std::pair<MatrixXd, double> best_response(const Matrices& matrices, const ResponseTo& response_to) {
  std::pair<MatrixXd, double> best;
  double least = kMostResponse;
  const double typical = matrices.typical_frequency();
  for (const double part : kShiftsOfReduced) {
    const double c = part * typical;
    MatrixXd response = response_to(c);
    if (response.size() == 0 || !(response.norm() * c < least)) continue;
    least = response.norm() * c;
    best = {std::move(response), c};
  }
  if (best.first.size() == 0) throw Error("modes: a motion has neither stiffness nor inertia");
  return best;
}

Eigenpairs eigenpairs_of(const MatrixXd& response, const MatrixXd& basis, double c) {
  const Eigen::EigenSolver<MatrixXd> solver(response);
  if (solver.info() != Eigen::Success)
    throw Error("modes: the eigenvalues of the reduced system are not found");
  return {solver.eigenvalues(), basis * solver.eigenvectors().topRows(basis.cols()), c};
}

/// All of them: with x = N y, the columns of N a basis of what the constraints leave free.
Eigenpairs solve_reduced(const Matrices& matrices) {
  const MatrixXd basis = free_of(matrices.dense(Block::position_q));
  const auto reduced = [&](Block block) -> MatrixXd {
    return basis.transpose() * matrices.dense(block) * basis;
  };
  const MatrixXd mass = reduced(Block::force_a), damping = reduced(Block::force_v),
                 stiffness = reduced(Block::force_q);
  const Index f = basis.cols();
  const auto [response, c] = best_response(matrices, [&](double shift) {
    const Eigen::FullPivLU<MatrixXd> lu(stiffness + shift * damping + shift * shift * mass);
    if (!lu.isInvertible()) return MatrixXd();
    const MatrixXd by_inertia = lu.solve(mass);
    const double rate = rate_of_slowest(by_inertia.norm());
    MatrixXd answer(2 * f, 2 * f);
    answer.topLeftCorner(f, f) = -lu.solve(damping + shift * mass);
    answer.topRightCorner(f, f) = -rate * by_inertia;
    answer.bottomRows(f) = shift / rate * answer.topRows(f);
    answer.bottomLeftCorner(f, f) += MatrixXd::Identity(f, f) / rate;
    return answer;
  });
  return eigenpairs_of(response, basis, c);
}

/// All of them where something rolls: x = N y by the constraints on positions, and y' = G y + Z w by those on
/// velocities, A N y' + B N y = 0, so that w alone has inertia:
///
///   s y = G y + Z w,   s Z^T M Z w = -Z^T ((M G + D) (G y + Z w) + K y)
///
/// c is a rate of the motion and not next to zero: what rolls is free to be elsewhere, to go elsewhere and to
/// do so faster and faster, three and more motions of s = 0 that beside it would be all that counts.
Eigenpairs solve_rolling(const Matrices& matrices) {
  const MatrixXd basis = free_of(matrices.held());
  const auto [rows, change] = matrices.rolling();
  const MatrixXd by_rates = rows * basis, by_places = change * basis;
  const MatrixXd z = free_of(by_rates);
  const MatrixXd g = -by_rates.transpose() * (by_rates * by_rates.transpose()).ldlt().solve(by_places);
  const auto reduced = [&](Block block) -> MatrixXd {
    return z.transpose() * (basis.transpose() * matrices.dense(block) * basis);
  };
  const MatrixXd mass = reduced(Block::force_a), damping = mass * g + reduced(Block::force_v),
                 stiffness = damping * g + reduced(Block::force_q);
  // Of w beside y, so that neither is next to nothing.
  const Index f = z.rows(), r = z.cols();
  const double heaviest = mass.norm(), stiffest = stiffness.norm();
  const double rate = heaviest > 0 && stiffest > 0 ? std::sqrt(stiffest / heaviest) : 1.0;
  const double force = heaviest > 0 ? rate * rate * heaviest : 1.0;
  MatrixXd left = MatrixXd::Zero(f + r, f + r), right(f + r, f + r);
  left.topLeftCorner(f, f) = MatrixXd::Identity(f, f) / rate;
  left.bottomRightCorner(r, r) = rate / force * mass * z;
  right << g / rate, z, -stiffness / force, -rate / force * damping * z;
  const auto [response, c] = best_response(matrices, [&](double shift) {
    const Eigen::FullPivLU<MatrixXd> lu(right - shift * left);
    return lu.isInvertible() ? MatrixXd(lu.solve(left)) : MatrixXd();
  });
  return eigenpairs_of(response, basis, c);
}

/// The operator, on vectors (a, b / rate), less what lies in the space of those found.
class Response {
 public:
  using Scalar = double;

  struct Stopped {};

  Response(const ConstrainedSystem& system, const Matrices& matrices, double c, int threads, Backend backend,
           std::function<bool()> go_on)
      : n_(system.coordinates()),
        m_(system.constraints()),
        c_(c),
        matrices_(matrices),
        go_on_(std::move(go_on)),
        matrix_(system, threads, backend) {
    matrix_.factor(matrices.tangent(), {c * c, c, 1.0});
    // Of what constraints and inertia leave of any motion.
    VectorXd x = by_inertia(irregular(n_, 1));
    for (int i = 0; i < kLooksAtRate && x.norm() > 0; ++i) {
      const VectorXd next = by_inertia(x.normalized());
      rate_ = rate_of_slowest(next.norm());
      x = next;
    }
  }

  Index rows() const { return 2 * n_; }
  Index cols() const { return 2 * n_; }
  /// Throws Stopped.
  void perform_op(const double* in, double* out) const {
    if (go_on_ && !go_on_()) throw Stopped();
    const VectorXd z = Eigen::Map<const VectorXd>(in, 2 * n_);
    Eigen::Map<VectorXd>(out, 2 * n_) = rest(apply(rest(z)));
  }
  VectorXd apply(const VectorXd& z) const {
    const VectorXd a = z.head(n_), b = rate_ * z.tail(n_);
    VectorXd answer(2 * n_);
    answer.head(n_) =
        -moved_by(matrices_.times(Block::force_a, b + c_ * a) + matrices_.times(Block::force_v, a));
    answer.tail(n_) = (a + c_ * answer.head(n_)) / rate_;
    return answer;
  }

  /// An orthonormal basis of the space of the vectors found.
  const MatrixXd& found() const { return found_; }
  void add(const VectorXd& vector) {
    const double size = vector.norm();
    VectorXd part = rest(rest(vector));
    if (!(part.norm() > 1e-7 * size)) return;
    part = rest(part.normalized()).normalized();
    found_.conservativeResize(2 * n_, found_.cols() + 1);
    found_.rightCols(1) = part;
  }

 private:
  /// x of a force.
  VectorXd moved_by(const VectorXd& force) const {
    std::vector<double> right_side(static_cast<std::size_t>(n_ + m_), 0.0);
    std::copy(force.begin(), force.end(), right_side.begin());
    const std::vector<double> solution = matrix_.solve(std::move(right_side));
    return Eigen::Map<const VectorXd>(solution.data(), n_);
  }
  VectorXd by_inertia(const VectorXd& x) const { return moved_by(matrices_.times(Block::force_a, x)); }
  VectorXd rest(const VectorXd& z) const {
    return found_.cols() == 0 ? z : VectorXd(z - found_ * (found_.transpose() * z));
  }

  const Index n_, m_;
  const double c_;
  double rate_ = 1.0;
  const Matrices& matrices_;
  const std::function<bool()> go_on_;
  mutable ConstrainedMatrix matrix_;
  MatrixXd found_;
};

/// Adds vectors to those found, as long as there are any whose eigenvalues are among the `wanted` largest.
void find_vectors(Response& response, Index wanted) {
  std::vector<double> sizes;  // of all eigenvalues found
  for (int round = 0; round < kMostRounds; ++round) {
    const Index size = response.rows();
    const Index count = std::min(round == 0 ? wanted : Index{4}, size - 2);
    const Index steps = std::min(size, std::max<Index>(2 * count + 20, 40));
    Spectra::GenEigsSolver<Response> solver(response, count, steps);
    // From a motion that constraints allow.
    const VectorXd start = irregular(size, round + 1);
    VectorXd begun(size);
    response.perform_op(start.data(), begun.data());
    solver.init(begun.data());
    solver.compute(Spectra::SortRule::LargestMagn, kMostRestarts, kTolerance);
    if (solver.info() != Spectra::CompInfo::Successful)
      throw Error("modes: " + std::to_string(solver.eigenvalues().size()) + " of " + std::to_string(count) +
                  " eigenvalues have converged in " + std::to_string(kMostRestarts) +
                  " restarts; with strong damping, or near -1 / beta, they lie close together: ask for fewer "
                  "modes or leave the damping out");
    const VectorXcd theta = solver.eigenvalues();
    const MatrixXcd vectors = solver.eigenvectors();
    std::sort(sizes.begin(), sizes.end(), std::greater<>());
    const double least = static_cast<Index>(sizes.size()) < wanted ? 0.0 : sizes[wanted - 1];
    if (!(theta.cwiseAbs().maxCoeff() > (1 + 1e-6) * least)) return;
    for (Index i = 0; i < theta.size(); ++i) {
      sizes.push_back(std::abs(theta[i]));
      response.add(vectors.col(i).real());
      response.add(vectors.col(i).imag());
    }
  }
  throw Error("modes: more of them have the same frequency than can be found");
}

Eigenpairs solve_large(const ConstrainedSystem& system, const Matrices& matrices, double c, int count,
                       int threads, Backend backend, const std::function<bool()>& go_on) {
  Response response(system, matrices, c, threads, backend, go_on);
  try {
    find_vectors(response, 2 * Index{count} + 2);
  } catch (const Response::Stopped&) {
    if (response.found().cols() == 0) return {};
  }
  const MatrixXd& basis = response.found();
  MatrixXd image(basis.rows(), basis.cols());
  for (Index i = 0; i < basis.cols(); ++i) image.col(i) = response.apply(basis.col(i));
  const Eigen::EigenSolver<MatrixXd> solver(basis.transpose() * image);
  const MatrixXcd y = solver.eigenvectors();
  const MatrixXcd error = image * y - basis * y * solver.eigenvalues().asDiagonal();
  for (Index i = 0; i < error.cols(); ++i)
    if (!(error.col(i).norm() <= kAccepted * std::abs(solver.eigenvalues()[i]) * y.col(i).norm()))
      throw Error("modes: the eigenvalues that have been found are not accurate");
  return {solver.eigenvalues(), (basis * y).topRows(system.coordinates()), c};
}

/// One of conjugate modes, the growing one of two real ones of opposite sign, nearest to zero first.
std::vector<Mode> modes_of(const ConstrainedSystem& system, const Eigenpairs& pairs) {
  std::vector<Mode> modes;
  const double largest = pairs.theta.size() > 0 ? pairs.theta.cwiseAbs().maxCoeff() : 0.0;
  for (Index i = 0; i < pairs.theta.size(); ++i) {
    if (!(std::abs(pairs.theta[i]) > kWithoutInertia * largest) || pairs.theta[i].imag() > 0) continue;
    const Complex inverse = 1.0 / pairs.theta[i];
    Mode mode{{pairs.c + inverse.real(), std::abs(inverse.imag())}, {}};  // no negative zero
    Complex most = 0.0;
    for (Index k = 0; k < pairs.x.rows(); ++k) {
      mode.x.push_back(pairs.x(k, i) / system.coordinate_scale(static_cast<int>(k)));
      if (std::abs(mode.x.back()) > (1 + 1e-9) * std::abs(most)) most = mode.x.back();
    }
    for (Index k = 0; k < pairs.x.rows(); ++k) mode.x[k] = pairs.x(k, i) / most;
    modes.push_back(std::move(mode));
  }
  const auto is_partner = [&](const Mode& mode) {
    return mode.s.imag() == 0 && mode.s.real() < 0 &&
           std::any_of(modes.begin(), modes.end(), [&](const Mode& other) {
             return other.s.imag() == 0 && other.s.real() > 0 &&
                    std::abs(other.s + mode.s) < 1e-3 * std::abs(mode.s);
           });
  };
  std::vector<Mode> kept;
  std::copy_if(modes.begin(), modes.end(), std::back_inserter(kept),
               [&](const Mode& mode) { return !is_partner(mode); });
  std::sort(kept.begin(), kept.end(),
            [](const Mode& x, const Mode& y) { return std::abs(x.s) < std::abs(y.s); });
  return kept;
}

/// Of the system, by the way that suits its size.
Eigenpairs solve(const ConstrainedSystem& system, const Matrices& matrices, int count, int threads,
                 Backend backend, const std::function<bool()>& go_on) {
  const int n = system.coordinates(), m = system.constraints(), moving = matrices.first_moving();
  if (n - m <= kDenseFreedoms && n <= kDenseCoordinates)
    return moving < 0 ? solve_reduced(matrices) : solve_rolling(matrices);
  if (moving >= 0)
    throw InvalidInput(system.constraint_name(moving),
                       "modes about a motion in which it rolls are found for mechanisms of up to " +
                           std::to_string(kDenseFreedoms) + " degrees of freedom and " +
                           std::to_string(kDenseCoordinates) + " coordinates, not " + std::to_string(n - m) +
                           " and " + std::to_string(n));
  return solve_large(system, matrices, matrices.shift(), count, threads, backend, go_on);
}

/// What is less of a mode, in parts of it, than what moves with another phase is rounding, which leads along
/// no constraint.
constexpr double kPhase = 1e-6;

/// A singular position has several ways out of it, whose frequencies hinge on multipliers that nothing
/// determines there.
void check_regular(const IndependentSystem& independent, const ConstrainedSystem& system, const State& state,
                   const std::vector<Mode>& modes) {
  if (!independent.filters()) return;
  for (const Mode& mode : modes) {
    const Eigen::Map<const Eigen::VectorXcd> x(mode.x.data(), static_cast<Eigen::Index>(mode.x.size()));
    for (const Eigen::VectorXd& part : {Eigen::VectorXd(x.real()), Eigen::VectorXd(x.imag())}) {
      if (!(part.lpNorm<Eigen::Infinity>() > kPhase * x.lpNorm<Eigen::Infinity>())) continue;
      const std::vector<double> way(part.data(), part.data() + part.size());
      if (const auto row = independent.singular_row(state.t, state.q, way))
        throw InvalidInput(system.constraint_name(*row),
                           "about this position there are no modes: it is singular, as here this constraint "
                           "follows from others, and beside it it does not");
    }
  }
}

}  // namespace

std::vector<Mode> find_modes(const ConstrainedSystem& system, const State& state, int count, int threads,
                             Damping damping, const std::function<bool()>& go_on, Backend backend) {
  return find_modes(system, state, TurningAxes(system, state), count, threads, damping, go_on, backend);
}

std::vector<Mode> find_modes(const ConstrainedSystem& system, const State& state, const TurningAxes& axes,
                             int count, int threads, Damping damping, const std::function<bool()>& go_on,
                             Backend backend) {
  if (count < 1) throw InvalidInput("modes", "their number is not positive");
  if (ScaledSystem::is_needed(system)) {
    const ScaledSystem scaled(system, state.t, state.q);
    std::vector<Mode> modes =
        find_modes(scaled, scaled.scaled(state), axes, count, threads, damping, go_on, backend);
    for (Mode& mode : modes)
      for (std::size_t i = 0; i < mode.x.size(); ++i)
        mode.x[i] *= system.coordinate_scale(static_cast<int>(i));
    return modes;
  }
  const IndependentSystem independent(system, state.t, state.q);
  const ConstrainedSystem& own = independent.system();
  if (own.coordinates() == own.constraints()) return {};
  State at = state;
  at.lambda = independent.kept_multipliers(state.lambda);
  std::optional<TurnedSystem> turned;
  if (axes.moves()) turned.emplace(own, axes);
  const ConstrainedSystem& seen = turned ? *turned : own;
  const Matrices matrices(seen, at, damping);
  std::vector<Mode> modes = modes_of(own, solve(seen, matrices, count, threads, backend, go_on));
  if (static_cast<int>(modes.size()) > count) modes.resize(static_cast<std::size_t>(count));
  check_regular(independent, system, state, modes);
  return modes;
}

double natural_frequency(const Mode& mode) {
  return std::abs(mode.s) / (2 * std::acos(-1.0));
}

double damping_ratio(const Mode& mode) {
  return mode.s == 0.0 ? 0.0 : -mode.s.real() / std::abs(mode.s);
}

}  // namespace mfs::dae
