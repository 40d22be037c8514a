// The block operations of a front on the host, in two forms with the same names: SequentialOps run on the
// calling thread (a small front), TiledOps cut each operation into tiles that other workers may take (a large
// front). Operations that do not depend on each other are handed to `all` together, as one loop over the
// tiles of all of them: the fewer loops, the less often somebody waits for the last tile of one. Each tile is
// the same BLAS call whichever thread takes it, so the result does not depend on who does.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/dense/blas.hpp"
#include "kernels/dense/panel_lu.hpp"
#include "kernels/runtime/workers.hpp"

namespace mfs {

struct SequentialOps {
  template <class Scalar>
  PivotTally factor_block(const BlockColumns<Scalar>& block, Vertex m, Vertex n, const PivotRule& rule,
                          Vertex* interchange, Scalar* shift) const {
    return factor_panel(block, 0, m, n, rule, interchange, shift);
  }
  template <class Scalar>
  auto exchange_rows(Vertex columns, Scalar* a, Offset lda, const Vertex* interchange, Vertex count) const {
    return [=] { mfs::exchange_rows(columns, a, lda, interchange, count); };
  }
  template <class Scalar>
  auto exchange_and_solve(Vertex n, Vertex columns, const Scalar* t, Offset ldt, const Vertex* interchange,
                          Scalar* b, Offset ldb) const {
    return [=] {
      mfs::exchange_rows(columns, b, ldb, interchange, n);
      blas::solve_unit_lower(blas::Transpose::no, n, columns, t, ldt, b, ldb);
    };
  }
  template <class Scalar>
  auto solve_upper_right(Vertex rows, Vertex n, const Scalar* u, Offset ldu, Scalar* b, Offset ldb) const {
    return [=] { blas::solve_upper_right(rows, n, u, ldu, b, ldb); };
  }
  template <class Scalar>
  auto gemm_minus(Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda, const Scalar* b, Offset ldb,
                  Scalar* c, Offset ldc) const {
    return [=] { blas::gemm_minus(blas::Transpose::no, m, n, k, a, lda, b, ldb, c, ldc); };
  }
  template <class... Operation>
  void all(const Operation&... operation) const {
    (operation(), ...);
  }
};

/// Sizes of the tiles of a front that `share` threads may work on. 2-core EPYC with OpenBLAS, 2026-11: panels
/// of 64 to 192 and tiles of 256 to 512 differ by less than 3 %. The more threads, the more tiles there must
/// be, and the sooner the panel, which is one thread's, must be done.
class TileSizes {
 public:
  explicit TileSizes(int share) : share_(share) {}
  Vertex panel() const { return share_ > 3 ? 64 : 128; }
  /// Of a row of tiles, and of the edges of a matrix of tiles: two, or four, for each thread.
  Vertex of_row(Vertex length) const { return within_bounds(length / (2.0 * share_)); }
  Vertex of_matrix(Vertex m, Vertex n) const {
    return within_bounds(std::sqrt(static_cast<double>(m) * n / (4.0 * share_)));
  }

 private:
  static Vertex within_bounds(double length) {
    constexpr Vertex kStep = 32, kLeast = 96, kMost = 384;
    return std::clamp(static_cast<Vertex>(length / kStep + 1) * kStep, kLeast, kMost);
  }
  int share_;
};

class TiledOps {
 public:
  TiledOps(const Worker& worker, const TileSizes& sizes) : worker_(worker), sizes_(sizes) {}

  // Right-looking with look-ahead: while the other threads update the columns further right, one thread
  // updates and factors the next panel, so the panel is off the critical path.
  template <class Scalar>
  PivotTally factor_block(const BlockColumns<Scalar>& block, Vertex m, Vertex n, const PivotRule& rule,
                          Vertex* interchange, Scalar* shift) const {
    Scalar* const a = block.a;
    const Offset lda = block.lda;
    const Vertex panel = sizes_.panel();
    PivotTally tally = factor_next(block, 0, m, std::min(n, panel), rule, interchange, shift);
    for (Vertex k = 0; k + panel < n; k += panel) {
      const Vertex right = k + panel;
      PivotTally next_tally;
      worker_.for_each_tile(tiles(n - right, panel), [&](Vertex t) {
        const Vertex begin = right + t * panel, columns = std::min(panel, n - begin);
        update_columns(m, k, panel, begin, columns, a, lda, interchange);
        if (t == 0) next_tally = factor_next(block, right, m - right, columns, rule, interchange, shift);
      });
      tally.perturbed += next_tally.perturbed;
      if (tally.first_nonfinite < 0) tally.first_nonfinite = next_tally.first_nonfinite;
    }
    // The columns left of each panel see its row exchanges last, all at once.
    worker_.for_each_tile(tiles(n, panel), [=](Vertex t) {
      const Vertex begin = t * panel, end = std::min(begin + panel, n);
      exchange_from_to(end, n, end - begin, a + begin * lda, lda, interchange);
    });
    return tally;
  }
  template <class Scalar>
  auto exchange_rows(Vertex columns, Scalar* a, Offset lda, const Vertex* interchange, Vertex count) const {
    const Vertex width = sizes_.of_row(columns);
    return tiled(tiles(columns, width), [=](Vertex t) {
      mfs::exchange_rows(std::min(width, columns - t * width), a + t * width * lda, lda, interchange, count);
    });
  }
  template <class Scalar>
  auto exchange_and_solve(Vertex n, Vertex columns, const Scalar* t, Offset ldt, const Vertex* interchange,
                          Scalar* b, Offset ldb) const {
    const Vertex width = sizes_.of_row(columns);
    return tiled(tiles(columns, width), [=](Vertex tile) {
      const Vertex count = std::min(width, columns - tile * width);
      SequentialOps().exchange_and_solve(n, count, t, ldt, interchange, b + tile * width * ldb, ldb)();
    });
  }
  template <class Scalar>
  auto solve_upper_right(Vertex rows, Vertex n, const Scalar* u, Offset ldu, Scalar* b, Offset ldb) const {
    const Vertex height = sizes_.of_row(rows);
    return tiled(tiles(rows, height), [=](Vertex tile) {
      const Vertex begin = tile * height;
      blas::solve_upper_right(std::min(height, rows - begin), n, u, ldu, b + begin, ldb);
    });
  }
  template <class Scalar>
  auto gemm_minus(Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda, const Scalar* b, Offset ldb,
                  Scalar* c, Offset ldc) const {
    const Vertex edge = sizes_.of_matrix(m, n), tile_rows = tiles(m, edge);
    return tiled(tile_rows * tiles(n, edge), [=](Vertex tile) {
      const Offset i = static_cast<Offset>(tile % tile_rows) * edge,
                   j = static_cast<Offset>(tile / tile_rows) * edge;
      const Vertex rows = static_cast<Vertex>(std::min<Offset>(edge, m - i));
      const Vertex columns = static_cast<Vertex>(std::min<Offset>(edge, n - j));
      blas::gemm_minus(blas::Transpose::no, rows, columns, k, a + i, lda, b + j * ldb, ldb, c + i + j * ldc,
                       ldc);
    });
  }
  template <class... Operation>
  void all(const Operation&... operation) const {
    worker_.for_each_tile((operation.count + ...), [&](Vertex tile) {
      // Which of the operations has this tile, and which of its own is it?
      static_cast<void>((
          ... || (tile < operation.count ? (operation.body(tile), true) : (tile -= operation.count, false))));
    });
  }

 private:
  template <class Body>
  struct Tiled {
    Vertex count;
    Body body;
  };
  template <class Body>
  static Tiled<Body> tiled(Vertex count, const Body& body) {
    return {count, body};
  }
  static Vertex tiles(Vertex length, Vertex tile) { return (length + tile - 1) / tile; }

  // Exchanges row k with interchange[k], for k = begin ... end-1, in `columns` columns.
  template <class Scalar>
  static void exchange_from_to(Vertex begin, Vertex end, Vertex columns, Scalar* a, Offset lda,
                               const Vertex* interchange) {
    for (Vertex j = 0; j < columns; ++j, a += lda) {
      for (Vertex k = begin; k < end; ++k) std::swap(a[k], a[interchange[k]]);
    }
  }

  // Rows in `interchange` count from the begin of the block.
  template <class Scalar>
  static PivotTally factor_next(const BlockColumns<Scalar>& block, Vertex k, Vertex m, Vertex n,
                                const PivotRule& rule, Vertex* interchange, Scalar* shift) {
    const PivotTally tally = factor_panel(block, k, m, n, rule, interchange + k, shift + k);
    for (Vertex j = k; j < k + n; ++j) interchange[j] += k;
    return tally;
  }

  // What the panel at column k (s wide) does to columns [begin, begin+columns): exchange, solve, product.
  template <class Scalar>
  static void update_columns(Vertex m, Vertex k, Vertex s, Vertex begin, Vertex columns, Scalar* a,
                             Offset lda, const Vertex* interchange) {
    Scalar* top = a + begin * lda;
    exchange_from_to(k, k + s, columns, top, lda, interchange);
    blas::solve_unit_lower(blas::Transpose::no, s, columns, a + k + k * lda, lda, top + k, lda);
    blas::gemm_minus(blas::Transpose::no, m - k - s, columns, s, a + k + s + k * lda, lda, top + k, lda,
                     top + k + s, lda);
  }

  Worker worker_;
  TileSizes sizes_;
};

}  // namespace mfs
