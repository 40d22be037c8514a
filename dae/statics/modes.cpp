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
#include "dae/statics/motion_matrices.hpp"
#include "dae/statics/polished_modes.hpp"
#include "dae/statics/slow_modes.hpp"

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
/// c of the reduced system, in the same: that one whose response times c is least, and less than the last.
/// Free motions, which go on and on, and in turning axes faster and faster, are all that counts beside the
/// first, and a growing motion may have one of the others.
const std::vector<double> kShiftsOfReduced{kShift, 0.37, 0.61, 0.97};
constexpr double kMostResponse = 1e12;
/// c for the slow ones, in parts of their rate.
const std::vector<double> kShiftsOfSlow{0.37, 0.61, 0.97};
/// Of the eigenpairs of the operator: asked for, and in the end.
constexpr double kTolerance = 1e-11, kAccepted = 1e-6;
constexpr int kMostRestarts = 100, kMostRounds = 50;
/// Of the iteration that finds slow modes about their own rate.
constexpr int kStepsOfSlow = 12;
/// Powers of the response to inertia that are taken to tell the rate of the slowest modes.
constexpr int kLooksAtRate = 3;

/// Of eigenvalues 1 / (s - c) and vectors x, those that have inertia.
Eigenpairs with_inertia(const VectorXcd& theta, const MatrixXcd& x, double c) {
  const double largest = theta.size() > 0 ? theta.cwiseAbs().maxCoeff() : 0.0;
  std::vector<Index> kept;
  for (Index i = 0; i < theta.size(); ++i)
    if (std::abs(theta[i]) > kWithoutInertia * largest) kept.push_back(i);
  const auto count = static_cast<Index>(kept.size());
  Eigenpairs pairs{VectorXcd(count), MatrixXcd(x.rows(), count)};
  for (Index k = 0; k < count; ++k) {
    pairs.s[k] = c + 1.0 / theta[kept[static_cast<std::size_t>(k)]];
    pairs.x.col(k) = x.col(kept[static_cast<std::size_t>(k)]);
  }
  return pairs;
}

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

/// What `response_to(c)`, empty where that has none, is for the c that suits it of these parts of `rate`, and
/// that c.
template <class ResponseTo>
std::pair<MatrixXd, double> best_response(double rate, const std::vector<double>& parts,
                                          const ResponseTo& response_to) {
  std::pair<MatrixXd, double> best;
  double least = kMostResponse;
  for (const double part : parts) {
    const double c = part * rate;
    MatrixXd response = response_to(c);
    if (response.size() == 0 || !(response.norm() * c < least)) continue;
    least = response.norm() * c;
    best = {std::move(response), c};
  }
  return best;
}

void check_found(const MatrixXd& response) {
  if (response.size() == 0) throw Error("modes: a motion has neither stiffness nor inertia");
}

Eigenpairs eigenpairs_of(const MatrixXd& response, const MatrixXd& basis, double c) {
  const Eigen::EigenSolver<MatrixXd> solver(response);
  if (solver.info() != Eigen::Success)
    throw Error("modes: the eigenvalues of the reduced system are not found");
  return with_inertia(solver.eigenvalues(), basis * solver.eigenvectors().topRows(basis.cols()), c);
}

/// As columns, a basis of what independent rows leave free: each moves one of the coordinates that they leave
/// open, and those that have to move with it. So what is light, or soft, has columns of its own, in which
/// nothing heavy or stiff leaves a rounding.
MatrixXd partition_of(const MatrixXd& rows) {
  const Index m = rows.rows(), f = rows.cols() - m;
  if (m == 0) return MatrixXd::Identity(f, f);
  const Eigen::FullPivLU<MatrixXd> lu(rows);
  MatrixXd basis(m + f, f);
  basis.topRows(m) =
      -lu.matrixLU().leftCols(m).triangularView<Eigen::Upper>().solve(lu.matrixLU().rightCols(f));
  basis.bottomRows(f).setIdentity();
  return lu.permutationQ() * basis;
}

ReducedMotion reduce(const MotionMatrices& matrices) {
  const MatrixXd basis = partition_of(matrices.dense(Block::position_q));
  const auto reduced = [&](Block block) -> MatrixXd {
    return basis.transpose() * matrices.dense(block) * basis;
  };
  return {basis, reduced(Block::force_a), reduced(Block::force_v), reduced(Block::force_q)};
}

/// The operator about c, empty where that is one of its rates.
MatrixXd response_of(const ReducedMotion& reduced, double c) {
  const auto& [basis, mass, damping, stiffness] = reduced;
  const Index f = basis.cols();
  const Eigen::FullPivLU<MatrixXd> lu(stiffness + c * damping + c * c * mass);
  if (!lu.isInvertible()) return {};
  const MatrixXd by_inertia = lu.solve(mass);
  const double rate = rate_of_slowest(by_inertia.norm());
  MatrixXd answer(2 * f, 2 * f);
  answer.topLeftCorner(f, f) = -lu.solve(damping + c * mass);
  answer.topRightCorner(f, f) = -rate * by_inertia;
  answer.bottomRows(f) = c / rate * answer.topRows(f);
  answer.bottomLeftCorner(f, f) += MatrixXd::Identity(f, f) / rate;
  return answer;
}

/// All of them: with x = N y, the columns of N a basis of what the constraints leave free. `count` of them
/// are made exact.
Eigenpairs solve_reduced(const MotionMatrices& matrices, int count) {
  const ReducedMotion reduced = reduce(matrices);
  const auto response_to = [&](double c) { return response_of(reduced, c); };
  const auto [response, c] = best_response(matrices.typical_frequency(), kShiftsOfReduced, response_to);
  check_found(response);
  Eigenpairs pairs = with_slow_ones(
      matrices, eigenpairs_of(response, reduced.basis, c), c, [&](double rate, const MatrixXd&) {
        const auto [of_slow, about] = best_response(rate, kShiftsOfSlow, response_to);
        return of_slow.size() == 0 ? Eigenpairs() : eigenpairs_of(of_slow, reduced.basis, about);
      });
  polish(matrices, reduced, pairs, 2 * Index{count} + 2);
  return pairs;
}

/// All of them where something rolls: x = N y by the constraints on positions, and y' = G y + Z w by those on
/// velocities, A N y' + B N y = 0, so that w alone has inertia:
///
///   s y = G y + Z w,   s Z^T M Z w = -Z^T ((M G + D) (G y + Z w) + K y)
///
/// c is a rate of the motion and not next to zero: what rolls is free to be elsewhere, to go elsewhere and to
/// do so faster and faster, three and more motions of s = 0 that beside it would be all that counts.
Eigenpairs solve_rolling(const MotionMatrices& matrices) {
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
  const auto response_to = [&](double shift) {
    const Eigen::FullPivLU<MatrixXd> lu(right - shift * left);
    return lu.isInvertible() ? MatrixXd(lu.solve(left)) : MatrixXd();
  };
  const auto [response, c] = best_response(matrices.typical_frequency(), kShiftsOfReduced, response_to);
  check_found(response);
  return eigenpairs_of(response, basis, c);
}

/// The operator, on vectors (a, b / rate), less what lies in the space of those found.
class Response {
 public:
  using Scalar = double;

  struct Stopped {};

  Response(const ConstrainedSystem& system, const MotionMatrices& matrices, double c, int threads,
           Backend backend, std::function<bool()> go_on)
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
  MatrixXd images(const MatrixXd& columns) const {
    MatrixXd image(columns.rows(), columns.cols());
    for (Index i = 0; i < columns.cols(); ++i) image.col(i) = apply(columns.col(i));
    return image;
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
  const MotionMatrices& matrices_;
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

/// Those of the space of these columns. Throws where they are not the operator's.
Eigenpairs eigenpairs_in(const MatrixXd& basis, const Response& response, double c, Index wanted) {
  const Index n = response.rows() / 2;
  const MatrixXd image = response.images(basis);
  const Eigen::EigenSolver<MatrixXd> solver(basis.transpose() * image);
  const MatrixXcd y = solver.eigenvectors();
  const VectorXcd theta = solver.eigenvalues();
  const MatrixXcd error = image * y - basis * y * theta.asDiagonal();
  std::vector<double> sizes(static_cast<std::size_t>(theta.size()));
  for (Index i = 0; i < theta.size(); ++i) sizes[static_cast<std::size_t>(i)] = std::abs(theta[i]);
  std::sort(sizes.begin(), sizes.end(), std::greater<>());
  const double least = wanted < theta.size() ? sizes[static_cast<std::size_t>(wanted)] : -1.0;
  for (Index i = 0; i < theta.size(); ++i)
    if (std::abs(theta[i]) > least &&
        !(error.col(i).norm() <= kAccepted * std::abs(theta[i]) * y.col(i).norm()))
      throw Error("modes: the eigenvalues that have been found are not accurate");
  return with_inertia(theta, (basis * y).topRows(n), c);
}

MatrixXd orthonormal(const MatrixXd& columns) {
  const Eigen::HouseholderQR<MatrixXd> qr(columns);
  return qr.householderQ() * MatrixXd::Identity(columns.rows(), columns.cols());
}

/// Slow ones, by iteration with the whole space of their x and s x: beside them all others are so far from c
/// that they leave it at once.
Eigenpairs solve_slow(const Response& response, const MatrixXd& space, double c) {
  const Index n = space.rows(), count = space.cols();
  MatrixXd basis = MatrixXd::Zero(2 * n, 2 * count);
  basis.topLeftCorner(n, count) = space;
  basis.bottomRightCorner(n, count) = space;
  for (int i = 0; i < kStepsOfSlow; ++i) basis = orthonormal(response.images(basis));
  return eigenpairs_in(basis, response, c, count);
}

Eigenpairs solve_large(const ConstrainedSystem& system, const MotionMatrices& matrices, int count,
                       int threads, Backend backend, const std::function<bool()>& go_on) {
  const double c = kShift * matrices.typical_frequency();
  Response response(system, matrices, c, threads, backend, go_on);
  try {
    find_vectors(response, 2 * Index{count} + 2);
  } catch (const Response::Stopped&) {
    if (response.found().cols() == 0) return {};
  }
  const Index found = response.found().cols();
  return with_slow_ones(matrices, eigenpairs_in(response.found(), response, c, found), c,
                        [&](double rate, const MatrixXd& space) {
                          try {
                            return solve_slow(Response(system, matrices, rate, threads, backend, go_on),
                                              space, rate);
                          } catch (const SingularMatrix&) {  // beside free motions
                            return Eigenpairs();
                          }
                        });
}

/// One of conjugate modes, the growing one of two real ones of opposite sign, nearest to zero first.
std::vector<Mode> modes_of(const ConstrainedSystem& system, const MotionMatrices& matrices,
                           const Eigenpairs& pairs) {
  std::vector<Mode> modes;
  for (Index i = 0; i < pairs.s.size(); ++i) {
    if (pairs.s[i].imag() < 0) continue;
    Mode mode{{pairs.s[i].real(), std::abs(pairs.s[i].imag())},
              {},
              rounding_of(matrices, pairs.s[i], pairs.x.col(i))};  // no negative zero
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
Eigenpairs solve(const ConstrainedSystem& system, const MotionMatrices& matrices, int count, int threads,
                 Backend backend, const std::function<bool()>& go_on) {
  const int n = system.coordinates(), m = system.constraints(), moving = matrices.first_moving();
  if (n - m <= kDenseFreedoms && n <= kDenseCoordinates)
    return moving < 0 ? solve_reduced(matrices, count) : solve_rolling(matrices);
  if (moving >= 0)
    throw InvalidInput(system.constraint_name(moving),
                       "modes about a motion in which it rolls are found for mechanisms of up to " +
                           std::to_string(kDenseFreedoms) + " degrees of freedom and " +
                           std::to_string(kDenseCoordinates) + " coordinates, not " + std::to_string(n - m) +
                           " and " + std::to_string(n));
  return solve_large(system, matrices, count, threads, backend, go_on);
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
  const MotionMatrices matrices(seen, at, damping);
  std::vector<Mode> modes = modes_of(own, matrices, solve(seen, matrices, count, threads, backend, go_on));
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
