#include "kernels/cuda/plan_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<Kokkos::complex<double>, Kokkos::complex<double>>;  // tested by itself
template Planned<Factors<std::complex<double>>> plan_factors<std::complex<double>, std::complex<double>>(
    std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, const DeviceRoom&);

}  // namespace mfs::cuda
