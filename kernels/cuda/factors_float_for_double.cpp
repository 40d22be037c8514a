#include "kernels/cuda/cuda_factors_def.hpp"

namespace mfs::cuda {

template std::unique_ptr<Factors<double>> make_factors<double, float>(std::shared_ptr<const SymbolicPlan>,
                                                                      std::shared_ptr<const Pattern>);
template Offset bytes_of_factors<double, float>(const SymbolicPlan&, const Pattern&);

}  // namespace mfs::cuda
