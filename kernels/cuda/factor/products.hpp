// C -= A B for many products of different sizes in one launch, tile by tile: what the steps of "variable
// factor" leave, and the stage "variable update". Operands stream through shared memory by asynchronous
// copies, some stages ahead; the sums are made on the tensor cores.
#pragma once

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/warp_tile.hpp"
#include "kernels/cuda/runtime/async_copy.hpp"

namespace mfs::cuda {

/// Shape of a block: WM x WN warps, each with MT x NT tiles of 16 x 8.
template <int WM_, int WN_, int MT_, int NT_, int Stages>
struct ProductShape {
  static constexpr int WM = WM_, WN = WN_, MT = MT_, NT = NT_;
  static constexpr int rows = WM * MT * 16, columns = WN * NT * 8, threads = WM * WN * kWarp;
  static constexpr int depth = 16, stages = Stages;
  static constexpr int lda = rows + 4, ldb = depth + 4;
  template <class S>
  static constexpr std::size_t bytes() {
    return sizeof(S) * stages * (lda * depth + ldb * columns);
  }
};
using NarrowShape = ProductShape<2, 2, 2, 4, 3>;  // 64 x 64
using ShortShape = ProductShape<2, 2, 2, 4, 2>;   // the same in less shared memory
using WideShape = ProductShape<2, 2, 4, 4, 3>;    // 128 x 64; complex<double> has no registers for it
template <class S>
constexpr bool kWideProducts = sizeof(S) <= 8;
/// Whether NarrowShape takes more than some devices have.
template <class S>
constexpr bool kShortProducts = NarrowShape::bytes<S>() > kLeastSharedMemory;
/// Calls work with the shape of a launch.
template <class S, class Work>
void with_product_shape(bool wide, bool short_of_memory, const Work& work) {
  if constexpr (kWideProducts<S>) {
    if (wide) return work(WideShape());
  }
  if constexpr (kShortProducts<S>) {
    if (short_of_memory) return work(ShortShape());
  }
  work(NarrowShape());
}

// Tiles go down bands of kBand rows of tiles: the blocks that run together then share A and B in the cache.
__device__ inline int2 tile_place(int row_tiles, int column_tiles, int tile) {
  constexpr int kBand = 16;
  const int band = tile / (kBand * column_tiles), height = min(kBand, row_tiles - band * kBand);
  const int inside = tile - band * kBand * column_tiles;
  return {band * kBand + inside % height, inside / height};
}

template <class Shape, class S, class Value>
__global__ void __launch_bounds__(Shape::threads)
    subtract_products(DeviceStore<S, Value> store, Offset first, int count) {
  extern __shared__ __align__(16) unsigned char memory[];
  S* const shared = reinterpret_cast<S*>(memory);
  const ProductTask& task =
      store.products[first + find_task(store.products + first, count, &ProductTask::first_tile, blockIdx.x)];
  const int m = task.m, n = task.n, depth = task.k;
  const Offset lda = task.lda, ldb = task.ldb, ldc = task.ldc;
  const int2 place =
      tile_place((m + Shape::rows - 1) / Shape::rows, (n + Shape::columns - 1) / Shape::columns,
                 static_cast<int>(blockIdx.x) - task.first_tile);
  const int row = place.x * Shape::rows, column = place.y * Shape::columns;
  const S* const a = store.fronts.storage + task.a + row;
  const S* const b = store.fronts.storage + task.b + column * ldb;
  const int rows = m - row, columns = n - column;
  constexpr int kStageEntries = Shape::lda * Shape::depth + Shape::ldb * Shape::columns;

  // A thread copies one row of A and one row of B, some columns apart; inside the matrix without a question.
  constexpr int kStepA = Shape::threads / Shape::rows, kStepB = Shape::threads / Shape::depth;
  constexpr unsigned kBytes = sizeof(S);
  const int row_a = threadIdx.x % Shape::rows, column_a = threadIdx.x / Shape::rows;
  const int row_b = threadIdx.x % Shape::depth, column_b = threadIdx.x / Shape::depth;
  const S* const from_a = a + min(row_a, rows - 1) + column_a * lda;
  const S* const from_b = b + min(column_b, columns - 1) * ldb + row_b;
  const unsigned to_a = shared_address(shared + row_a + column_a * Shape::lda);
  const unsigned to_b = shared_address(shared + Shape::lda * Shape::depth + row_b + column_b * Shape::ldb);
  const bool interior = rows >= Shape::rows && columns >= Shape::columns;
  const auto load = [&](int k, int stage) {
    const S* pa = from_a + k * lda;
    const S* pb = from_b + k;
    const unsigned sa = to_a + stage * (kStageEntries * kBytes), sb = to_b + stage * (kStageEntries * kBytes);
    if (interior && k + Shape::depth <= depth) {
#pragma unroll
      for (int i = 0; i < Shape::depth; i += kStepA, pa += kStepA * lda)
        copy_async<kBytes>(sa + i * Shape::lda * kBytes, pa);
#pragma unroll
      for (int i = 0; i < Shape::columns; i += kStepB, pb += kStepB * ldb)
        copy_async<kBytes>(sb + i * Shape::ldb * kBytes, pb);
    } else {
#pragma unroll
      for (int i = 0; i < Shape::depth; i += kStepA, pa += kStepA * lda)
        copy_async<kBytes>(sa + i * Shape::lda * kBytes, pa, row_a < rows && k + column_a + i < depth);
#pragma unroll
      for (int i = 0; i < Shape::columns; i += kStepB, pb += kStepB * ldb)
        copy_async<kBytes>(sb + i * Shape::ldb * kBytes, pb, column_b + i < columns && k + row_b < depth);
    }
  };

  const int warp = threadIdx.x / kWarp;
  const int m0 = warp % Shape::WM * Shape::MT * 16, n0 = warp / Shape::WM * Shape::NT * 8;
  S* const c = store.fronts.storage + task.c + row + column * ldc;
  WarpTile<S, Shape::MT, Shape::NT> product;
  const int steps = (depth + Shape::depth - 1) / Shape::depth;
#pragma unroll
  for (int s = 0; s < Shape::stages - 1; ++s) {
    if (s < steps) load(s * Shape::depth, s);
    commit_copies();
  }
  // All of C is asked for before the first of it is needed.
  product.for_each([&](int i, int j, S& sum) {
    sum = m0 + i < rows && n0 + j < columns ? -c[m0 + i + (n0 + j) * ldc] : S(0);
  });
  for (int s = 0; s < steps; ++s) {
    wait_copies<Shape::stages - 2>();
    __syncthreads();
    const int ahead = s + Shape::stages - 1;
    if (ahead < steps) load(ahead * Shape::depth, ahead % Shape::stages);
    commit_copies();
    const S* const sa = shared + s % Shape::stages * kStageEntries;
    product.multiply(sa + m0, 1, Shape::lda, sa + Shape::lda * Shape::depth + n0 * Shape::ldb, 1, Shape::ldb,
                     Shape::depth);
  }
  // The same places again, but not held in registers all the while.
  Offset stride = ldc;
  asm volatile("" : "+l"(stride));
  product.for_each([&](int i, int j, S& sum) {
    if (m0 + i < rows && n0 + j < columns) c[m0 + i + (n0 + j) * stride] = -sum;
  });
}

}  // namespace mfs::cuda
