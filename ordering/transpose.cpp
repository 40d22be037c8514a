#include "ordering/transpose.hpp"

namespace mfs {

TransposedPattern transpose(const Pattern& pattern) {
  TransposedPattern result;
  result.offsets.assign(pattern.n + 1, 0);
  for (const Vertex column : pattern.columns) ++result.offsets[column + 1];
  for (Vertex j = 0; j < pattern.n; ++j) result.offsets[j + 1] += result.offsets[j];
  result.columns.resize(pattern.columns.size());
  result.slots.resize(pattern.columns.size());
  std::vector<Offset> next(result.offsets.begin(), result.offsets.end() - 1);
  for (Vertex row = 0; row < pattern.n; ++row) {
    for (Offset slot = pattern.offsets[row]; slot < pattern.offsets[row + 1]; ++slot) {
      const Offset k = next[pattern.columns[slot]]++;
      result.columns[k] = row;
      result.slots[k] = slot;
    }
  }
  return result;
}

}  // namespace mfs
