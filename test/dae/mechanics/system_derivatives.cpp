#include "test/dae/mechanics/system_derivatives.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "test/dae/mechanics/dense.hpp"

namespace mfs::test {
namespace {

using dae::Block;
using dae::ConstrainedSystem;
using dae::Residual;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Residual residual_at(const ConstrainedSystem& system, const State& state) {
  Residual residual = make_residual(system);
  system.evaluate(state.view(), residual);
  return residual;
}

VectorXd vector(const std::vector<double>& x) {
  return Eigen::Map<const VectorXd>(x.data(), x.size());
}

void expect_close(const MatrixXd& found, const MatrixXd& expected, double tolerance, const char* what) {
  ASSERT_EQ(found.rows(), expected.rows()) << what;
  if (found.size() == 0) return;
  const double error = (found - expected).cwiseAbs().maxCoeff();
  EXPECT_LT(error, tolerance * (1 + expected.cwiseAbs().maxCoeff())) << what;
}

/// Derivative of one residual by one part of the state.
MatrixXd difference(const ConstrainedSystem& system, State state, std::vector<double> State::*by,
                    std::vector<double> Residual::*of) {
  constexpr double kStep = 1e-5;
  MatrixXd matrix((residual_at(system, state).*of).size(), system.coordinates());
  for (int k = 0; k < system.coordinates(); ++k) {
    double& x = (state.*by)[k];
    const double old = x;
    x = old + kStep;
    const VectorXd after = vector(residual_at(system, state).*of);
    x = old - kStep;
    const VectorXd before = vector(residual_at(system, state).*of);
    x = old;
    matrix.col(k) = (after - before) / (2 * kStep);
  }
  return matrix;
}

/// The state after a time s of the motion that begins with its q, v, a.
State moved(const State& state, double s) {
  State later = state;
  later.t += s;
  for (std::size_t k = 0; k < state.q.size(); ++k) {
    later.q[k] += s * state.v[k] + s * s / 2 * state.a[k];
    later.v[k] += s * state.a[k];
  }
  return later;
}

}  // namespace

void expect_true_derivatives(const ConstrainedSystem& system, const State& state, double tolerance) {
  dae::Tangent tangent = make_tangent(system);
  system.evaluate(state.view(), tangent, dae::BlockSet::all());
  const auto block = [&](Block b) { return dense(system.tangent_pattern()[b], tangent[b]); };
  const auto expect = [&](Block b, std::vector<double> State::*by, std::vector<double> Residual::*of,
                          const char* what) {
    expect_close(block(b), difference(system, state, by, of), tolerance, what);
  };
  expect(Block::force_q, &State::q, &Residual::force, "force_q");
  expect(Block::force_v, &State::v, &Residual::force, "force_v");
  expect(Block::force_a, &State::a, &Residual::force, "force_a");
  // Constraints on velocities have no position that they would be derivatives of.
  MatrixXd gradient = block(Block::position_q);
  VectorXd rates = vector(residual_at(system, state).velocity);
  for (int row = 0; row < system.constraints(); ++row)
    if (system.is_nonholonomic(row)) gradient.row(row).setZero(), rates[row] = 0.0;
  expect_close(gradient, difference(system, state, &State::q, &Residual::position), tolerance, "position_q");
  expect(Block::position_q, &State::v, &Residual::velocity, "position_q as velocity_v");
  expect(Block::position_q, &State::a, &Residual::acceleration, "position_q as acceleration_a");
  expect(Block::velocity_q, &State::q, &Residual::velocity, "velocity_q");
  expect(Block::acceleration_q, &State::q, &Residual::acceleration, "acceleration_q");
  expect(Block::acceleration_v, &State::v, &Residual::acceleration, "acceleration_v");

  // A block alone may be evaluated another way.
  for (const Block b : {Block::force_q, Block::position_q, Block::velocity_q, Block::acceleration_v}) {
    dae::Tangent alone = make_tangent(system);
    system.evaluate(state.view(), alone, {b});
    expect_close(dense(system.tangent_pattern()[b], alone[b]), block(b), 1e-13, "alone");
  }

  constexpr double kStep = 1e-5;
  const Residual here = residual_at(system, state);
  const Residual after = residual_at(system, moved(state, kStep));
  const Residual before = residual_at(system, moved(state, -kStep));
  expect_close(rates, (vector(after.position) - vector(before.position)) / (2 * kStep), tolerance,
               "d/dt Phi");
  expect_close(vector(here.acceleration), (vector(after.velocity) - vector(before.velocity)) / (2 * kStep),
               tolerance, "d^2/dt^2 Phi");
  State free = state;
  free.lambda.assign(state.lambda.size(), 0.0);
  expect_close(vector(here.force) - vector(residual_at(system, free).force),
               block(Block::position_q).transpose() * vector(state.lambda), 1e-12, "Phi_q^T lambda");
}

}  // namespace mfs::test
