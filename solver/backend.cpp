#include "solver/backend.hpp"

#include <complex>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "kernels/cuda/cuda_factors.hpp"
#include "kernels/dense/blas.hpp"
#include "kernels/runtime/scalars.hpp"
#include "plan/device_plan.hpp"
#include "solver/memory_limit.hpp"
#include "solver/option_checks.hpp"

namespace mfs {

void BackendRules::check(const Options&) const {}

std::size_t BackendRules::available_memory() const {
  return available_host_memory();
}

template <class Scalar>
std::future<void> BackendFor<Scalar>::load_beside(bool, const Pattern&) const {
  return {};
}

template <class Scalar>
Offset BackendFor<Scalar>::bytes_needed(bool single_precision, const SymbolicPlan& plan,
                                        const Pattern&) const {
  return numeric_bytes(plan, single_precision ? sizeof(Narrow<Scalar>) : sizeof(Scalar), sizeof(Scalar))
      .total();
}

namespace {

template <class Scalar>
std::unique_ptr<Factorization<Scalar>> make_on_host(const BackendFor<Scalar>& host, HostSpace space,
                                                    bool single_precision,
                                                    std::shared_ptr<const SymbolicPlan> plan,
                                                    std::shared_ptr<const Pattern> pattern, int threads) {
  const auto needed = static_cast<std::size_t>(host.bytes_needed(single_precision, *plan, *pattern));
  const std::size_t available = host.available_memory();
  if (needed > available) throw OutOfMemory(MemorySpace::host, needed, available);
  auto factors = make_host_factors<Scalar>(space, single_precision, plan, pattern, threads);
  return make_factorization<Scalar>(space, std::move(factors), std::move(plan), std::move(pattern));
}

template <class Scalar>
class SerialBackend final : public BackendFor<Scalar> {
 public:
  bool one_thread() const override { return true; }
  std::unique_ptr<Factorization<Scalar>> make(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                              std::shared_ptr<const Pattern> pattern,
                                              int threads) const override {
    return make_on_host<Scalar>(*this, HostSpace::serial, single_precision, std::move(plan),
                                std::move(pattern), threads);
  }
};

template <class Scalar>
class OpenMPBackend final : public BackendFor<Scalar> {
 public:
  std::unique_ptr<Factorization<Scalar>> make(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                              std::shared_ptr<const Pattern> pattern,
                                              int threads) const override {
    // Below about a millisecond of work, waking other threads costs more than they save; with a BLAS that
    // only one thread may call, they would do harm.
    constexpr double kSerialFlops = 2e7;
    const bool serial = plan->flops.total() < kSerialFlops || !blas::many_callers();
    return make_on_host<Scalar>(*this, serial ? HostSpace::serial : HostSpace::openmp, single_precision,
                                std::move(plan), std::move(pattern), threads);
  }
};

template <class Scalar>
class CudaBackend final : public BackendFor<Scalar> {
 public:
  bool present() const override { return cuda::device_found(); }
  void check(const Options& options) const override {
    if (options.analysis.max_block_size != AnalysisOptions().max_block_size)
      throw InvalidInput("max_block_size", "the blocks of backend cuda are its own: leave it at " +
                                               std::to_string(AnalysisOptions().max_block_size));
    cuda::require_device();
  }
  Precision automatic_precision() const override { return mfs::automatic_precision(cuda::speed_of_single()); }
  AssemblyTurns assembly_turns() const override { return kAssemblyTurns; }
  std::size_t available_memory() const override { return cuda::available_device_memory(); }
  std::future<void> load_beside(bool single_precision, const Pattern& pattern) const override {
    return cuda::load_library<Scalar>(single_precision, pattern);
  }
  Offset bytes_needed(bool single_precision, const SymbolicPlan& plan,
                      const Pattern& pattern) const override {
    return cuda::device_bytes<Scalar>(single_precision, plan, pattern);
  }
  std::unique_ptr<Factorization<Scalar>> make(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                              std::shared_ptr<const Pattern> pattern, int) const override {
    auto factors = cuda::make_cuda_factors<Scalar>(single_precision, plan, pattern);
    return make_factorization<Scalar>(HostSpace::openmp, std::move(factors), std::move(plan),
                                      std::move(pattern));
  }
};

}  // namespace

template <class Scalar>
const BackendFor<Scalar>& backend_for(Backend backend) {
  static const SerialBackend<Scalar> serial;
  static const OpenMPBackend<Scalar> openmp;
  static const CudaBackend<Scalar> cuda;
  switch (backend) {
    case Backend::serial:
      return serial;
    case Backend::openmp:
      return openmp;
    case Backend::cuda:
      return cuda;
  }
  throw InvalidInput("backend", "no such backend");
}

const BackendRules& rules_of(Backend backend) {
  return backend_for<double>(backend);
}

template const BackendFor<float>& backend_for<float>(Backend);
template const BackendFor<double>& backend_for<double>(Backend);
template const BackendFor<std::complex<float>>& backend_for<std::complex<float>>(Backend);
template const BackendFor<std::complex<double>>& backend_for<std::complex<double>>(Backend);

}  // namespace mfs
