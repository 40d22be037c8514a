#include "kernels/cuda/cuda_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<Kokkos::complex<double>, Kokkos::complex<double>>;  // tested by itself
template std::unique_ptr<Factors<std::complex<double>>>
    make_factors<std::complex<double>, std::complex<double>>(std::shared_ptr<const SymbolicPlan>,
                                                             std::shared_ptr<const Pattern>);
template Offset bytes_of_factors<std::complex<double>, std::complex<double>>(const SymbolicPlan&,
                                                                             const Pattern&);

}  // namespace mfs::cuda
