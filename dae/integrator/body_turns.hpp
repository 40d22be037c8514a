// Interpolation between states of a body that turns. On polynomials through the positions of its points a
// body is stretched: in each of them a part of the local error is left, which is nothing beside the motion
// and may be more than what the body is stretched by its forces. So states are turned back to one attitude
// first, which leaves deflections, and rotation vectors and deflections are what is interpolated.
#pragma once

#include <array>
#include <vector>

namespace mfs::dae {

/// Sums over the points of a body: positions x in a state, and x_i X_j with their positions X, from their
/// mean, in the present state.
struct PointSums {
  std::array<double, 3> x{};
  std::array<double, 9> x_by_now{};
};

/// A vector x of a point, one for each state, comes to the sum of matrix x, and positions to `shift` more.
struct TurnedShares {
  std::vector<std::array<double, 9>> matrix;
  std::array<double, 3> shift{};
};

/// `sums`: of the states, the present one first; `shares`: what each of them counts where nothing turns, in
/// all 1. Bodies whose attitude points do not tell, as they are on one line, are not turned.
TurnedShares turned_shares(const std::vector<PointSums>& sums, int points, const std::vector<double>& shares);

}  // namespace mfs::dae
