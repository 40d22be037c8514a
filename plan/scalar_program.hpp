// The LU factorization of a pattern as a fixed list of operations on single entries, for matrices whose
// fronts are so small that looking after them costs more than their numbers do: circuits, chemical kinetics,
// power flow, mechanisms of rigid bodies. Pivots are those of one factorization by fronts. Whoever executes
// the program does the same for many systems at a time (kernels/lanes), and finds out for each whether these
// pivots serve it.
//
//   column k of the factors, by entry:      u u ... u  p  l l ... l       rows ascend, p: the pivot
//                               column_begin[k]   pivot[k]        column_begin[k+1]
//
// Columns are made from left to right: for each u = (j, k) in turn, u times the l of column j is subtracted
// from column k, then the l are divided by the pivot. Neighbours u whose columns have the same l below them
// are taken together, `width` of them:
//
//      column k      columns j, j+1, j+2
//        [u]            p                      the u become final from above to below, then the others
//        [u]            l  p                   take the products with all of them, at the places in
//        [u]            l  l  p                `target`, which has an entry for each l of the last column
//         .             l  l  l
//         .             l  l  l
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ordering/types.hpp"

namespace mfs {

/// The most u that are taken together.
constexpr int kMostWidth = 4;

struct ScalarProgram {
  Vertex n = 0;
  std::vector<Vertex> row_of, column_of;  // n: position -> row of A, column of A
  std::vector<Vertex> column_begin;       // n + 1, entries
  std::vector<Vertex> pivot;              // n, entries
  std::vector<Vertex> row;                // by entry: position of its row
  std::vector<Vertex> place;              // by slot of the pattern: entry
  std::vector<Vertex> fill;               // entries that no slot has
  std::vector<Vertex> target;             // entry that products go to, counted from column_begin[k]
  std::vector<std::uint8_t> width;        // by entry: at the first u of those taken together, else 0
  Offset products = 0;

  Offset entries() const { return static_cast<Offset>(row.size()); }
};

/// What a program may be at most: entries, and products for each of them.
struct ScalarProgramLimits {
  Offset entries, products_of_entry;
};

/// The pivot of position k is the entry of A in row row_of[k] and column column_of[k]. Nothing where one of
/// them is no entry of the factors, or beyond the limits.
std::optional<ScalarProgram> make_scalar_program(const Pattern& pattern, std::vector<Vertex> row_of,
                                                 std::vector<Vertex> column_of,
                                                 const ScalarProgramLimits& limits);

}  // namespace mfs
