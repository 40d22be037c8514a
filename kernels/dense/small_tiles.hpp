// What the small kernels are made of, for one kind of vector register. Complex numbers are pairs of real ones
// here: a column of m complex numbers is one of 2m real ones, and a product with b is a sum of two with real
// factors, one of them turned by i:
//
//      a b  =  a Re(b)  +  i (a Im(b))        turned(x, y) = (-y, x)
//
// so a tile of kColumns complex columns is one of 2 kColumns real ones until its end. The functions are
// inlined into callers that are compiled for one kind of processor (small_kernels.cpp); they pass no vector
// by value.
#pragma once

#include <algorithm>

#include "kernels/dense/simd_register.hpp"
#include "kernels/dense/small_kernels.hpp"

namespace mfs::small {

/// kBytes: of a vector register. A tile takes three quarters of the registers (half of those of 16 bytes),
/// and the column of A and the factor from B find room beside it.
template <class Scalar, int kBytes>
struct Tiles : Register<Scalar, kBytes> {
  using Base = Register<Scalar, kBytes>;
  using Base::kLanes, Base::kParts, Base::kRows, Base::load, Base::multiply, Base::store, Base::subtract,
      Base::turn;
  using typename Base::Places;
  using typename Base::Real;
  using typename Base::Vector;
  /// Registers that a tile is high, real columns that it is wide.
  static constexpr int kHigh = kBytes > 16 ? 3 : 2, kWide = kBytes == 64 ? 8 : 4;
  /// A tile of a matrix: high registers of rows, `wide` columns of Scalar.
  template <int high, int wide>
  struct Tile {
    Vector at[wide][high];
  };

  /// tile = C - A B, with A from its first row in the tile on, B and C from their first column.
  template <int high, int wide>
  static MFS_INLINE void subtract_product(Vertex k, const Real* a, Offset lda, const Real* b, Offset ldb,
                                          const Real* c, Offset ldc, Tile<high, wide>& tile) {
    Vector sum[wide * kParts][high];
#pragma GCC unroll 16
    for (int j = 0; j < wide * kParts; ++j) {
#pragma GCC unroll 4
      for (int i = 0; i < high; ++i) sum[j][i] = Vector{};
    }
    for (Vertex p = 0; p < k; ++p) {
      Vector column[high];
#pragma GCC unroll 4
      for (int i = 0; i < high; ++i) load(a + i * kLanes, column[i]);
#pragma GCC unroll 16
      for (int j = 0; j < wide * kParts; ++j) {
        const Real factor = b[j / kParts * (kParts * ldb) + j % kParts];
#pragma GCC unroll 4
        for (int i = 0; i < high; ++i) sum[j][i] += column[i] * factor;
      }
      a += kParts * lda;
      b += kParts;
    }
#pragma GCC unroll 16
    for (int j = 0; j < wide; ++j) {
#pragma GCC unroll 4
      for (int i = 0; i < high; ++i) {
        load(c + j * kParts * ldc + i * kLanes, tile.at[j][i]);
        tile.at[j][i] -= sum[j * kParts][i];
        if constexpr (kParts == 2) {
          Vector turned;
          turn(sum[j * kParts + 1][i], turned);
          tile.at[j][i] -= turned;
        }
      }
    }
  }
  /// Lanes of the last register of a matrix whose rows are no multiple of one: it lies so that it ends with
  /// them, and the first of its rows, which another register has done, stay as they are. From the last row to
  /// the first it is the other way round.
  struct Window {
    Places writes;  // all bits of the lanes that are to be written
  };
  static MFS_INLINE void make_window(Vertex first, Vertex last, Window& window) {
    for (int i = 0; i < kLanes; ++i) window.writes[i] = i >= first * kParts && i < last * kParts ? -1 : 0;
  }
  template <int high, int wide>
  static MFS_INLINE void store_tile(const Tile<high, wide>& tile, const Window* window, Real* c, Offset ldc) {
#pragma GCC unroll 16
    for (int j = 0; j < wide; ++j, c += kParts * ldc) {
      if (high == 1 && window != nullptr) {
        Vector before;
        load(c, before);
        const Places bits = (reinterpret_cast<Places>(tile.at[j][0]) & window->writes) |
                            (reinterpret_cast<Places>(before) & ~window->writes);
        store(reinterpret_cast<Vector>(bits), c);
      } else {
#pragma GCC unroll 4
        for (int i = 0; i < high; ++i) store(tile.at[j][i], c + i * kLanes);
      }
    }
  }

  static constexpr int kWidest = kWide / kParts;

  // One row of tiles of a product: all of its columns, the widest tiles first.
  template <int high, int wide>
  static MFS_INLINE void product_columns(Vertex j, Vertex n, Vertex k, const Real* a, Offset lda,
                                         const Real* b, Offset ldb, const Window* window, Real* c,
                                         Offset ldc) {
    for (; j + wide <= n; j += wide) {
      Tile<high, wide> tile;
      subtract_product(k, a, lda, b + j * kParts * ldb, ldb, c + j * kParts * ldc, ldc, tile);
      store_tile(tile, window, c + j * kParts * ldc, ldc);
    }
    if constexpr (wide > 1) product_columns<high, wide / 2>(j, n, k, a, lda, b, ldb, window, c, ldc);
  }

  // The same of a solve from the right.
  template <int high, int wide>
  static MFS_INLINE void right_columns(Vertex j, Vertex n, const Real* u, Offset ldu, const Real* inverse,
                                       const Window* window, Real* b, Offset ldb) {
    for (; j + wide <= n; j += wide) {
      Tile<high, wide> tile;
      Real* const here = b + j * kParts * ldb;
      const Real* const above = u + j * kParts * ldu;
      subtract_product(j, b, ldb, above, ldu, here, ldb, tile);
#pragma GCC unroll 16
      for (int c = 0; c < wide; ++c) {
#pragma GCC unroll 4
        for (int i = 0; i < high; ++i) multiply(inverse + (j + c) * kParts, tile.at[c][i]);
#pragma GCC unroll 16
        for (int right = c + 1; right < wide; ++right) {
#pragma GCC unroll 4
          for (int i = 0; i < high; ++i)
            subtract(tile.at[c][i], above + (right * ldu + j + c) * kParts, tile.at[right][i]);
        }
      }
      store_tile(tile, window, here, ldb);
    }
    if constexpr (wide > 1) right_columns<high, wide / 2>(j, n, u, ldu, inverse, window, b, ldb);
  }

  /// The columns of a triangle of one register's rows without the diagonal, zeros on its other side; turned
  /// ones, too, where numbers are complex.
  struct Triangle {
    Vertex first, last;  // others are none
    Vector column[kRows][kParts];
  };
  /// The lower or upper triangle of rows and columns [first, last); t: (0, 0).
  template <bool upper>
  static MFS_INLINE void read_triangle(Vertex first, Vertex last, const Real* t, Offset ldt,
                                       Triangle& triangle) {
    triangle.first = first;
    triangle.last = last;
    for (int c = 0; c < kRows; ++c) {
      Real held[kLanes] = {};
      if (c >= first && c < last) {
        const int begin = upper ? 0 : (c + 1) * kParts, end = upper ? c * kParts : kLanes;
        for (int i = begin; i < end; ++i) held[i] = t[c * kParts * ldt + i];
      }
      load(held, triangle.column[c][0]);
      if constexpr (kParts == 2) turn(triangle.column[c][0], triangle.column[c][1]);
    }
  }
  /// Rows of one register of a solve from the left, `solved` rows being solved for; x: the first of these.
  /// `inverse` of the diagonal, which is one where the triangle is not `upper`.
  template <bool upper, int wide>
  static MFS_INLINE void left_columns(Vertex j, Vertex columns, Vertex solved, const Real* a, Offset lda,
                                      const Triangle& triangle, const Real* inverse, const Window* window,
                                      const Real* x, Offset ldx, Real* b, Offset ldb) {
    for (; j + wide <= columns; j += wide) {
      Tile<1, wide> tile;
      subtract_product(solved, a, lda, x + j * kParts * ldx, ldx, b + j * kParts * ldb, ldb, tile);
#pragma GCC unroll 16
      for (int turn = 0; turn < (upper ? kRows : kRows - 1); ++turn) {
        const int c = upper ? kRows - 1 - turn : turn;
        if (c < triangle.first || c >= triangle.last) continue;
#pragma GCC unroll 16
        for (int right = 0; right < wide; ++right) {
          Vector found = tile.at[right][0];
          if constexpr (upper) multiply(inverse + c * kParts, found);
#pragma GCC unroll 2
          for (int part = 0; part < kParts; ++part) {
            tile.at[right][0] -= triangle.column[c][part] * found[c * kParts + part];
            if constexpr (upper) tile.at[right][0][c * kParts + part] = found[c * kParts + part];
          }
        }
      }
      store_tile(tile, window, b + j * kParts * ldb, ldb);
    }
    if constexpr (wide > 1)
      left_columns<upper, wide / 2>(j, columns, solved, a, lda, triangle, inverse, window, x, ldx, b, ldb);
  }

  /// Fewer rows than a register has, with zeros behind them, and back.
  static MFS_INLINE void hold(Vertex rows, Vertex columns, const Real* from, Offset ld, Real* to) {
    for (Vertex j = 0; j < columns; ++j, from += kParts * ld, to += kLanes) {
      int i = 0;
      for (; i < rows * kParts; ++i) to[i] = from[i];
      for (; i < kLanes; ++i) to[i] = 0;
    }
  }
  static MFS_INLINE void give_back(Vertex rows, Vertex columns, const Real* from, Real* to, Offset ld) {
    for (Vertex j = 0; j < columns; ++j, from += kLanes, to += kParts * ld) {
      for (int i = 0; i < rows * kParts; ++i) to[i] = from[i];
    }
  }

  static MFS_INLINE void gemm_minus(Vertex m, Vertex n, Vertex k, const Real* a, Offset lda, const Real* b,
                                    Offset ldb, Real* c, Offset ldc) {
    for (Vertex p = 0; p < k; p += kMost)
      subtract_terms(m, n, std::min(kMost, k - p), a + p * kParts * lda, lda, b + p * kParts, ldb, c, ldc);
  }
  // The same of at most kMost terms.
  static MFS_INLINE void subtract_terms(Vertex m, Vertex n, Vertex k, const Real* a, Offset lda,
                                        const Real* b, Offset ldb, Real* c, Offset ldc) {
    if (m < kRows) {
      alignas(64) Real held_a[kMost * kLanes], held_c[kMost * kLanes];
      hold(m, k, a, lda, held_a);
      hold(m, n, c, ldc, held_c);
      product_columns<1, kWidest>(0, n, k, held_a, kRows, b, ldb, nullptr, held_c, kRows);
      return give_back(m, n, held_c, c, ldc);
    }
    Vertex i = 0;
    for (; i + kHigh * kRows <= m; i += kHigh * kRows)
      product_columns<kHigh, kWidest>(0, n, k, a + i * kParts, lda, b, ldb, nullptr, c + i * kParts, ldc);
    while (i < m) {  // one whole register, or the window at the end, or both
      const Vertex begin = std::min(i, m - kRows);
      Window window;
      make_window(i - begin, kRows, window);
      product_columns<1, kWidest>(0, n, k, a + begin * kParts, lda, b, ldb, &window, c + begin * kParts, ldc);
      i = begin + kRows;
    }
  }

  /// Columns of B that are solved for together, so that they stay in the first cache.
  static constexpr Vertex kColumns = 32;
  /// B := T^-1 B for the upper triangle of T, by the `inverse` of its diagonal, or the unit lower one.
  template <bool upper>
  static MFS_INLINE void solve_left(Vertex n, Vertex columns, const Real* t, Offset ldt, const Real* inverse,
                                    Real* b, Offset ldb) {
    constexpr int wide = std::min(8 / kParts, kWidest);
    Triangle triangle;
    if (n < kRows) {
      alignas(64) Real held_t[kRows * kLanes], held_b[kColumns * kLanes];
      hold(n, n, t, ldt, held_t);
      read_triangle<upper>(0, n, held_t, kRows, triangle);
      for (Vertex j = 0; j < columns; j += kColumns, b += kColumns * kParts * ldb) {
        const Vertex count = std::min(kColumns, columns - j);
        hold(n, count, b, ldb, held_b);
        left_columns<upper, wide>(0, count, 0, held_t, kRows, triangle, inverse, nullptr, held_b, kRows,
                                  held_b, kRows);
        give_back(n, count, held_b, b, ldb);
      }
      return;
    }
    for (Vertex j = 0; j < columns; j += kColumns, b += kColumns * kParts * ldb) {
      for (Vertex done = 0; done < n;) {  // the first rows, or the last
        const Vertex begin = upper ? std::max(n - done - kRows, 0) : std::min(done, n - kRows);
        const Vertex first = upper ? 0 : done - begin, last = upper ? n - done - begin : kRows;
        const Vertex solved = upper ? n - done : 0;
        Window window;
        make_window(first, last, window);
        read_triangle<upper>(first, last, t + (begin + begin * ldt) * kParts, ldt, triangle);
        left_columns<upper, wide>(0, std::min(kColumns, columns - j), done,
                                  t + (begin + solved * ldt) * kParts, ldt, triangle,
                                  upper ? inverse + begin * kParts : nullptr, &window, b + solved * kParts,
                                  ldb, b + begin * kParts, ldb);
        done += last - first;
      }
    }
  }

  static MFS_INLINE void solve_upper_right(Vertex rows, Vertex n, const Real* u, Offset ldu,
                                           const Real* inverse, Real* b, Offset ldb) {
    if (rows < kRows) {
      alignas(64) Real held[kMost * kLanes];
      hold(rows, n, b, ldb, held);
      right_columns<1, kWidest>(0, n, u, ldu, inverse, nullptr, held, kRows);
      return give_back(rows, n, held, b, ldb);
    }
    Vertex i = 0;
    for (; i + kHigh * kRows <= rows; i += kHigh * kRows)
      right_columns<kHigh, kWidest>(0, n, u, ldu, inverse, nullptr, b + i * kParts, ldb);
    while (i < rows) {
      const Vertex begin = std::min(i, rows - kRows);
      Window window;
      make_window(i - begin, kRows, window);
      right_columns<1, kWidest>(0, n, u, ldu, inverse, &window, b + begin * kParts, ldb);
      i = begin + kRows;
    }
  }
};

}  // namespace mfs::small
