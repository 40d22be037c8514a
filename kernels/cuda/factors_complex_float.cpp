#include "kernels/cuda/plan_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<Kokkos::complex<float>, Kokkos::complex<float>>;  // tested by itself
template Planned<Factors<std::complex<float>>> plan_factors<std::complex<float>, std::complex<float>>(
    std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, const DeviceRoom&);

}  // namespace mfs::cuda
