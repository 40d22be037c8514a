// Stage "solve": forward substitution from the deepest depth up, backward substitution back down, for any
// number of right-hand sides at once. Vectors are in elimination order, the columns of a row beside each
// other (kernels/dense/row_kernels.hpp).
//
//   forward   front f gathers its pivot rows of v and what its children left for it, solves with L_P, and
//   leaves
//             z = (children's part) - L y for its own border: a parent pulls from its children in fixed
//             order, as in "assemble", so no two fronts write to one place.
//   backward  x(pivots) = U_P^-1 (y - U x(border)): only reads what ancestors have finished.
//
// The transposed system swaps the roles: U_P^T and U^T go forward, L_P^T and L^T backward, and the row
// exchanges of the pivot block are undone at the end instead of done at the begin.
#pragma once

#include <algorithm>

#include "kernels/dense/blas.hpp"
#include "kernels/dense/row_kernels.hpp"
#include "kernels/runtime/inlined.hpp"
#include "kernels/runtime/workers.hpp"
#include "kernels/stages/front_store.hpp"

namespace mfs {

/// Vectors of one solve: `v` goes in and comes out, `y` and `border` are work.
template <class Scalar>
struct SolveVectors {
  Vertex width;    // entries of a row, rows::width_of(columns)
  Scalar* v;       // n x width
  Scalar* y;       // n x width
  Scalar* border;  // front f: border rows x width at border_begin[f] * width

  Scalar* row(Scalar* of, Offset i) const { return of + i * width; }
};

/// v(pivots of f) and border(f) += what the children left.
template <class Scalar, class Value>
void gather_children(const FrontStore<Scalar, Value>& store, const Front<Scalar>& front,
                     const SolveVectors<Scalar>& vectors, Vertex f) {
  const Vertex p = front.pivots, width = vectors.width;
  Scalar* const pivots = vectors.row(vectors.v, store.pivot_begin[f]);
  Scalar* const border = vectors.row(vectors.border, store.border_begin[f]);
  std::fill_n(border, static_cast<Offset>(front.border) * width, Scalar(0));
  for (Vertex c = store.child_begin[f]; c < store.child_begin[f + 1]; ++c) {
    const Vertex child = store.children[c];
    const Vertex* map = store.border_in_parent + store.border_begin[child];
    const Vertex rows = static_cast<Vertex>(store.border_begin[child + 1] - store.border_begin[child]);
    const Vertex split = lower_bound(map, rows, p);
    const Scalar* left = vectors.row(vectors.border, store.border_begin[child]);
    rows::scatter_add(split, width, map, 0, left, pivots);
    rows::scatter_add(rows - split, width, map + split, p, left + static_cast<Offset>(split) * width, border);
  }
}

/// C -= op(A) B for C of m rows and B of k; a single column is left to the kernels of blas.hpp.
template <class Scalar>
void subtract_rows(bool transposed, Vertex m, Vertex width, Vertex k, const Scalar* a, Offset lda,
                   const Scalar* b, Scalar* c) {
  if (width > 1) return rows::gemm_minus(transposed, m, width, k, a, lda, b, c);
  blas::gemm_minus(transposed ? blas::Transpose::yes : blas::Transpose::no, m, 1, k, a, lda, b, k, c, m);
}

/// B := op(T)^-1 B, n rows, for the upper or the unit lower triangle of T.
template <class Scalar>
void solve_rows(bool upper, bool transposed, Vertex n, Vertex width, const Scalar* t, Offset ldt, Scalar* b) {
  const auto transpose = transposed ? blas::Transpose::yes : blas::Transpose::no;
  if (width > 1) {
    rows::solve_triangle(upper, transposed, n, width, t, ldt, b);
  } else if (upper) {
    blas::solve_upper(transpose, n, 1, t, ldt, b, n);
  } else {
    blas::solve_unit_lower(transpose, n, 1, t, ldt, b, n);
  }
}

/// How the matrix-vector part of a front is shared out: all of it here, or in tiles that others may take.
struct SequentialSplit {
  Vertex block(Vertex pivots) const { return pivots; }
  template <class Body>
  void operator()(Vertex length, Vertex, const Body& body) const {
    if (length > 0) body(0, length);
  }
};
struct TiledSplit {
  Worker worker;
  Vertex block(Vertex) const { return 256; }
  /// `length` rows that are products of `depth` entries each.
  template <class Body>
  void operator()(Vertex length, Vertex depth, const Body& body) const {
    constexpr Vertex kEntries = 32768;  // 256 KB in double precision, some 30 us
    const Vertex tile = (kEntries / (depth + 1) / 16 + 1) * 16;
    worker.for_each_tile((length + tile - 1) / tile, [=](Vertex t) {
      const Vertex begin = t * tile;
      body(begin, begin + tile < length ? tile : length - begin);
    });
  }
};

/// y := L_P^-1 y, z -= L y for a front (transposed: y := U_P^-T y, z -= U^T y); z has one row per border row.
template <class Split, class Scalar>
void forward_blocks(const Split& split, const Front<Scalar>& front, bool transposed, Vertex width, Scalar* y,
                    Scalar* z) {
  const Vertex p = front.pivots, b = front.border, block = split.block(p);
  const Offset ld = front.lower_ld, w = width;
  const Scalar* lower = front.lower;
  for (Vertex k = 0; k < p; k += block) {
    const Vertex s = block < p - k ? block : p - k, next = k + s;
    solve_rows(transposed, transposed, s, width, lower + k + k * ld, ld, y + k * w);
    split(p - next, s, [=](Vertex i, Vertex count) {
      const Scalar* from = transposed ? lower + k + (next + i) * ld : lower + next + i + k * ld;
      subtract_rows(transposed, count, width, s, from, ld, y + k * w, y + (next + i) * w);
    });
  }
  split(b, p, [=](Vertex i, Vertex count) {
    const Scalar* from = transposed ? front.upper + static_cast<Offset>(i) * p : lower + p + i;
    subtract_rows(transposed, count, width, p, from, transposed ? p : ld, y, z + i * w);
  });
}

/// y := U_P^-1 (y - U x) for a front (transposed: y := L_P^-T (y - L^T x)); x has one row per border row.
template <class Split, class Scalar>
void backward_blocks(const Split& split, const Front<Scalar>& front, bool transposed, Vertex width, Scalar* y,
                     const Scalar* x) {
  const Vertex p = front.pivots, b = front.border, block = split.block(p);
  const Offset ld = front.lower_ld, w = width;
  const Scalar* lower = front.lower;
  split(p, b, [=](Vertex i, Vertex count) {
    const Scalar* from = transposed ? lower + p + i * ld : front.upper + i;
    subtract_rows(transposed, count, width, b, from, transposed ? ld : p, x, y + i * w);
  });
  for (Vertex k = (p - 1) / block * block; k >= 0; k -= block) {
    const Vertex s = block < p - k ? block : p - k;
    solve_rows(!transposed, transposed, s, width, lower + k + k * ld, ld, y + k * w);
    split(k, s, [=](Vertex i, Vertex count) {
      const Scalar* from = transposed ? lower + k + i * ld : lower + i + k * ld;
      subtract_rows(transposed, count, width, s, from, ld, y + k * w, y + i * w);
    });
  }
}

/// Asks for the first kBytes of a block, as the processor itself finds what follows. Inlined, also below: GCC
/// takes a function that only prefetches for one without effect, and drops its calls.
template <class Scalar>
MFS_INLINE void prefetch_block(const Scalar* block, Offset entries) {
  constexpr Offset kBytes = 4096, kLine = 64;
  const auto* const begin = reinterpret_cast<const char*>(block);
  const Offset bytes = std::min(kBytes, entries * static_cast<Offset>(sizeof(Scalar)));
  for (Offset i = 0; i < bytes; i += kLine) __builtin_prefetch(begin + i, 0, 2);  // to the second level
}
/// The factors that a front's substitution reads: [P; L], or P and U.
template <class Scalar>
MFS_INLINE void prefetch_factors(const Front<Scalar>& front, bool upper) {
  const Offset p = front.pivots;
  if (upper) prefetch_block(front.upper, p * front.border);
  prefetch_block(front.lower, p * front.lower_ld);
}

/// visit(f) for each of these fronts, children first or, where the way is down, last. The factors of a front
/// are on their way while those before it are solved.
template <class Scalar, class Value, class Visit>
void for_fronts_ahead(const FrontStore<Scalar, Value>& store, const Vertex* fronts, Vertex count, bool down,
                      bool transposed, const Visit& visit) {
  constexpr Vertex kAhead = 2;
  const auto at = [=](Vertex k) { return fronts[down ? count - 1 - k : k]; };
  for (Vertex k = 0; k < count; ++k) {
    if (k + kAhead < count) prefetch_factors(store.front(at(k + kAhead)), down != transposed);
    visit(at(k));
  }
}

template <class Split, class Scalar, class Value>
void forward_front(const Split& split, const FrontStore<Scalar, Value>& store,
                   const SolveVectors<Scalar>& vectors, Vertex f, bool transposed) {
  const Front<Scalar> front = store.front(f);
  const Offset first = store.pivot_begin[f];
  gather_children(store, front, vectors, f);
  Scalar *const v = vectors.row(vectors.v, first), *const y = vectors.row(vectors.y, first);
  if (transposed) {
    std::copy_n(v, static_cast<Offset>(front.pivots) * vectors.width, y);
  } else {
    rows::gather(front.pivots, vectors.width, store.local_row + first, v, y);
  }
  forward_blocks(split, front, transposed, vectors.width, y,
                 vectors.row(vectors.border, store.border_begin[f]));
}

template <class Split, class Scalar, class Value>
void backward_front(const Split& split, const FrontStore<Scalar, Value>& store,
                    const SolveVectors<Scalar>& vectors, Vertex f, bool transposed) {
  const Front<Scalar> front = store.front(f);
  const Offset first = store.pivot_begin[f];
  Scalar *const v = vectors.row(vectors.v, first), *const y = vectors.row(vectors.y, first);
  Scalar* const x = vectors.row(vectors.border, store.border_begin[f]);
  rows::gather(front.border, vectors.width, store.border + store.border_begin[f], vectors.v, x);
  backward_blocks(split, front, transposed, vectors.width, y, x);
  if (transposed) {
    rows::scatter(front.pivots, vectors.width, store.local_row + first, y, v);
  } else {
    std::copy_n(y, static_cast<Offset>(front.pivots) * vectors.width, v);
  }
}

}  // namespace mfs
