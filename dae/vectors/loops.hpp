// Passes over vectors of an executor, of one source for the host and the device. What is done with entry i is
// a functor that holds pointers to the executor's memory, marked MFS_HOST_DEVICE. In a build with CUDA, files
// that use these loops are compiled by nvcc (mfs_add_nvcc_sources). No sum depends on the number of threads;
// the device adds up in another order than the host.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "dae/vectors/executor.hpp"
#include "dae/vectors/host_loops.hpp"

#ifdef __CUDACC__
#include "dae/vectors/cuda/device_loops.hpp"
#define MFS_HOST_DEVICE __host__ __device__
#elif defined(MFS_VECTORS_CUDA)
#error "In this build nvcc has to compile what uses these loops: mfs_add_nvcc_sources"
#else
#define MFS_HOST_DEVICE
#endif

namespace mfs::dae {

/// f(i) for all i in 0 ... count - 1, which looks at `work` numbers in all (0: one each).
template <class F>
void for_each(const Executor& executor, std::size_t count, const F& f, std::size_t work = 0) {
#ifdef __CUDACC__
  if (executor.on_device()) return for_each_on_device(queue_of(executor), count, f);
#endif
  parallel_for(count, executor.threads(), f, work);
}

/// f(begin, end) for consecutive parts of 0 ... count - 1, on the host short enough to stay in a core's first
/// cache while one array after the other is read for them.
template <class F>
void for_parts(const Executor& executor, std::size_t count, const F& f) {
#ifdef __CUDACC__
  if (executor.on_device()) return for_each_on_device(queue_of(executor), count, PartOfOne<F>{f});
#endif
  parallel_for_parts(count, executor.threads(), f);
}

/// For each f of `functions` all f(i), put together by `combine`; `none` is what nothing comes to. Waits for
/// them.
template <class Value, class F, class Combine>
std::vector<Value> folds(const Executor& executor, std::size_t count, const Value& none,
                         const std::vector<F>& functions, const Combine& combine) {
  static_assert(std::is_trivially_copyable_v<Value> && sizeof(Value) <= DeviceQueue::kMostFolded);
#ifdef __CUDACC__
  if (executor.on_device()) return folds_on_device(queue_of(executor), count, none, functions, combine);
#endif
  std::vector<Value> all;
  for (const F& f : functions) all.push_back(parallel_fold(count, executor.threads(), none, f, combine));
  return all;
}

/// Of one function.
template <class Value, class F, class Combine>
Value fold(const Executor& executor, std::size_t count, const Value& none, const F& f,
           const Combine& combine) {
  if (executor.on_device()) return folds(executor, count, none, std::vector<F>{f}, combine).front();
  return parallel_fold(count, executor.threads(), none, f, combine);
}

/// A few numbers side by side. Nothing is set, so that blocks of threads may share some.
template <std::size_t count>
struct Numbers {
  double of[count];
};

struct Sum {
  MFS_HOST_DEVICE double operator()(double a, double b) const { return a + b; }
  template <std::size_t count>
  MFS_HOST_DEVICE Numbers<count> operator()(Numbers<count> a, const Numbers<count>& b) const {
    for (std::size_t k = 0; k < count; ++k) a.of[k] += b.of[k];
    return a;
  }
};

template <std::size_t count, class Errors>
struct WeightedSquares {
  Errors errors;
  const double* weights;
  MFS_HOST_DEVICE Numbers<count> operator()(std::size_t i) const {
    Numbers<count> squares = errors(i);
    for (double& value : squares.of) {
      value /= weights[i];
      value *= value;
    }
    return squares;
  }
};

/// Roots of the means of (e(i).of[k] / w_i)^2: 1 is what the user's tolerances allow. e is called once for
/// each i.
template <std::size_t count, class Errors>
Numbers<count> weighted_rms(const Executor& executor, const Errors& e, const Array<double>& weights) {
  Numbers<count> sums = fold(executor, weights.size(), Numbers<count>{},
                             WeightedSquares<count, Errors>{e, weights.data()}, Sum{});
  for (double& sum : sums.of)
    sum = weights.size() == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(weights.size()));
  return sums;
}

}  // namespace mfs::dae
