#include "kernels/cuda/cuda_factorization_def.hpp"

namespace mfs::cuda {

template <class Value>
std::unique_ptr<Factorization<Value>> make_cuda_factorization(bool single_precision,
                                                              std::shared_ptr<const SymbolicPlan> plan,
                                                              std::shared_ptr<const Pattern> pattern) {
  (void)single_precision;
  return std::make_unique<CudaFactorization<Value, Value>>(std::move(plan), std::move(pattern));
}

template class DeviceStages<double, double>;
template std::unique_ptr<Factorization<double>> make_cuda_factorization<double>(bool, std::shared_ptr<const SymbolicPlan>,
                                                                                std::shared_ptr<const Pattern>);

}  // namespace mfs::cuda
