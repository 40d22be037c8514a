#include "kernels/cuda/plan_factors_def.hpp"

namespace mfs::cuda {

template Planned<Factors<std::complex<double>>> plan_factors<std::complex<double>, std::complex<float>>(
    std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, const DeviceRoom&);

}  // namespace mfs::cuda
