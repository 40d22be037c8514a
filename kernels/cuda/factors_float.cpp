#include "kernels/cuda/plan_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<float, float>;  // tested by itself
template Planned<Factors<float>> plan_factors<float, float>(std::shared_ptr<const SymbolicPlan>,
                                                            std::shared_ptr<const Pattern>,
                                                            const DeviceRoom&);

}  // namespace mfs::cuda
