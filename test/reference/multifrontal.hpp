// Multifrontal LU as its definition, by plain loops over full square fronts: what every stage is tested
// against. No Kokkos, no BLAS, and no code of the solver. Of a SymbolicPlan only what defines the problem is
// read (order, pivots, borders, parents); every map from one numbering to another is searched anew.
//
// A front here is one (p+b) x (p+b) matrix, column-major:
//
//              p      b
//          +------+-------+      positions[i] = elimination position of row and column i
//        p |  P   |   U   |
//          +------+-------+
//        b |  L   |   C   |
//          +------+-------+
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs::test {

template <class Scalar>
struct ReferenceFront {
  Vertex pivots = 0, border = 0;
  std::vector<Vertex> positions;  // pivots + border
  std::vector<Scalar> a;          // (pivots + border)^2
  std::vector<Vertex> row_at;     // pivots: the assembled row that came to place i
  std::vector<Scalar> shift;      // pivots: what was added to the pivot

  Vertex rows() const { return pivots + border; }
  Scalar& at(Vertex i, Vertex j) { return a[i + static_cast<Offset>(j) * rows()]; }
  const Scalar& at(Vertex i, Vertex j) const { return a[i + static_cast<Offset>(j) * rows()]; }
};

/// When a pivot is replaced: |pivot| < bound, and either |pivot| <= tiny or |pivot| < border_threshold times
/// the largest entry of its column in the border. It becomes as large as `largest` where pivot and border are
/// both nothing (at most tiny, and empty_border times tiny), else as large as `bound`. The entry on the
/// diagonal counts `preference` times when a pivot is searched.
struct ReferenceRule {
  double bound = 0, tiny = 0, largest = 1, border_threshold = 0.01, empty_border = 10, preference = 1;
};

/// A's values in the order of the pattern, and the scales of its rows and columns.
template <class Scalar>
struct ScaledMatrix {
  const Pattern& pattern;
  const std::vector<Scalar>& values;
  const std::vector<double>&row_scale, &column_scale;
};

inline std::vector<Vertex> inverse(const std::vector<Vertex>& permutation) {
  std::vector<Vertex> place(permutation.size());
  for (std::size_t p = 0; p < permutation.size(); ++p) place[permutation[p]] = static_cast<Vertex>(p);
  return place;
}

/// Stage "assemble": the entries whose earlier position is a pivot of f, then the children's contribution
/// blocks.
template <class Scalar>
ReferenceFront<Scalar> assemble(const SymbolicPlan& plan, const ScaledMatrix<Scalar>& matrix,
                                const std::vector<ReferenceFront<Scalar>>& fronts, Vertex f) {
  ReferenceFront<Scalar> front;
  const Vertex first = plan.pivot_begin[f], last = plan.pivot_begin[f + 1];
  front.pivots = last - first;
  for (Vertex position = first; position < last; ++position) front.positions.push_back(position);
  for (Offset k = plan.border_begin[f]; k < plan.border_begin[f + 1]; ++k)
    front.positions.push_back(plan.border[k]);
  front.border = static_cast<Vertex>(front.positions.size()) - front.pivots;
  front.a.assign(front.positions.size() * front.positions.size(), Scalar(0));
  std::vector<Vertex> local(plan.n, -1);
  for (Vertex i = 0; i < front.rows(); ++i) local[front.positions[i]] = i;

  const std::vector<Vertex> row_position = inverse(plan.row_of), column_position = inverse(plan.column_of);
  for (Vertex row = 0; row < plan.n; ++row) {
    for (Offset k = matrix.pattern.offsets[row]; k < matrix.pattern.offsets[row + 1]; ++k) {
      const Vertex column = matrix.pattern.columns[k], i = row_position[row], j = column_position[column];
      if (std::min(i, j) < first || std::min(i, j) >= last) continue;
      front.at(local[i], local[j]) +=
          matrix.values[k] * Scalar(matrix.row_scale[row] * matrix.column_scale[column]);
    }
  }
  for (Vertex child = 0; child < f; ++child) {
    if (plan.parent[child] != f) continue;
    const ReferenceFront<Scalar>& from = fronts[child];
    for (Vertex j = from.pivots; j < from.rows(); ++j) {
      for (Vertex i = from.pivots; i < from.rows(); ++i) {
        front.at(local[from.positions[i]], local[from.positions[j]]) += from.at(i, j);
      }
    }
  }
  return front;
}

/// Stage "variable factor": Gaussian elimination of the pivots, each searched in all rows of the pivot block
/// that are left. C is not touched.
template <class Scalar>
void variable_factor(ReferenceFront<Scalar>& front, const ReferenceRule& rule) {
  const Vertex p = front.pivots, rows = front.rows();
  front.shift.assign(p, Scalar(0));
  front.row_at.resize(p);
  for (Vertex i = 0; i < p; ++i) front.row_at[i] = i;
  for (Vertex k = 0; k < p; ++k) {
    Vertex best = k;
    for (Vertex i = k + 1; i < p; ++i) {
      const double times = best == k ? rule.preference : 1;
      if (std::abs(front.at(i, k)) > times * std::abs(front.at(best, k))) best = i;
    }
    if (best != k) {
      std::swap(front.row_at[k], front.row_at[best]);
      for (Vertex j = 0; j < rows; ++j) std::swap(front.at(k, j), front.at(best, j));
    }
    double border = 0;
    for (Vertex i = p; i < rows; ++i)
      border = std::max(border, static_cast<double>(std::abs(front.at(i, k))));
    const Scalar pivot = front.at(k, k);
    const double size = std::abs(pivot);
    if (size < rule.bound && (size <= rule.tiny || size < rule.border_threshold * border)) {
      const bool dependent = size <= rule.tiny && border <= rule.empty_border * rule.tiny;
      const Scalar wanted(dependent ? rule.largest : rule.bound);
      front.at(k, k) = size > 0 ? pivot / Scalar(size) * wanted : wanted;
      front.shift[k] = front.at(k, k) - pivot;
    }
    for (Vertex i = k + 1; i < rows; ++i) front.at(i, k) /= front.at(k, k);
    for (Vertex j = k + 1; j < rows; ++j) {
      for (Vertex i = k + 1; i < (j < p ? rows : p); ++i) front.at(i, j) -= front.at(i, k) * front.at(k, j);
    }
  }
}

/// Stage "variable update": C -= L U.
template <class Scalar>
void variable_update(ReferenceFront<Scalar>& front) {
  for (Vertex j = front.pivots; j < front.rows(); ++j) {
    for (Vertex k = 0; k < front.pivots; ++k) {
      for (Vertex i = front.pivots; i < front.rows(); ++i) front.at(i, j) -= front.at(i, k) * front.at(k, j);
    }
  }
}

/// All fronts, deepest first.
template <class Scalar>
std::vector<ReferenceFront<Scalar>> factor(const SymbolicPlan& plan, const ScaledMatrix<Scalar>& matrix,
                                           const ReferenceRule& rule) {
  std::vector<ReferenceFront<Scalar>> fronts;
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    fronts.push_back(assemble(plan, matrix, fronts, f));
    variable_factor(fronts.back(), rule);
    variable_update(fronts.back());
  }
  return fronts;
}

/// Stage "solve", forward: v (by position) becomes y with L y = v (transposed: U^T y = v).
template <class Scalar>
void solve_forward(const std::vector<ReferenceFront<Scalar>>& fronts, bool transposed,
                   std::vector<Scalar>& v) {
  for (const ReferenceFront<Scalar>& front : fronts) {
    std::vector<Scalar> own(front.pivots);
    for (Vertex i = 0; i < front.pivots; ++i) own[i] = v[front.positions[transposed ? i : front.row_at[i]]];
    for (Vertex k = 0; k < front.pivots; ++k) {
      if (transposed) own[k] /= front.at(k, k);
      for (Vertex i = k + 1; i < front.pivots; ++i)
        own[i] -= (transposed ? front.at(k, i) : front.at(i, k)) * own[k];
      for (Vertex i = front.pivots; i < front.rows(); ++i) {
        v[front.positions[i]] -= (transposed ? front.at(k, i) : front.at(i, k)) * own[k];
      }
    }
    for (Vertex i = 0; i < front.pivots; ++i) v[front.positions[i]] = own[i];
  }
}

/// Stage "solve", backward: v becomes x with U x = v (transposed: L^T x = v).
template <class Scalar>
void solve_backward(const std::vector<ReferenceFront<Scalar>>& fronts, bool transposed,
                    std::vector<Scalar>& v) {
  for (auto front = fronts.rbegin(); front != fronts.rend(); ++front) {
    std::vector<Scalar> own(front->pivots);
    for (Vertex k = front->pivots - 1; k >= 0; --k) {
      own[k] = v[front->positions[k]];
      for (Vertex i = k + 1; i < front->rows(); ++i) {
        own[k] -= (transposed ? front->at(i, k) : front->at(k, i)) *
                  (i < front->pivots ? own[i] : v[front->positions[i]]);
      }
      if (!transposed) own[k] /= front->at(k, k);
    }
    for (Vertex i = 0; i < front->pivots; ++i)
      v[front->positions[transposed ? front->row_at[i] : i]] = own[i];
  }
}

}  // namespace mfs::test
