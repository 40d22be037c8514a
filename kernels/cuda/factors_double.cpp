#include "kernels/cuda/cuda_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<double, double>;  // perf/depths.cpp takes its times
template Planned<Factors<double>> plan_factors<double, double>(std::shared_ptr<const SymbolicPlan>,
                                                               std::shared_ptr<const Pattern>);

}  // namespace mfs::cuda
