// Stage "solve": forward substitution from the deepest depth up, backward substitution back down, for any
// number of right-hand sides at once. Vectors are in elimination order, n x k, column-major.
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

#include "kernels/dense/blas.hpp"
#include "kernels/runtime/workers.hpp"
#include "kernels/stages/front_store.hpp"

namespace mfs {

/// Vectors of one solve: `v` goes in and comes out, `y` and `border` are work.
template <class Scalar>
struct SolveVectors {
  Vertex columns;  // k
  Scalar* v;       // n x k
  Scalar* y;       // n x k
  Scalar* border;  // front f: border rows x k at border_begin[f] * k
};

/// v(pivots of f) and border(f) += what the children left.
template <class Scalar, class Value>
void gather_children(const FrontStore<Scalar, Value>& store, const SolveVectors<Scalar>& vectors, Vertex f) {
  const Front<Scalar> front = store.front(f);
  const Vertex p = front.pivots, b = front.border, k = vectors.columns;
  Scalar* own = vectors.border + store.border_begin[f] * k;
  for (Offset i = 0; i < static_cast<Offset>(b) * k; ++i) own[i] = Scalar(0);
  for (Vertex c = store.child_begin[f]; c < store.child_begin[f + 1]; ++c) {
    const Vertex child = store.children[c];
    const Vertex* map = store.border_in_parent + store.border_begin[child];
    const Vertex rows = static_cast<Vertex>(store.border_begin[child + 1] - store.border_begin[child]);
    const Vertex split = lower_bound(map, rows, p);
    const Scalar* left = vectors.border + store.border_begin[child] * k;
    for (Vertex j = 0; j < k; ++j, left += rows) {
      Scalar* pivots = vectors.v + store.pivot_begin[f] + static_cast<Offset>(j) * store.n;
      Scalar* border = own + static_cast<Offset>(j) * b;
      for (Vertex i = 0; i < split; ++i) pivots[map[i]] += left[i];
      for (Vertex i = split; i < rows; ++i) border[map[i] - p] += left[i];
    }
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

/// y := L_P^-1 y, z -= L y for a front (transposed: y := U_P^-T y, z -= U^T y); y has leading dimension ldy,
/// z has one row per border row.
template <class Split, class Scalar>
void forward_blocks(const Split& split, const Front<Scalar>& front, bool transposed, Vertex columns,
                    Scalar* y, Offset ldy, Scalar* z) {
  using blas::Transpose;
  const Vertex p = front.pivots, b = front.border, width = split.block(p);
  const Offset ld = front.lower_ld;
  const Scalar* lower = front.lower;
  for (Vertex k = 0; k < p; k += width) {
    const Vertex s = width < p - k ? width : p - k, next = k + s;
    if (transposed) {
      blas::solve_upper(Transpose::yes, s, columns, lower + k + k * ld, ld, y + k, ldy);
    } else {
      blas::solve_unit_lower(Transpose::no, s, columns, lower + k + k * ld, ld, y + k, ldy);
    }
    split(p - next, s, [=](Vertex i, Vertex count) {
      const Scalar* block = transposed ? lower + k + (next + i) * ld : lower + next + i + k * ld;
      blas::gemm_minus(transposed ? Transpose::yes : Transpose::no, count, columns, s, block, ld, y + k, ldy,
                       y + next + i, ldy);
    });
  }
  split(b, p, [=](Vertex i, Vertex count) {
    if (transposed) {
      blas::gemm_minus(Transpose::yes, count, columns, p, front.upper + static_cast<Offset>(i) * p, p, y, ldy,
                       z + i, b);
    } else {
      blas::gemm_minus(Transpose::no, count, columns, p, lower + p + i, ld, y, ldy, z + i, b);
    }
  });
}

/// y := U_P^-1 (y - U x) for a front (transposed: y := L_P^-T (y - L^T x)); x has one row per border row.
template <class Split, class Scalar>
void backward_blocks(const Split& split, const Front<Scalar>& front, bool transposed, Vertex columns,
                     Scalar* y, Offset ldy, const Scalar* x) {
  using blas::Transpose;
  const Vertex p = front.pivots, b = front.border, width = split.block(p);
  const Offset ld = front.lower_ld;
  const Scalar* lower = front.lower;
  split(p, b, [=](Vertex i, Vertex count) {
    if (transposed) {
      blas::gemm_minus(Transpose::yes, count, columns, b, lower + p + i * ld, ld, x, b, y + i, ldy);
    } else {
      blas::gemm_minus(Transpose::no, count, columns, b, front.upper + i, p, x, b, y + i, ldy);
    }
  });
  for (Vertex k = (p - 1) / width * width; k >= 0; k -= width) {
    const Vertex s = width < p - k ? width : p - k;
    if (transposed) {
      blas::solve_unit_lower(Transpose::yes, s, columns, lower + k + k * ld, ld, y + k, ldy);
    } else {
      blas::solve_upper(Transpose::no, s, columns, lower + k + k * ld, ld, y + k, ldy);
    }
    split(k, s, [=](Vertex i, Vertex count) {
      const Scalar* block = transposed ? lower + k + i * ld : lower + i + k * ld;
      blas::gemm_minus(transposed ? Transpose::yes : Transpose::no, count, columns, s, block, ld, y + k, ldy,
                       y + i, ldy);
    });
  }
}

template <class Split, class Scalar, class Value>
void forward_front(const Split& split, const FrontStore<Scalar, Value>& store,
                   const SolveVectors<Scalar>& vectors, Vertex f, bool transposed) {
  const Front<Scalar> front = store.front(f);
  const Offset first = store.pivot_begin[f];
  gather_children(store, vectors, f);
  Scalar* y = vectors.y + first;
  for (Vertex j = 0; j < vectors.columns; ++j) {
    const Scalar* v = vectors.v + first + static_cast<Offset>(j) * store.n;
    Scalar* to = y + static_cast<Offset>(j) * store.n;
    for (Vertex i = 0; i < front.pivots; ++i) to[i] = v[transposed ? i : store.local_row[first + i]];
  }
  forward_blocks(split, front, transposed, vectors.columns, y, store.n,
                 vectors.border + store.border_begin[f] * vectors.columns);
}

template <class Split, class Scalar, class Value>
void backward_front(const Split& split, const FrontStore<Scalar, Value>& store,
                    const SolveVectors<Scalar>& vectors, Vertex f, bool transposed) {
  const Front<Scalar> front = store.front(f);
  const Offset first = store.pivot_begin[f];
  const Vertex* rows = store.border + store.border_begin[f];
  Scalar* y = vectors.y + first;
  Scalar* x = vectors.border + store.border_begin[f] * vectors.columns;
  for (Vertex j = 0; j < vectors.columns; ++j) {
    const Scalar* v = vectors.v + static_cast<Offset>(j) * store.n;
    for (Vertex i = 0; i < front.border; ++i) x[i + static_cast<Offset>(j) * front.border] = v[rows[i]];
  }
  backward_blocks(split, front, transposed, vectors.columns, y, store.n, x);
  for (Vertex j = 0; j < vectors.columns; ++j) {
    Scalar* v = vectors.v + first + static_cast<Offset>(j) * store.n;
    const Scalar* from = y + static_cast<Offset>(j) * store.n;
    for (Vertex i = 0; i < front.pivots; ++i) v[transposed ? store.local_row[first + i] : i] = from[i];
  }
}

}  // namespace mfs
