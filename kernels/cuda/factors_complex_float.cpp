#include "kernels/cuda/cuda_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<Kokkos::complex<float>, Kokkos::complex<float>>;  // tested by itself
template std::unique_ptr<Factors<std::complex<float>>> make_factors<std::complex<float>, std::complex<float>>(
    std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>);
template Offset bytes_of_factors<std::complex<float>, std::complex<float>>(const SymbolicPlan&,
                                                                           const Pattern&);

}  // namespace mfs::cuda
