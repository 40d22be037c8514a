// Global ids of Trilinos against rows 0 ... n-1 of the solver. Ids may start anywhere, have gaps and come in
// any order; where they count up by one, as nearly always, a lookup is a subtraction.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace mfs::amesos2 {

class IdPositions {
 public:
  IdPositions() = default;
  /// Position k belongs to ids[k].
  explicit IdPositions(const std::vector<std::int64_t>& ids) : size_(static_cast<std::int64_t>(ids.size())) {
    first_ = ids.empty() ? 0 : ids.front();
    bool counting_up = true;
    for (std::int64_t k = 0; k < size_ && counting_up; ++k) counting_up = ids[k] == first_ + k;
    if (counting_up) return;
    sorted_.reserve(ids.size());
    for (std::int64_t k = 0; k < size_; ++k) sorted_.emplace_back(ids[k], k);
    std::sort(sorted_.begin(), sorted_.end());
  }

  std::int64_t size() const { return size_; }
  /// Ids are their own positions: nothing has to be translated.
  bool identity() const { return sorted_.empty() && first_ == 0; }
  /// An id that occurs twice, through `id`.
  bool has_duplicate(std::int64_t& id) const {
    const auto twice = std::adjacent_find(sorted_.begin(), sorted_.end(),
                                          [](const auto& a, const auto& b) { return a.first == b.first; });
    if (twice == sorted_.end()) return false;
    id = twice->first;
    return true;
  }
  /// Position of `id`, -1 where there is none.
  std::int64_t find(std::int64_t id) const {
    if (sorted_.empty()) {
      const std::int64_t position = id - first_;
      return position >= 0 && position < size_ ? position : -1;
    }
    const auto place = std::lower_bound(sorted_.begin(), sorted_.end(), std::make_pair(id, std::int64_t{0}));
    return place != sorted_.end() && place->first == id ? place->second : -1;
  }

 private:
  std::int64_t size_ = 0;
  std::int64_t first_ = 0;
  std::vector<std::pair<std::int64_t, std::int64_t>> sorted_;  ///< (id, position), empty where ids count up
};

}  // namespace mfs::amesos2
