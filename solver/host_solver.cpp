#include "solver/host_solver.hpp"

#include <complex>

namespace mfs {

template <class Scalar>
HostSolver<Scalar>::HostSolver(const Options& options) : options_(options) {
  options_.backend = Backend::openmp;
  options_.memory_limit = 0;
  options_.factor.precision = Precision::full;
  options_.dump_prefix.clear();
}

template <class Scalar>
bool HostSolver<Scalar>::serves(const MatrixFactors<Scalar>& factors) {
  if (factors.value_sets() != seen_) {
    if (seen_ > 0) fallback_.end();
    seen_ = factors.value_sets();
    fallback_.begin();
  }
  return fallback_.active() && factors.on_device();
}

template <class Scalar>
BasicSolver<Scalar>& HostSolver<Scalar>::solver_for(const MatrixFactors<Scalar>& factors) {
  if (solver_ && analysis_ == factors.analyses() && values_ == factors.value_sets()) return *solver_;
  if (!solver_ || analysis_ != factors.analyses()) {
    solver_ = std::make_unique<BasicSolver<Scalar>>(options_);
    analysis_ = factors.analyses();
  }
  solver_->factor(factors.factored_matrix());
  values_ = factors.value_sets();
  return *solver_;
}

template class HostSolver<float>;
template class HostSolver<double>;
template class HostSolver<std::complex<float>>;
template class HostSolver<std::complex<double>>;

}  // namespace mfs
