// A sparse matrix composed of sparse blocks: each term puts a block (or its transpose) into consecutive rows,
// sends its columns to columns of the matrix, several to one where that is asked for, and multiplies it by a
// factor. Where terms meet, they add up. The pattern and the place of every entry are found once;
// composing values is then one pass over the entries, by rows, so that the sum in each entry has one order
// whatever the number of threads.
//
//   terms of the rows of F:   dF/da  dF/dv  dF/dq  Phi_q^T
//                               |      |      |       |       column[j]; factor
//   matrix row              [ ......................... ]
//
// Terms may be added elsewhere. Then values are composed only for those entries that the others reach.
#pragma once

#include <utility>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"
#include "ordering/raw_vector.hpp"

namespace mfs::dae {

/// The transpose of a pattern; entry k of it is entry source[k] of the original.
struct TransposedPattern {
  explicit TransposedPattern(const Pattern& original);
  Pattern pattern;
  std::vector<int> source;
};

/// Those rows of a pattern, and where their entries lie in it.
std::pair<Pattern, std::vector<int>> take_rows(const Pattern& pattern, const std::vector<int>& rows);

/// Where the diagonal entries of a pattern lie, row by row; -1 where there are none.
std::vector<int> find_diagonal(const Pattern& pattern);

/// first, first + 1, ...: where the columns of a block go that stay side by side.
std::vector<int> consecutive(int first, int count);

/// SolveOptions::row_floor of MFS for these matrices. What is tiny in a correction of Newton's method needs
/// no accuracy of its own, and what a planar mechanism has across its plane, or any at rest, is rounding:
/// with MFS' tolerance, rows of the scaled system are solved to 1e-14.
constexpr double kRowFloor = 0.01;

class Composition {
 public:
  struct Term {
    const Pattern* block;         ///< has to live as long
    int first_row;                ///< of the matrix; ranges of two terms are the same or apart
    std::vector<int> column;      ///< of the matrix, one per column of the block
    const int* source = nullptr;  ///< where entry k lies in the values; null: at k
    bool elsewhere = false;       ///< is in the matrix, but added by whoever has its values
  };
  struct Values {
    const double* block;  ///< of the term's block
    double factor = 1.0;
  };
  /// `size` rows and columns. Throws InvalidInput where the matrix has 2^31 entries or more.
  Composition(int size, std::vector<Term> terms, int threads);

  const Pattern& pattern() const { return pattern_; }
  /// Where the entries of term k go, one that is added elsewhere; given away.
  RawVector<int> take_targets(std::size_t k) { return std::move(target_[k]); }
  /// Where terms are added elsewhere: the entries that are composed here, ascending. Empty otherwise, when
  /// all are.
  const std::vector<int>& own_entries() const { return own_; }
  /// `values[k]` belongs to term k, if that is added here. Overwrites `own`, one value for each of
  /// own_entries(), or of all.
  void compose(const std::vector<Values>& values, double* own) const;

 private:
  struct Group {
    int first_row, rows;
    std::vector<std::size_t> terms;
  };
  void make_groups();
  static void list_columns(const Term& term, int row, std::vector<int>& columns);
  void make_pattern();
  template <class Visit>
  void for_merged_rows(const Visit& visit) const;
  void make_targets();
  void find_own();
  void list_rows();

  struct Row {
    int group, row;  ///< of the group
  };
  int threads_;
  std::vector<Term> terms_;
  std::vector<Group> groups_;
  std::vector<RawVector<int>>
      target_;  ///< per term: where its entries go, among the own ones if it is added here
  Pattern pattern_;
  std::vector<int> own_;
  std::vector<int> own_start_;              ///< per row: the first of own_ in it
  std::vector<Row> rows_;                   ///< in which values are composed
  std::vector<std::size_t> work_start_{0};  ///< of each of them: the terms of those before
};

}  // namespace mfs::dae
