// Matrices of every kind at one size, for tests of the public class.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "test/reference/generators.hpp"
#include "test/reference/random.hpp"
#include "test/reference/sparse.hpp"

namespace mfs::test {

inline SparseMatrix dense(std::int64_t n) {
  Random random(static_cast<std::uint64_t>(n));
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i)
    for (std::int64_t j = 0; j < n; ++j) entries.push_back({i, j, random.entry()});
  return from_entries(n, entries);
}

/// [D B; C 0] with a diagonal D: the last third of the diagonal is zero.
inline SparseMatrix saddle_point(std::int64_t n) {
  const std::int64_t constraints = n / 3, free = n - constraints;
  Random random(static_cast<std::uint64_t>(n));
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < free; ++i) entries.push_back({i, i, 2 + random.unit()});
  for (std::int64_t k = 0; k < constraints; ++k) {
    for (const std::int64_t i : {k, constraints + k % (free - constraints)}) {
      entries.push_back({free + k, i, 1 + random.unit()});
      entries.push_back({i, free + k, 1 + random.unit()});
    }
  }
  return from_entries_summed(n, entries);
}

/// Of n rows each.
inline std::vector<NamedMatrix> family_members(std::int64_t n) {
  return {{"tridiagonal", tridiagonal(n)},
          {"random", random_diagonally_dominant(n, 4, static_cast<std::uint64_t>(n))},
          {"arrow", arrow(n, std::min<std::int64_t>(n - 1, 3))},
          {"dense", dense(n)},
          {"saddle point", saddle_point(n)}};
}

}  // namespace mfs::test
