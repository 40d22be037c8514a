// The loops of loops.hpp on a device. Sums by blocks of threads, each over a fixed part of the indices, then
// over the blocks in order by the host.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dae/vectors/cuda/cuda_queue.hpp"

namespace mfs::dae {

constexpr int kLoopThreads = 256;

template <class F>
__global__ void __launch_bounds__(kLoopThreads) visit_all(std::int64_t count, F f) {
  const std::int64_t i = static_cast<std::int64_t>(blockIdx.x) * kLoopThreads + threadIdx.x;
  if (i < count) f(static_cast<std::size_t>(i));
}

template <class F>
void for_each_on_device(const CudaQueue& queue, std::size_t count, const F& f) {
  if (count == 0) return;
  const auto n = static_cast<std::int64_t>(count);
  visit_all<<<static_cast<unsigned>((n + kLoopThreads - 1) / kLoopThreads), kLoopThreads, 0,
              queue.work.get()>>>(n, f);
  cuda::check_launch("visit_all");
}

/// Parts of one index each.
template <class F>
struct PartOfOne {
  F f;
  __host__ __device__ void operator()(std::size_t i) const { f(i, i + 1); }
};

template <class Value, class F, class Combine>
__global__ void __launch_bounds__(kLoopThreads)
    fold_parts(std::int64_t count, Value none, F f, Combine combine, Value* folded) {
  __shared__ Value of_thread[kLoopThreads];
  Value value = none;
  const std::int64_t all = static_cast<std::int64_t>(gridDim.x) * kLoopThreads;
  for (std::int64_t i = static_cast<std::int64_t>(blockIdx.x) * kLoopThreads + threadIdx.x; i < count;
       i += all)
    value = combine(value, f(static_cast<std::size_t>(i)));
  of_thread[threadIdx.x] = value;
  for (int half = kLoopThreads / 2; half > 0; half /= 2) {
    __syncthreads();
    if (static_cast<int>(threadIdx.x) < half)
      of_thread[threadIdx.x] = combine(of_thread[threadIdx.x], of_thread[threadIdx.x + half]);
  }
  if (threadIdx.x == 0) folded[blockIdx.x] = of_thread[0];
}

/// All that `functions` come to, each as by itself: the host waits once for some of them at a time.
template <class Value, class F, class Combine>
std::vector<Value> folds_on_device(const CudaQueue& queue, std::size_t count, const Value& none,
                                   const std::vector<F>& functions, const Combine& combine) {
  const auto n = static_cast<std::int64_t>(count);
  const auto blocks =
      static_cast<int>(std::min<std::int64_t>(CudaQueue::kFoldBlocks, (n + kLoopThreads - 1) / kLoopThreads));
  std::vector<Value> all(functions.size(), none);
  if (blocks == 0) return all;
  Value* const folded = queue.folded.at<Value>(0);
  for (std::size_t first = 0; first < functions.size(); first += CudaQueue::kFoldsAtOnce) {
    const std::size_t end = std::min(functions.size(), first + CudaQueue::kFoldsAtOnce);
    for (std::size_t k = first; k < end; ++k) {
      fold_parts<<<static_cast<unsigned>(blocks), kLoopThreads, 0, queue.work.get()>>>(
          n, none, functions[k], combine, folded + (k - first) * static_cast<std::size_t>(blocks));
      cuda::check_launch("fold_parts");
    }
    queue.work.synchronize();
    const Value* next = folded;
    for (std::size_t k = first; k < end; ++k)
      for (int b = 0; b < blocks; ++b) all[k] = combine(all[k], *next++);
  }
  return all;
}

}  // namespace mfs::dae
