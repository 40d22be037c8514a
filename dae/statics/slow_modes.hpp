// Modes far slower than the rate c about which they were looked for. Of them 1 / (s - c) is next to -1 / c,
// whatever s is: of s^2 a rounding is left in parts of c^2, which a stiff part has set, and what is slower
// than that is lost in it, as a weight on a soft spring is that carries a light one on a stiff spring. So
// they are looked for again, about their own rate, and again where some are far slower than that.
//
// That rate is told by the motions themselves. X has their x as columns, which are good although s is not:
//
//   (s^2 X^T M X + s X^T D X + X^T K X) y = 0
//
// Of a free motion |s|^2 is no more than what rounding of K x leaves, |x|^T |K| |x| beside x^T M x, of the
// parts that the motion moves: it has no rate.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "dae/statics/motion_matrices.hpp"

namespace mfs::dae {

/// s, and x as columns; of conjugate ones both.
struct Eigenpairs {
  Eigen::VectorXcd s;
  Eigen::MatrixXcd x;
};

/// Puts those nearest to zero first.
void sort_by_size(Eigenpairs& pairs);

/// Of s, in parts of it: what rounding of the motion's forces may leave there. Infinite of a free motion.
double rounding_of(const MotionMatrices& matrices, std::complex<double> s, const Eigen::VectorXcd& x);

/// Whether s is no more than rounding leaves of the motion's forces, so that it may be free.
bool may_be_free(const MotionMatrices& matrices, std::complex<double> s, const Eigen::VectorXcd& x);

/// Eigenpairs about c, at least those whose x lie near the space of these columns; none where c suits the
/// system not.
using AboutRate = std::function<Eigenpairs(double c, const Eigen::MatrixXd& space)>;

/// Those of `pairs`, found about c, with the slow ones as `find` has them about their own rates, sorted.
Eigenpairs with_slow_ones(const MotionMatrices& matrices, Eigenpairs pairs, double c, const AboutRate& find);

}  // namespace mfs::dae
