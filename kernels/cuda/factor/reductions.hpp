// Maxima over the rows of the matrix or over a vector: what their kernels share, and the one that a
// factorization begins with. A few lanes share a row, so that its entries are read together.
#pragma once

#include <algorithm>
#include <type_traits>

#include "kernels/cuda/factor/warp_tile.hpp"
#include "kernels/cuda/runtime/device_scalar.hpp"
#include "kernels/stages/front_store.hpp"

namespace mfs::cuda {

constexpr int kVectorThreads = 256;
/// Lanes that share a row of the matrix, the second number where rows have at least kLongRow entries on
/// average.
constexpr int kRowLanes = 8, kLongRowLanes = 32, kLongRow = 24;
/// Blocks that a reduction is shared by: what they add up to meets in one place, which takes about 1 ns of
/// each warp.
constexpr unsigned kMostReducingBlocks = 1024;

/// Blocks of kVectorThreads.
inline unsigned vector_blocks(Offset threads) {
  return static_cast<unsigned>((threads + kVectorThreads - 1) / kVectorThreads);
}
inline unsigned reducing_blocks(Offset threads) {
  return std::min(vector_blocks(threads), kMostReducingBlocks);
}
/// Calls work with the number of lanes for a row as a constant.
template <class Work>
void with_row_lanes(Offset rows, Offset entries, const Work& work) {
  if (entries >= kLongRow * rows) {
    work(std::integral_constant<int, kLongRowLanes>());
  } else {
    work(std::integral_constant<int, kRowLanes>());
  }
}

// Numbers that are not negative have the same order as unsigned integers.
__device__ inline unsigned long long order_of(double value) {
  return static_cast<unsigned long long>(__double_as_longlong(value));
}

// The largest of all threads' values, none of them negative or NaN.
__device__ inline void raise_to(double* largest, double value) {
#pragma unroll
  for (int step = kWarp / 2; step > 0; step /= 2)
    value = fmax(value, __shfl_xor_sync(0xffffffffu, value, step));
  if (threadIdx.x % kWarp == 0 && value > 0) {
    atomicMax(reinterpret_cast<unsigned long long*>(largest), order_of(value));
  }
}

/// *largest = the largest |a_ij| row_scale[i] column_scale[j], as kernels/stages/vector_ops.hpp has it for
/// the host; zero before. Any number of blocks.
template <int Lanes, class S, class V>
__global__ void __launch_bounds__(kVectorThreads)
    largest_entry_by_rows(FrontStore<S, V> at, double* largest) {
  constexpr int kRows = kVectorThreads / Lanes;
  const int lane = threadIdx.x % Lanes;
  const Offset stride = gridDim.x * static_cast<Offset>(kRows);
  double most = 0;
  for (Offset row = blockIdx.x * static_cast<Offset>(kRows) + threadIdx.x / Lanes; row < at.n;
       row += stride) {
    const double row_scale = at.row_scale[row];
    const Offset end = at.matrix_offsets[row + 1];
#pragma unroll 4
    for (Offset k = at.matrix_offsets[row] + lane; k < end; k += Lanes) {
      const double scale = row_scale * at.column_scale[at.matrix_columns[k]];
      most = fmax(most, magnitude(at.matrix_values[k]) * scale);
    }
  }
  raise_to(largest, most);
}

}  // namespace mfs::cuda
