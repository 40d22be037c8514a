// A scalar program for many threads that work on one system at a time: every product of the factorization and
// of both substitutions, in levels. What a level needs has been made by earlier ones, and no two tasks of it
// have the same target, so threads meet at the end of each level and nowhere else.
//
//   task:     target -= sum of (m * d) * s        m an entry of L or U, d the inverse of its column's pivot,
//                                                 s an entry of U, or of the vector that is substituted
//   level 3:  | 32 tasks | 32 tasks | 32 tasks | 7 tasks |          the longest come first
//                 |
//                 +--> | first product of each of 32 | second of each | ... |
//
// L is not divided by the pivots, so that products with a column may follow as soon as its pivot is there.
// A target takes its products when the last of them can be had, and before that whenever `together` of them
// can, so that it is read and written less often.
#pragma once

#include <cstdint>
#include <vector>

#include "plan/scalar_program.hpp"

namespace mfs {

/// Tasks whose products lie together: the first product of each, the second of each, ...
constexpr int kSliceTasks = 32;

/// A product or a task in 64 bits; a task that is 0 is none.
struct Packed {
  static constexpr int kNumber = 21, kCount = 18;

  static constexpr std::uint64_t product(Offset m, Offset d, Offset s) {
    return static_cast<std::uint64_t>(m) | static_cast<std::uint64_t>(d) << kNumber |
           static_cast<std::uint64_t>(s) << (2 * kNumber);
  }
  static constexpr std::uint64_t task(Offset target, bool completes_pivot, Offset count, Offset row) {
    return static_cast<std::uint64_t>(target) | static_cast<std::uint64_t>(completes_pivot) << kNumber |
           static_cast<std::uint64_t>(count) << (kNumber + 1) |
           static_cast<std::uint64_t>(row) << (kNumber + 1 + kCount);
  }
};

/// What fits there: entries of the factors, of which each product of a task has two of its own, and products.
constexpr Offset kMostScheduledEntries = Offset{2} << Packed::kCount,
                 kMostScheduledProducts = Offset{1} << (64 - Packed::kNumber - 1 - Packed::kCount);

struct LevelSchedule {
  /// Levels, and after the last one as many as threads look ahead, into tasks; slices belong to one level.
  std::vector<Vertex> level_begin;
  /// The first levels are those of the factors, the next those of L; the others those of U.
  Vertex factor_levels = 0, forward_levels = 0, levels = 0;
  std::vector<std::uint64_t> tasks;
  std::vector<std::uint64_t>
      products;  // m and d: entries of the factors; s: entry, or position in the vector
};

/// Levels that threads look ahead.
constexpr Vertex kLevelsAhead = 4;

/// `together`: products that a target of the factorization takes at a time.
LevelSchedule make_level_schedule(const ScalarProgram& program, int together = 4);

}  // namespace mfs
