// Sparse LU by SuiteSparse of matrices that are made of Phi_q: UMFPACK for rectangular ones, of which only
// the pivots are wanted, KLU for square ones. Both throw OutOfMemory and BackendError.
#pragma once

#include <klu.h>

#include <vector>

#include "ordering/raw_vector.hpp"

namespace mfs::dae {

struct Pivots {
  std::vector<int> row, column;  ///< of the k-th pivot
  std::vector<double> value;
};

/// Those of a matrix in compressed columns, by UMFPACK, which takes them by size.
Pivots find_pivots(int rows, const std::vector<int>& starts, const RawVector<int>& index,
                   const std::vector<double>& values);

/// Whether a factorization chooses its pivots or takes those of the one before.
enum class PivotOrder { chosen, kept };

/// A square matrix in compressed columns and its factors, by KLU: constraints that share no frame are blocks
/// of their own, mostly with one row. Only the values change.
class BlockLu {
 public:
  BlockLu(std::vector<int> starts, std::vector<int> index);
  ~BlockLu();
  BlockLu(const BlockLu&) = delete;

  /// False: singular, or so with the pivots kept. There are none to keep before the first and after a
  /// singular one.
  bool factor(std::vector<double> values, PivotOrder order);
  /// x for A x = b.
  std::vector<double> solve(std::vector<double> b);
  /// x for A^T x = b.
  std::vector<double> solve_transpose(std::vector<double> b);

 private:
  void check(bool good, const char* what) const;

  klu_common common_{};
  std::vector<int> starts_, index_;
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
};

}  // namespace mfs::dae
