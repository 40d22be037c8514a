// The last rung of the ladder on the host: a factorization by Householder reflections (Eigen's SparseQR),
// under which nothing grows. LU with exchanges of rows lets entries grow by up to 2^(n-1), and does so for
// two-point boundary value problems by multiple shooting (Wright, A collection of problems for which Gaussian
// elimination with partial pivoting is unstable, SIAM J. Sci. Comput. 14, 1993).
#pragma once

#include <complex>
#include <memory>
#include <type_traits>
#include <vector>

#include <mfs/csr_view.hpp>

#include "accuracy/solve_controls.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// Double precision, real or complex as Scalar is.
template <class Scalar>
using WideOf = std::conditional_t<std::is_floating_point_v<Scalar>, double, std::complex<double>>;

template <class Scalar>
class OrthogonalSolver {
 public:
  /// Of A, or of A^T, with columns in the given order or, where that is cheaper, in that of COLAMD. `scaling`
  /// belongs to A. Null where it would take more than some seconds or `room` bytes, or A is structurally
  /// singular. Throws std::bad_alloc.
  static std::unique_ptr<OrthogonalSolver> make(const CsrView<Scalar>& a, bool transposed,
                                                const MatchedScaling& scaling,
                                                const std::vector<Vertex>& order, double room);
  ~OrthogonalSolver();

  /// |A z| / | |A||z| | in scaled rows for the solution z of a right-hand side that is as good as random:
  /// small where A is singular. And where |z| in scaled columns is largest.
  double smallness() const;
  Vertex dependent_column() const;

  /// Solves for x [n], with steps of refinement. The outcome does not tell whether A is singular.
  SolveOutcome solve(const Scalar* b, Scalar* x, const SolveControls& controls) const;

 private:
  struct Parts;
  explicit OrthogonalSolver(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace mfs
