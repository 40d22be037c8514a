// Ranks without rounding: of matrices of integers, by elimination modulo the prime 2^61 - 1. That is never
// more than the rank over the rationals, and less only where the prime divides all largest minors that are
// not zero.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "test/reference/random.hpp"
#include "test/reference/sparse.hpp"

namespace mfs::test {

constexpr std::uint64_t kPrime = (std::uint64_t{1} << 61) - 1;

inline std::uint64_t multiply_modulo(std::uint64_t a, std::uint64_t b) {
  __extension__ using Wide = unsigned __int128;
  return static_cast<std::uint64_t>(static_cast<Wide>(a) * b % kPrime);
}

inline std::uint64_t inverse_modulo(std::uint64_t a) {  // a^(p - 2), by Fermat
  std::uint64_t result = 1;
  for (std::uint64_t exponent = kPrime - 2; exponent > 0; exponent /= 2) {
    if (exponent % 2) result = multiply_modulo(result, a);
    a = multiply_modulo(a, a);
  }
  return result;
}

/// Rank of n columns of integers modulo the prime.
inline std::int64_t rank_modulo(std::vector<std::vector<std::uint64_t>> rows) {
  std::size_t rank = 0;
  const std::size_t columns = rows.empty() ? 0 : rows[0].size();
  for (std::size_t j = 0; j < columns && rank < rows.size(); ++j) {
    std::size_t pivot = rank;
    while (pivot < rows.size() && rows[pivot][j] == 0) ++pivot;
    if (pivot == rows.size()) continue;
    std::swap(rows[rank], rows[pivot]);
    const std::uint64_t scale = inverse_modulo(rows[rank][j]);
    for (std::size_t i = rank + 1; i < rows.size(); ++i) {
      if (rows[i][j] == 0) continue;
      const std::uint64_t factor = kPrime - multiply_modulo(rows[i][j], scale);
      for (std::size_t k = j; k < columns; ++k) {
        if (rows[rank][k] != 0) rows[i][k] = (rows[i][k] + multiply_modulo(factor, rows[rank][k])) % kPrime;
      }
    }
    ++rank;
  }
  return static_cast<std::int64_t>(rank);
}

/// Rank of `a`, whose entries are integers, without one row and one column (-1: none is left out).
inline std::int64_t exact_rank(const SparseMatrix& a, std::int64_t without_row = -1,
                               std::int64_t without_column = -1) {
  std::vector<std::vector<std::uint64_t>> rows(static_cast<std::size_t>(a.n),
                                               std::vector<std::uint64_t>(static_cast<std::size_t>(a.n), 0));
  for (const Entry& e : entries_of(a)) {
    if (e.row == without_row || e.column == without_column) continue;
    const auto value = static_cast<std::int64_t>(e.value);
    std::uint64_t& place = rows[e.row][e.column];
    place = (place +
             (value < 0 ? kPrime - static_cast<std::uint64_t>(-value) : static_cast<std::uint64_t>(value))) %
            kPrime;
  }
  return rank_modulo(std::move(rows));
}

/// The matrix with random integers in the places of its entries that are not zero: its rank is the structural
/// rank of `a`.
inline SparseMatrix randomized(const SparseMatrix& a) {
  Random random(1);
  SparseMatrix result = a;
  for (double& value : result.values) {
    if (value != 0) value = static_cast<double>(random.integer(1, std::int64_t{1} << 50));
  }
  return result;
}

}  // namespace mfs::test
