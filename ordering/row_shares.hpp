// Rows dealt to threads in equal shares, for passes in which each share has an array as long as the matrix.
#pragma once

#include <algorithm>

#include "ordering/types.hpp"

namespace mfs {

class RowShares {
 public:
  RowShares(Vertex rows, int threads) : rows_(rows), count_(std::min(threads, kMost)), threads_(threads) {}
  int count() const { return count_; }
  /// For the loop over them, though some may have no share: libgomp ends the threads that a smaller team does
  /// without, and the next team has to start them again, in a millisecond.
  int threads() const { return threads_; }
  /// Share k has the rows first_row(k) ... first_row(k + 1) - 1.
  Vertex first_row(int k) const { return static_cast<Vertex>(Offset{rows_} * k / count_); }

 private:
  static constexpr int kMost = 8;  // the arrays of more would cost more time than their threads save
  Vertex rows_;
  int count_, threads_;
};

}  // namespace mfs
