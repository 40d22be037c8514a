#include "kernels/cuda/cuda_factors.hpp"

#include <mfs/error.hpp>

#include <atomic>
#include <system_error>

#include "kernels/cuda/factors_of_scalars.hpp"
#include "kernels/cuda/runtime/device.hpp"
#include "kernels/cuda/runtime/device_scalar.hpp"
#include "kernels/dense/device_blas.hpp"
#include "kernels/dense/device_lapack.hpp"
#include "kernels/runtime/engine.hpp"

namespace mfs::cuda {

namespace {

/// A product that the plans of devices give to the library (place_products), with the numbers S.
template <class S>
void make_product() {
  constexpr int kRows = 1024, kDepth = 256;
  constexpr Offset kPanel = Offset{kRows} * kDepth, kSum = Offset{kRows} * kRows;
  const Stream stream;
  const DeviceBlas blas(stream);
  const DeviceArena arena((2 * kPanel + kSum) * static_cast<Offset>(sizeof(S)));
  stream.clear(arena.at<S>(0), arena.bytes());
  S *const a = arena.at<S>(0), *const b = a + kPanel, *const c = b + kPanel;
  blas.gemm_minus<S>(kRows, kRows, kDepth, a, kRows, b, kDepth, c, kRows);
  stream.synchronize();
}

/// An LU as those of roots (DevicePlan::roots).
template <class S>
void make_lu() {
  constexpr int kRows = 4096;
  const Stream stream;
  DeviceLapack lapack(stream);
  const DeviceArena arena(Offset{kRows} * kRows * static_cast<Offset>(sizeof(S)));
  stream.clear(arena.at<S>(0), arena.bytes());
  lapack.reserve(kRows, arena.at<S>(0), kRows);
  lapack.getrf(kRows, arena.at<S>(0), kRows);
  stream.synchronize();
}

template <class Scalar>
std::future<void> load_library_once(bool with_lu) {
  static std::atomic<bool> begun{false}, begun_lu{false};
  const bool product = !begun.exchange(true), lu = with_lu && !begun_lu.exchange(true);
  if (!product && !lu) return {};
  try {
    return std::async(std::launch::async, [product, lu, device = current_device()] {
      using S = DeviceScalar<Scalar>;
      try {
        const OnDevice here(device);
        if (product) make_product<S>();
        if (lu) make_lu<S>();
      } catch (...) {  // the factorization will meet it, too
      }
    });
  } catch (const std::system_error&) {  // no thread: then later
    return {};
  }
}

}  // namespace

bool device_found() {
  return device_count() > 0;
}
void require_device() {
  if (!device_found()) throw BackendError("CUDA", 0, "no CUDA device was found");
  Engine::check_device();
}

std::vector<DeviceFacts> devices() {
  std::vector<DeviceFacts> found;
  for (int device = 0; device < device_count(); ++device) {
    const OnDevice here(device);
    const DeviceCode code = device_code();
    const int memory = shared_memory_per_block();
    const DeviceLimits limits = limits_for<double>(multiprocessors(), static_cast<std::size_t>(memory));
    found.push_back({device_name(), compute_capability(), code.compute_capability, multiprocessors(),
                     device_memory(), memory, code.tensor_cores, single_to_double(), limits.tile,
                     limits.small_rows});
  }
  return found;
}
int speed_of_single() {
  return device_found() ? single_to_double() : 1;
}

std::size_t available_device_memory() {
  return static_cast<std::size_t>(free_memory());
}

template <class Value>
std::future<void> load_library(bool single_precision, const Pattern& pattern) {
  constexpr Offset kLarge = 1000000;
  // Few have factors as large as it takes with fewer unknowns; and their analysis is not over before.
  constexpr Vertex kManyUnknowns = 100000;
  if (pattern.nnz() < kLarge) return {};
  const bool with_lu = pattern.n >= kManyUnknowns;
  return single_precision ? load_library_once<Narrow<Value>>(with_lu) : load_library_once<Value>(with_lu);
}

template <class Value>
Planned<Factors<Value>> plan_cuda_factors(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                          std::shared_ptr<const Pattern> pattern, const DeviceRoom& room) {
  Planned<Factors<Value>> planned = single_precision ? plan_factors<Value, Narrow<Value>>(plan, pattern, room)
                                                     : plan_factors<Value, Value>(plan, pattern, room);
  planned.make = [make = planned.make] {
    Engine::use_cuda();
    return make();
  };
  return planned;
}

#define MFS_INSTANTIATE(Value)                                          \
  template std::future<void> load_library<Value>(bool, const Pattern&); \
  template Planned<Factors<Value>> plan_cuda_factors<Value>(            \
      bool, std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, const DeviceRoom&);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::cuda
