#include "kernels/cuda/plan_factors_def.hpp"

namespace mfs::cuda {

template Planned<Factors<double>> plan_factors<double, float>(std::shared_ptr<const SymbolicPlan>,
                                                              std::shared_ptr<const Pattern>,
                                                              const DeviceRoom&);

}  // namespace mfs::cuda
