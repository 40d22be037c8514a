// The two triangles of each 64 x 64 tile on the diagonal of a pivot block inverted as a whole, in place, from
// the inverses of their 32 x 32 blocks: one product for the solve instead of three that wait for each other.
// After everything that needs the blocks. U is left alone where it is substituted with.
//
//   [A  B]^-1   [A^-1  -A^-1 B C^-1]          [A   ]^-1   [A^-1              ]
//   [   C]    = [              C^-1]          [B  C]    = [-C^-1 B A^-1  C^-1]
#pragma once

#include "kernels/cuda/solve/solve_tile.hpp"

namespace mfs::cuda {

constexpr int kInverseThreads = 256;

template <class S>
struct TileInverseWork {
  static constexpr int kLd = kSolveTile + 1, kProductLd = kInverted + 1;
  S tile[kLd * kSolveTile];
  S product[2][kProductLd * kInverted];  // of the lower triangle, of the upper
};

template <class S, class Value>
__global__ void __launch_bounds__(kInverseThreads) invert_tiles(DeviceStore<S, Value> store) {
  extern __shared__ __align__(16) unsigned char memory[];
  TileInverseWork<S>& work = *reinterpret_cast<TileInverseWork<S>*>(memory);
  const FrontPart part = store.wide_tiles[blockIdx.x];
  const Front<S> front = store.fronts.front(part.front);
  const Offset ld = front.lower_ld;
  S* const at = front.lower + part.begin + part.column * ld;
  const int width = min(kSolveTile, front.pivots - part.begin), second = width - kInverted;
  constexpr int kLd = TileInverseWork<S>::kLd, kProductLd = TileInverseWork<S>::kProductLd;
  for (int i = threadIdx.x; i < kSolveTile * kSolveTile; i += kInverseThreads) {
    const int r = i % kSolveTile, c = i / kSolveTile;
    if (r < width && c < width) work.tile[r + c * kLd] = at[r + c * ld];
  }
  __syncthreads();
  const auto a = [&](int r, int c) { return work.tile[r + c * kLd]; };
  const auto b = [&](bool upper, int r, int c) { return upper ? a(r, kInverted + c) : a(kInverted + r, c); };
  const auto c_ = [&](int r, int c) { return a(kInverted + r, kInverted + c); };
  // Each triangle's block has a row and a column of the first 32 unknowns or of the `second` others.
  const auto for_each = [&](const auto& body) {
    for (int i = threadIdx.x; i < 2 * kInverted * kInverted; i += kInverseThreads) {
      const bool upper = i >= kInverted * kInverted;
      const int r = i % kInverted, c = i / kInverted % kInverted;
      if ((upper ? c : r) < second && !(upper && store.substitutes)) body(upper, r, c);
    }
  };
  for_each([&](bool upper, int r, int c) {  // B A^-1 of the lower, B C^-1 of the upper
    S sum = upper ? S(0) : b(false, r, c);
    for (int k = upper ? 0 : c + 1; k < (upper ? c + 1 : kInverted); ++k)
      sum += b(upper, r, k) * (upper ? c_(k, c) : a(k, c));
    work.product[upper][r + c * kProductLd] = sum;
  });
  __syncthreads();
  for_each([&](bool upper, int r, int c) {
    const auto product = [&](int k) { return work.product[upper][k + c * kProductLd]; };
    S sum = upper ? S(0) : product(r);
    for (int k = upper ? r : 0; k < (upper ? kInverted : r); ++k)
      sum += (upper ? a(r, k) : c_(r, k)) * product(k);
    at[upper ? r + (kInverted + c) * ld : kInverted + r + c * ld] = -sum;
  });
}

}  // namespace mfs::cuda
