#include "kernels/cuda/cuda_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<double, double>;  // perf/depths.cpp takes its times
template std::unique_ptr<Factors<double>> make_factors<double, double>(std::shared_ptr<const SymbolicPlan>,
                                                                       std::shared_ptr<const Pattern>);
template Offset bytes_of_factors<double, double>(const SymbolicPlan&, const Pattern&);

}  // namespace mfs::cuda
