// Thyra's vector of Tpetra, whose passes are made by all threads of the integrator. NOX makes seven of them
// per iteration (copies of the iterate, of its residual and its correction) and takes a norm, and the Tpetra
// of Debian's Trilinos has one thread. What is cloned from such a vector is one as well, and NOX clones all
// of its vectors from the first iterate. Other operations are Tpetra's.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include <Thyra_TpetraThyraWrappers.hpp>
#include <Tpetra_Vector.hpp>

#include "dae/integrator/vector_loops.hpp"

namespace mfs::dae {

class ThreadedVector
    : public Thyra::TpetraVector<double, Tpetra::Map<>::local_ordinal_type,
                                 Tpetra::Map<>::global_ordinal_type, Tpetra::Map<>::node_type> {
 public:
  using Space = Thyra::TpetraVectorSpace<double, Tpetra::Map<>::local_ordinal_type,
                                         Tpetra::Map<>::global_ordinal_type, Tpetra::Map<>::node_type>;
  using Vectors = Thyra::MultiVectorBase<double>;

  /// Its entries are not set. `space` is Tpetra's.
  ThreadedVector(const Teuchos::RCP<const Space>& space, int threads) : space_(space), threads_(threads) {
    initialize(space, Teuchos::rcp(new Tpetra::Vector<double>(space->getTpetraMap(), false)));
  }

  Teuchos::RCP<Thyra::VectorBase<double>> clone_v() const override {
    const auto copy = Teuchos::rcp(new ThreadedVector(space_, threads_));
    copy->assignMultiVecImpl(*this);
    return copy;
  }

  double* data() { return getTpetraVector()->getDataNonConst().getRawPtr(); }
  const double* data() const { return getConstTpetraVector()->getData().getRawPtr(); }

 protected:
  void assignImpl(double value) override {
    double* const x = data();
    for_each([=](std::size_t i) { x[i] = value; });
  }
  void assignMultiVecImpl(const Vectors& vector) override {
    const double* const y = data_of(vector);
    double* const x = data();
    for_each([=](std::size_t i) { x[i] = y[i]; });
  }
  void scaleImpl(double factor) override {
    double* const x = data();
    for_each([=](std::size_t i) { x[i] *= factor; });
  }
  /// x = beta x + alpha[0] vectors[0] + ...; what x was does not matter where beta is 0.
  void linearCombinationImpl(const Teuchos::ArrayView<const double>& alpha,
                             const Teuchos::ArrayView<const Teuchos::Ptr<const Vectors>>& vectors,
                             const double& beta) override {
    std::vector<const double*> terms;
    for (const auto& vector : vectors) terms.push_back(data_of(*vector));
    const std::vector<double> factors(alpha.begin(), alpha.end());
    const double of_old = beta;
    double* const x = data();
    for_each([&](std::size_t i) {
      double sum = of_old == 0.0 ? 0.0 : of_old * x[i];
      for (std::size_t t = 0; t < terms.size(); ++t) sum += factors[t] * terms[t][i];
      x[i] = sum;
    });
  }

  void norms2Impl(const Teuchos::ArrayView<double>& norms) const override {
    const double* const x = data();
    norms[0] = std::sqrt(parallel_fold(
        static_cast<std::size_t>(space_->dim()), threads_, 0.0, [=](std::size_t i) { return x[i] * x[i]; },
        std::plus<>()));
  }

 private:
  static const double* data_of(const Vectors& vector) {
    using Convert = Thyra::TpetraOperatorVectorExtraction<double>;
    return Convert::getConstTpetraVector(vector.col(0))->getData().getRawPtr();
  }
  template <class F>
  void for_each(const F& f) const {
    parallel_for(static_cast<std::size_t>(space_->dim()), threads_, f);
  }

  Teuchos::RCP<const Space> space_;
  int threads_;
};

}  // namespace mfs::dae
