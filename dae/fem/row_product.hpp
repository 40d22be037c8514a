// out = left^T right, where left and right are k rows of equal stride: the sum over the rows that every
// stiffness matrix is. Done in tiles whose sums stay in registers.
#pragma once

#include "dae/fem/element_points.hpp"

namespace mfs::dae {

constexpr int kTileColumns = 8;

template <int tile_rows, int stride>
MFS_INLINE void product_tile(int k, const double* left, const double* right, double* out) {
  double sum[tile_rows][kTileColumns] = {};
  for (int row = 0; row < k; ++row) {
#pragma GCC unroll 6
    for (int r = 0; r < tile_rows; ++r)
      for (int c = 0; c < kTileColumns; ++c) sum[r][c] += left[row * stride + r] * right[row * stride + c];
  }
  for (int r = 0; r < tile_rows; ++r)
    for (int c = 0; c < kTileColumns; ++c) out[r * stride + c] = sum[r][c];
}

/// rows: of out, those used of its stride; a multiple of tile_rows. With `symmetric` only tiles that touch
/// the upper triangle are computed.
template <int tile_rows, int rows, int stride>
MFS_INLINE void row_product(int k, const double* left, const double* right, bool symmetric, double* out) {
  static_assert(rows % tile_rows == 0 && stride % kTileColumns == 0);
  for (int r = 0; r < rows; r += tile_rows)
    for (int c = 0; c < stride; c += kTileColumns)
      if (!symmetric || c + kTileColumns > r)
        product_tile<tile_rows, stride>(k, left + r, right + c, out + r * stride + c);
}

}  // namespace mfs::dae
