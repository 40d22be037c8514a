#include "kernels/portable/portable_factors.hpp"

#include <utility>

#include "kernels/dense/blas.hpp"
#include "kernels/portable/factors_of_scalars.hpp"
#include "kernels/space/space.hpp"

namespace mfs::portable {

const char* space_name() {
  return Kokkos::DefaultExecutionSpace::name();
}
bool on_host() {
  return kOnHost<Kokkos::DefaultExecutionSpace>;
}
bool has_threads() {
  return !std::is_same_v<Kokkos::DefaultExecutionSpace, Kokkos::Serial> &&
         (!on_host() || blas::many_callers());
}
std::size_t free_memory() {
  Space<Kokkos::DefaultExecutionSpace>::start();
  return Space<Kokkos::DefaultExecutionSpace>::free_memory();
}

template <class Value>
Planned<Factors<Value>> plan_portable_factors(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                              std::shared_ptr<const Pattern> pattern, int threads) {
  if (single_precision)
    return plan_factors<Value, Narrow<Value>>(std::move(plan), std::move(pattern), threads);
  return plan_factors<Value, Value>(std::move(plan), std::move(pattern), threads);
}

#define MFS_INSTANTIATE(Value)                                                                             \
  template Planned<Factors<Value>> plan_portable_factors<Value>(bool, std::shared_ptr<const SymbolicPlan>, \
                                                                std::shared_ptr<const Pattern>, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::portable
