#include "kernels/cuda/cuda_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<float, float>;  // tested by itself
template std::unique_ptr<Factors<float>> make_factors<float, float>(std::shared_ptr<const SymbolicPlan>,
                                                                    std::shared_ptr<const Pattern>);
template Offset bytes_of_factors<float, float>(const SymbolicPlan&, const Pattern&);

}  // namespace mfs::cuda
