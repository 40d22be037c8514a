// Thyra's vector whose numbers lie with an executor, for NOX. NOX makes seven passes over such vectors per
// iteration (copies of the iterate, of its residual and its correction) and takes a norm: these are the
// executor's. What is cloned from such a vector is one as well, and NOX clones all of its vectors from the
// first iterate. All other operations of Thyra go through copies on the host.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Thyra_VectorDefaultBase.hpp>
#include <Thyra_VectorSpaceBase.hpp>

#include "dae/vectors/executor.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {

class ExecutorVector : public Thyra::VectorDefaultBase<double> {
 public:
  using Space = Thyra::VectorSpaceBase<double>;
  using Vector = Thyra::VectorBase<double>;
  using Vectors = Thyra::MultiVectorBase<double>;
  using View = RTOpPack::SubVectorView<double>;
  using ConstView = RTOpPack::ConstSubVectorView<double>;

  /// Its entries are not set. `executor` has to live as long. Throws OutOfMemory, std::bad_alloc.
  ExecutorVector(Teuchos::RCP<const Space> space, const Executor& executor)
      : space_(std::move(space)), executor_(executor) {
    numbers_.resize(executor, static_cast<std::size_t>(space_->dim()));
  }

  Teuchos::RCP<const Space> space() const override { return space_; }
  Teuchos::RCP<Vector> clone_v() const override {
    const auto copy = Teuchos::rcp(new ExecutorVector(space_, executor_));
    copy->assignMultiVecImpl(*this);
    return copy;
  }

  /// In the executor's memory.
  double* data() { return numbers_.data(); }
  const double* data() const { return numbers_.data(); }
  std::size_t size() const { return numbers_.size(); }

  static ExecutorVector& of(Vectors& vector) { return dynamic_cast<ExecutorVector&>(vector); }
  static const ExecutorVector& of(const Vectors& vector) {
    return dynamic_cast<const ExecutorVector&>(vector);
  }

 protected:
  void assignImpl(double value) override { fill(executor_, size(), value, data()); }
  void assignMultiVecImpl(const Vectors& vector) override {
    copy(executor_, size(), of(vector).data(), data());
  }
  void scaleImpl(double factor) override { dae::scale(executor_, size(), factor, data()); }
  void linearCombinationImpl(const Teuchos::ArrayView<const double>& alpha,
                             const Teuchos::ArrayView<const Teuchos::Ptr<const Vectors>>& vectors,
                             const double& beta) override {
    std::vector<const double*> terms;
    for (const auto& vector : vectors) terms.push_back(of(*vector).data());
    combine(executor_, size(), beta, data(), {alpha.begin(), alpha.end()}, terms);
  }
  void norms2Impl(const Teuchos::ArrayView<double>& norms) const override {
    norms[0] = norm(executor_, size(), data());
  }

  void applyOpImpl(const RTOpPack::RTOpT<double>& op,
                   const Teuchos::ArrayView<const Teuchos::Ptr<const Vector>>& vectors,
                   const Teuchos::ArrayView<const Teuchos::Ptr<Vector>>& targets,
                   const Teuchos::Ptr<RTOpPack::ReductTarget>& reduced,
                   const Teuchos::Ordinal /*offset*/) const override {
    std::vector<ConstView> from(static_cast<std::size_t>(vectors.size()));
    std::vector<View> to(static_cast<std::size_t>(targets.size()));
    for (std::size_t k = 0; k < from.size(); ++k) vectors[k]->acquireDetachedView({}, &from[k]);
    for (std::size_t k = 0; k < to.size(); ++k) targets[k]->acquireDetachedView({}, &to[k]);
    op.apply_op({from.data(), vectors.size()}, {to.data(), targets.size()}, reduced);
    for (std::size_t k = 0; k < from.size(); ++k) vectors[k]->releaseDetachedView(&from[k]);
    for (std::size_t k = 0; k < to.size(); ++k) targets[k]->commitDetachedView(&to[k]);
  }
  void acquireDetachedVectorViewImpl(const Teuchos::Range1D& range, ConstView* view) const override {
    *view = view_of(range);
  }
  void releaseDetachedVectorViewImpl(ConstView* view) const override { view->uninitialize(); }
  void acquireNonconstDetachedVectorViewImpl(const Teuchos::Range1D& range, View* view) override {
    *view = view_of(range);
  }
  void commitNonconstDetachedVectorViewImpl(View* view) override {
    executor_.from_host(data() + view->globalOffset(), view->values().get(), view->subDim() * sizeof(double));
    view->uninitialize();
  }

 private:
  View view_of(const Teuchos::Range1D& range) const {
    const Teuchos::Range1D given = Teuchos::full_range(range, 0, space_->dim() - 1);
    Teuchos::ArrayRCP<double> values(given.size());
    executor_.to_host(values.get(), data() + given.lbound(), given.size() * sizeof(double));
    return {given.lbound(), given.size(), values, 1};
  }

  Teuchos::RCP<const Space> space_;
  const Executor& executor_;
  Array<double> numbers_;
};

}  // namespace mfs::dae
