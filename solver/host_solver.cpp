#include "solver/host_solver.hpp"

#include <complex>

namespace mfs {

namespace {

Options on_host(Options options) {
  options.backend = Backend::openmp;
  options.memory_limit = 0;
  options.factor.precision = Precision::full;
  options.dump_prefix.clear();
  return options;
}

}  // namespace

template <class Scalar>
bool HostSolver<Scalar>::serves() {
  if (!factors_.on_device()) return false;
  if (factors_.analyses() != analysis_) {
    solver_.reset();
    fallback_ = Fallback();
    analysis_ = factors_.analyses();
    seen_ = factored_ = 0;
  }
  if (factors_.value_sets() != seen_) {
    if (seen_ > 0) fallback_.end();
    seen_ = factors_.value_sets();
    fallback_.begin();
  }
  return fallback_.active();
}

template <class Scalar>
BasicSolver<Scalar>& HostSolver<Scalar>::solver() {
  if (!solver_) solver_ = std::make_unique<BasicSolver<Scalar>>(on_host(options_));
  if (factored_ != factors_.value_sets()) solver_->factor(factors_.factored_matrix());
  factored_ = factors_.value_sets();
  return *solver_;
}

template class HostSolver<float>;
template class HostSolver<double>;
template class HostSolver<std::complex<float>>;
template class HostSolver<std::complex<double>>;

}  // namespace mfs
