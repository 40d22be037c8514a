// Forces between frames (those on one: loads.hpp). A bushing or a spring answers to deformations x(q) with a
// reaction s(x, x'); by virtual work its share of F is s x_q, so that it does no work that it should not, and
// conserves momentum.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"
#include "dae/mechanics/smooth_function.hpp"

namespace mfs::dae {

/// Elastic connection of two frames. Its deformations are P_b - P_a in a's axes, and the rotation of b's axes
/// against a's as four times the modified Rodrigues parameters, 4 tan(angle / 4) axis: the rotation vector up
/// to the third order (0.3 % more at 20 degrees), without a singularity below a full turn.
struct Bushing {
  std::string name;
  Attachment a, b;                    ///< relaxed when points and axes are together
  std::array<double, 6> stiffness{};  ///< along x y z, N/m, and about x y z, N m/rad
  std::array<double, 6> damping{};    ///< N s/m and N m s/rad
};

/// Throws InvalidInput("bushing NAME") as add_joint, and where a stiffness or a damping is negative.
void add_bushing(MultibodyBuilder& builder, const Bushing& bushing);

/// Spring and damper in parallel along the line between two points.
struct SpringDamper {
  std::string name;
  Attachment a, b;
  double stiffness = 0.0;    ///< N/m
  double damping = 0.0;      ///< N s/m
  double free_length = 0.0;  ///< m
  Function force;  ///< in place of the stiffness: N (positive: pulls) of the elongation over free_length, m
};

/// Throws InvalidInput("spring NAME") as add_joint, where a number is negative, both a stiffness and a
/// function are given, or the points are together at the beginning; the same at any later time when they come
/// together. A spring of a stiffness alone, of no free length, may have them together.
void add_spring_damper(MultibodyBuilder& builder, const SpringDamper& spring);

}  // namespace mfs::dae
