#include "kernels/cuda/plan_factors_def.hpp"

namespace mfs::cuda {

template class DeviceStages<double, double>;  // perf/depths.cpp takes its times
template Planned<Factors<double>> plan_factors<double, double>(std::shared_ptr<const SymbolicPlan>,
                                                               std::shared_ptr<const Pattern>,
                                                               const DeviceRoom&);

template <>
DeviceLimits limits_for<double>(int multiprocessors, std::size_t memory) {
  return device_limits<double>(multiprocessors, memory, kNoRoots);
}
DeviceCode device_code() {
  const int code = code_of(reinterpret_cast<const void*>(&settle_strict_fronts));
  return {code, has_tensor_cores(10 * code)};
}

}  // namespace mfs::cuda
