#include "kernels/cuda/cuda_factors_def.hpp"

namespace mfs::cuda {

template std::unique_ptr<Factors<double>> make_factors<double, float>(std::shared_ptr<const SymbolicPlan>,
                                                                      std::shared_ptr<const Pattern>);

}  // namespace mfs::cuda
