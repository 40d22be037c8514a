// Eigenpairs of few degrees of freedom, made exact one by one. What is far from the rate c about which all
// were found is known in parts of what is nearest to it. With Q(s) = s^2 M + s D + K each is followed by
//
//   Q(s) x' = Q'(s) x,   Q(s)^H z' = Q'(s)^H z,   s' = s - z^H Q(s) x / z^H Q'(s) x
//
// inverse iteration at its own s and the quotient of both vectors (Ostrowski, Arch. Rational Mech. Anal. 3,
// 1959; Lancaster, Lambda-matrices and Vibrating Systems, 1966), whose error is the square of theirs. The
// quotient is of the matrices as they are, so that no more is lost than their entries' rounding.
#pragma once

#include "dae/statics/slow_modes.hpp"

namespace mfs::dae {

/// N, a basis of what constraints leave free, and N^T M N, N^T D N, N^T K N.
struct ReducedMotion {
  Eigen::MatrixXd basis, mass, damping, stiffness;
};

/// Of the first `count` pairs those that are not conjugates of others, and not free. One that would become
/// another motion stays as it is.
void polish(const MotionMatrices& matrices, const ReducedMotion& reduced, Eigenpairs& pairs,
            Eigen::Index count);

}  // namespace mfs::dae
