#include "solver/backend.hpp"

#include <mfs/error.hpp>

#include "kernels/dense/blas.hpp"
#include "kernels/runtime/scalars.hpp"
#include "kernels/cuda/cuda_factors.hpp"
#include "plan/device_plan.hpp"
#include "solver/memory_limit.hpp"

namespace mfs {

namespace {

// Below about a millisecond of work, waking other threads costs more than they save; with a BLAS that only
// one thread may call, they would do harm.
HostSpace host_space(Backend backend, const SymbolicPlan& plan) {
  constexpr double kSerialFlops = 2e7;
  const bool serial =
      backend == Backend::serial || plan.flops.total() < kSerialFlops || !blas::many_callers();
  return serial ? HostSpace::serial : HostSpace::openmp;
}

void check_host_memory(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes) {
  const auto needed = static_cast<std::size_t>(numeric_bytes(plan, scalar_bytes, value_bytes).total());
  const std::size_t available = available_host_memory();
  if (needed > available) throw OutOfMemory(MemorySpace::host, needed, available);
}

}  // namespace

void check_backend(Backend backend) {
  if (backend == Backend::cuda) cuda::require_device();
}

AssemblyTurns assembly_turns(Backend backend) {
  return backend == Backend::cuda ? kAssemblyTurns : AssemblyTurns();
}

std::size_t available_memory(Backend backend) {
  return backend == Backend::cuda ? cuda::available_device_memory() : available_host_memory();
}

template <class Scalar>
std::future<void> load_beside(Backend backend, bool single_precision, const Pattern& pattern) {
  if (backend != Backend::cuda) return {};
  return cuda::load_library<Scalar>(single_precision, pattern);
}

template <class Scalar>
std::unique_ptr<Factorization<Scalar>> make_numeric_factorization(Backend backend, bool single_precision,
                                                                  std::shared_ptr<const SymbolicPlan> plan,
                                                                  std::shared_ptr<const Pattern> pattern,
                                                                  int threads) {
  if (backend == Backend::cuda) {
    auto factors = cuda::make_cuda_factors<Scalar>(single_precision, plan, pattern);
    return make_factorization<Scalar>(HostSpace::openmp, std::move(factors), std::move(plan),
                                      std::move(pattern));
  }
  check_host_memory(*plan, single_precision ? sizeof(Narrow<Scalar>) : sizeof(Scalar), sizeof(Scalar));
  const HostSpace space = host_space(backend, *plan);
  auto factors = make_host_factors<Scalar>(space, single_precision, plan, pattern, threads);
  return make_factorization<Scalar>(space, std::move(factors), std::move(plan), std::move(pattern));
}

#define MFS_INSTANTIATE(Scalar)                                                       \
  template std::future<void> load_beside<Scalar>(Backend, bool, const Pattern&);      \
  template std::unique_ptr<Factorization<Scalar>> make_numeric_factorization<Scalar>( \
      Backend, bool, std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
