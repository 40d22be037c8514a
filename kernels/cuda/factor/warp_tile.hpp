// Matrix products of one warp on tiles in shared memory: the FP64 tensor cores (DMMA) for double where the
// architecture has fast ones, plain multiply-adds elsewhere and for the other kinds of number. Both leave the
// sums with the same lanes.
//
//   lane l, g = l / 4, t = l % 4, holds of each 16 x 8 tile   (g, 2t) (g, 2t+1) (g+8, 2t) (g+8, 2t+1)
//
// Operands are column-major; leading dimensions of 4 modulo 16 keep the reads of doubles free of bank
// conflicts. Source of the fragment layout: PTX ISA, "Matrix fragments for mma.m16n8k8 with .f64" and
// "mma.m8n8k4 with .f64", four of which are one of the former.
#pragma once

#include <type_traits>

#include "kernels/cuda/runtime/device_scalar.hpp"

namespace mfs::cuda {

constexpr int kWarp = 32;

/// Whether double precision goes to tensor cores: those of compute capability 8.0, 9.0, 10.x are twice as
/// fast as the other units; elsewhere (8.6, 8.9, 12.x) both have 1/64 of the speed of single precision.
/// `architecture` as __CUDA_ARCH__ has it, 0 in host code.
constexpr bool has_tensor_cores(int architecture) {
  return architecture == 800 || architecture / 100 == 9 || architecture / 100 == 10;
}
#ifdef __CUDA_ARCH__
constexpr bool kTensorCores = has_tensor_cores(__CUDA_ARCH__);
#else
constexpr bool kTensorCores = false;
#endif

/// Leading dimension for `rows` rows of a tile in shared memory.
__host__ __device__ constexpr int tile_ld(int rows) {
  return (rows + 15) / 16 * 16 + 4;
}

/// The sums of MT x NT tiles of 16 x 8.
template <class S, int MT, int NT>
struct WarpTile {
  S sum[MT][NT][4];

  __device__ void clear() {
    for_each([](int, int, S& value) { value = S(0); });
  }

  /// sum += A (16 MT x depth) B (depth x 8 NT), depth a multiple of 8; A(m, k) lies at a[m * am + k * ak],
  /// B(k, n) at b[k * bk + n * bn]. To subtract a product, keep the sums negated: that costs nothing in here.
  __device__ void multiply(const S* a, int am, int ak, const S* b, int bk, int bn, int depth) {
    multiply_entries([=](int m, int k) { return a[m * am + k * ak]; }, b, bk, bn, depth);
  }
  /// The same where A(m, k) = a(m, k).
  template <class Entry>
  __device__ void multiply_entries(const Entry& a, const S* b, int bk, int bn, int depth) {
    multiply_entries(
        a, [=](int k, int n) { return b[k * bk + n * bn]; }, depth);
  }
  /// The same where also B(k, n) = b(k, n).
  template <class Left, class Right>
  __device__ void multiply_entries(const Left& a, const Right& b, int depth) {
    const int lane = threadIdx.x % kWarp, g = lane / 4, t = lane % 4;
    if constexpr (std::is_same_v<S, double> && kTensorCores) {
      for (int k = 0; k < depth; k += 8) {
        double left[MT][4], right[NT][2];
#pragma unroll
        for (int i = 0; i < MT; ++i) {
#pragma unroll
          for (int v = 0; v < 4; ++v) left[i][v] = a(16 * i + g + 8 * (v % 2), k + t + 4 * (v / 2));
        }
#pragma unroll
        for (int j = 0; j < NT; ++j) {
#pragma unroll
          for (int v = 0; v < 2; ++v) right[j][v] = b(k + t + 4 * v, 8 * j + g);
        }
#pragma unroll
        for (int i = 0; i < MT; ++i) {
#pragma unroll
          for (int j = 0; j < NT; ++j) multiply_add(sum[i][j], left[i], right[j]);
        }
      }
    } else {
      for (int k = 0; k < depth; ++k) {
        S left[MT][2], right[NT][2];
#pragma unroll
        for (int i = 0; i < MT; ++i) {
#pragma unroll
          for (int v = 0; v < 2; ++v) left[i][v] = a(16 * i + g + 8 * v, k);
        }
#pragma unroll
        for (int j = 0; j < NT; ++j) {
#pragma unroll
          for (int v = 0; v < 2; ++v) right[j][v] = b(k, 8 * j + 2 * t + v);
        }
#pragma unroll
        for (int i = 0; i < MT; ++i) {
#pragma unroll
          for (int j = 0; j < NT; ++j) {
#pragma unroll
            for (int v = 0; v < 4; ++v) sum[i][j][v] += left[i][v / 2] * right[j][v % 2];
          }
        }
      }
    }
  }

  /// Calls body(row, column, sum) for what this lane holds.
  template <class Body>
  __device__ void for_each(const Body& body) {
    const int lane = threadIdx.x % kWarp, g = lane / 4, t = lane % 4;
#pragma unroll
    for (int i = 0; i < MT; ++i) {
#pragma unroll
      for (int j = 0; j < NT; ++j) {
#pragma unroll
        for (int v = 0; v < 4; ++v) body(16 * i + g + 8 * (v / 2), 8 * j + 2 * t + v % 2, sum[i][j][v]);
      }
    }
  }

 private:
  __device__ static void multiply_add(double (&c)[4], const double (&a)[4], const double (&b)[2]) {
#if __CUDA_ARCH__ >= 900
    asm("mma.sync.aligned.m16n8k8.row.col.f64.f64.f64.f64 {%0,%1,%2,%3}, {%4,%5,%6,%7}, {%8,%9}, "
        "{%0,%1,%2,%3};"
        : "+d"(c[0]), "+d"(c[1]), "+d"(c[2]), "+d"(c[3])
        : "d"(a[0]), "d"(a[1]), "d"(a[2]), "d"(a[3]), "d"(b[0]), "d"(b[1]));
#else
#pragma unroll
    for (int half = 0; half < 2; ++half) {  // rows g and g + 8
#pragma unroll
      for (int k = 0; k < 2; ++k)           // t and t + 4
        asm("mma.sync.aligned.m8n8k4.row.col.f64.f64.f64.f64 {%0,%1}, {%2}, {%3}, {%0,%1};"
            : "+d"(c[2 * half]), "+d"(c[2 * half + 1])
            : "d"(a[half + 2 * k]), "d"(b[k]));
    }
#endif
  }
};

}  // namespace mfs::cuda
