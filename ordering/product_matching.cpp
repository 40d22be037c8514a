#include "ordering/product_matching.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <functional>
#include <limits>
#include <utility>

#include "ordering/shared_extremes.hpp"

namespace mfs {
namespace {

using Distance = std::int64_t;
constexpr Distance kFar = std::numeric_limits<Distance>::max();

class Matcher {
 public:
  Matcher(const Pattern& pattern, const RawVector<Cost>& costs, int threads)
      : pattern_(pattern),
        costs_(costs),
        threads_(threads),
        dead_(pattern.n, false),
        distance_(static_cast<std::size_t>(pattern.n)),
        reached_from_(static_cast<std::size_t>(pattern.n)) {
    matching_.row_of_column.assign(pattern.n, -1);
    matching_.column_of_row.assign(pattern.n, -1);
    matching_.row_dual.resize(static_cast<std::size_t>(pattern.n));
    matching_.column_dual.resize(static_cast<std::size_t>(pattern.n));
  }

  ProductMatching run() {
    start_duals();
    match_diagonal();
    match_tight_entries();
    reduce_rows();
    for (Vertex i = 0; i < pattern_.n; ++i) {
      if (matching_.column_of_row[i] < 0 && !augment(i)) ++matching_.unmatched;
    }
    return std::move(matching_);
  }

 private:
  /// Cost above the duals; never negative, 0 ("tight") for matched entries.
  Distance slack(Vertex row, Offset slot) const {
    return costs_[slot] - matching_.row_dual[row] - matching_.column_dual[pattern_.columns[slot]];
  }

  template <class Visit>
  void for_entries(Vertex row, const Visit& visit) const {
    for (Offset k = pattern_.offsets[row]; k < pattern_.offsets[row + 1]; ++k) {
      if (costs_[k] != kNoEdge) visit(k, pattern_.columns[k]);
    }
  }

  void match(Vertex row, Vertex column) {
    matching_.column_of_row[row] = column;
    matching_.row_of_column[column] = row;
  }

  /// The largest feasible column duals, then the largest row duals: every row gets a tight entry.
  void start_duals() {
#pragma omp parallel num_threads(threads_)
    {
#pragma omp for schedule(static)
      for (Vertex j = 0; j < pattern_.n; ++j) matching_.column_dual[j] = distance_[j] = kFar;
#pragma omp for schedule(static)
      for (Vertex i = 0; i < pattern_.n; ++i)
        for_entries(i, [&](Offset k, Vertex j) {
          improve<Distance>(matching_.column_dual[j], costs_[k], std::less<>());
        });
#pragma omp for schedule(static)
      for (Vertex j = 0; j < pattern_.n; ++j) {
        if (matching_.column_dual[j] == kFar) matching_.column_dual[j] = 0;
        matching_.row_dual[j] = 0;
      }
#pragma omp for schedule(static)
      for (Vertex i = 0; i < pattern_.n; ++i) {
        Distance least = kFar;
        for_entries(i, [&](Offset k, Vertex) { least = std::min(least, slack(i, k)); });
        matching_.row_dual[i] = least == kFar ? 0 : least;
      }
    }
  }

  void match_diagonal() {
#pragma omp parallel for num_threads(threads_) schedule(static)
    for (Vertex i = 0; i < pattern_.n; ++i) {
      const Offset k = find_slot(pattern_, i, i);
      if (k >= 0 && costs_[k] != kNoEdge && slack(i, k) == 0) match(i, i);
    }
  }

  /// Each free row takes a free column through a tight entry, or makes one free by moving the row that has it
  /// to another tight entry. `cursor` sees to it that no row is searched twice.
  void match_tight_entries() {
    std::vector<Offset> cursor(pattern_.offsets.begin(), pattern_.offsets.end() - 1);
    const auto free_tight_column = [&](Vertex row) {
      for (Offset& k = cursor[row]; k < pattern_.offsets[row + 1]; ++k) {
        const Vertex j = pattern_.columns[k];
        if (costs_[k] != kNoEdge && matching_.row_of_column[j] < 0 && slack(row, k) == 0) return j;
      }
      return Vertex(-1);
    };
    for (Vertex i = 0; i < pattern_.n; ++i) {
      if (matching_.column_of_row[i] >= 0) continue;
      const Vertex free = free_tight_column(i);
      if (free >= 0) {
        match(i, free);
        continue;
      }
      for (Offset k = pattern_.offsets[i]; k < pattern_.offsets[i + 1]; ++k) {
        if (costs_[k] == kNoEdge || slack(i, k) != 0) continue;
        const Vertex column = pattern_.columns[k], holder = matching_.row_of_column[column];
        const Vertex other = free_tight_column(holder);
        if (other < 0) continue;
        match(holder, other);
        match(i, column);
        break;
      }
    }
  }

  /// Augmenting row reduction (Jonker and Volgenant 1987): a free row takes its cheapest column, whose dual
  /// falls so far that the row's second is as cheap, and the row that had it looks for another at once, if
  /// the second is dearer. Rows whose two cheapest cost the same wait for the second pass. Where costs differ
  /// little, rows could outbid each other for long, so the steps are counted.
  void reduce_rows() {
    constexpr std::int64_t kSteps = 4;  // for each row
    std::int64_t left = kSteps * pattern_.n;
    std::vector<Vertex> waiting, displaced;
    for (Vertex i = 0; i < pattern_.n; ++i) {
      if (matching_.column_of_row[i] < 0) waiting.push_back(i);
    }
    for (int pass = 0; pass < 2; ++pass) {
      for (Vertex row : waiting) {
        bool goes_on = true;
        for (; row >= 0 && goes_on && left > 0; --left) row = take_cheapest(row, goes_on);
        if (row >= 0) displaced.push_back(row);
      }
      waiting.swap(displaced);
      displaced.clear();
    }
  }

  /// The row that had the column before, -1 where it was free; `row` itself where it has no two columns to
  /// choose from. `goes_on`: whether the row that is returned should look for another at once.
  Vertex take_cheapest(Vertex row, bool& goes_on) {
    Distance least = kFar, second = kFar;
    Vertex cheapest = -1;
    for_entries(row, [&](Offset k, Vertex j) {
      const Distance own = slack(row, k);
      const bool better = own < least || (own == least && matching_.row_of_column[j] < 0);
      second = better ? least : std::min(second, own);
      if (!better) return;
      least = own;
      cheapest = j;
    });
    goes_on = least < second && second < kFar;
    if (second == kFar) return row;
    const Vertex holder = matching_.row_of_column[cheapest];
    matching_.row_dual[row] += second;
    matching_.column_dual[cheapest] -= second - least;
    if (holder >= 0) matching_.column_of_row[holder] = -1;
    match(row, cheapest);
    return holder;
  }

  /// Dijkstra from a free row over alternating paths to the nearest free column; false where there is none.
  bool augment(Vertex root) {
    reached_.clear();
    heap_.clear();
    nearest_.clear();
    target_ = -1;
    target_distance_ = kFar;
    settled_.clear();
    Vertex row = root;
    Distance now = 0;
    while (true) {
      scan(row, now);
      const Vertex column = next_column(now);
      if (column < 0) break;
      row = matching_.row_of_column[column];
    }
    const bool found = target_ >= 0;
    if (found) {
      update_duals(root);
      flip_path(root);
    } else {
      // No free column can be reached from anywhere that this search has seen, now or later: never look
      // again.
      for (const Vertex j : reached_) dead_[j] = true;
    }
    for (const Vertex j : reached_) distance_[j] = kFar;
    return found;
  }

  void scan(Vertex row, Distance now) {
    for_entries(row, [&](Offset k, Vertex j) {
      if (dead_[j]) return;
      const Distance there = now + slack(row, k);
      if (there >= target_distance_ || there >= distance_[j]) return;
      reached_from_[j] = row;
      if (matching_.row_of_column[j] < 0) {
        target_ = j;
        target_distance_ = there;
        return;
      }
      if (distance_[j] == kFar) reached_.push_back(j);
      distance_[j] = there;
      if (there == now) {
        nearest_.push_back(j);  // nothing can be nearer: no need of the heap
      } else {
        heap_.emplace_back(-there, j);
        std::push_heap(heap_.begin(), heap_.end());
      }
    });
  }

  /// The nearest column that is not settled yet, with `now` moved on to it; -1 where the target is as near.
  Vertex next_column(Distance& now) {
    if (now >= target_distance_) return -1;
    if (!nearest_.empty()) {
      settled_.push_back(nearest_.back());
      nearest_.pop_back();
      return settled_.back();
    }
    while (!heap_.empty()) {
      const auto [minus_distance, column] = heap_.front();
      std::pop_heap(heap_.begin(), heap_.end());
      heap_.pop_back();
      if (-minus_distance != distance_[column]) continue;  // was reached on a shorter way since
      if (-minus_distance >= target_distance_) return -1;
      now = -minus_distance;
      settled_.push_back(column);
      return column;
    }
    return -1;
  }

  /// Afterwards all entries on the path are tight, and no slack has become negative.
  void update_duals(Vertex root) {
    matching_.row_dual[root] += target_distance_;
    for (const Vertex j : settled_) {
      const Distance shift = target_distance_ - distance_[j];
      matching_.column_dual[j] -= shift;
      matching_.row_dual[matching_.row_of_column[j]] += shift;
    }
  }

  void flip_path(Vertex root) {
    Vertex column = target_;
    while (true) {
      const Vertex row = reached_from_[column];
      const Vertex next = matching_.column_of_row[row];
      match(row, column);
      if (row == root) return;
      column = next;
    }
  }

  const Pattern& pattern_;
  const RawVector<Cost>& costs_;
  const int threads_;
  ProductMatching matching_;
  std::vector<bool> dead_;
  RawVector<Distance> distance_;    // by column, kFar where not reached
  RawVector<Vertex> reached_from_;  // column -> row
  std::vector<Vertex> reached_, nearest_, settled_;
  std::vector<std::pair<Distance, Vertex>> heap_;  // (-distance, column): the nearest on top
  Vertex target_ = -1;
  Distance target_distance_ = kFar;
};

double magnitude(double value) {
  return std::abs(value);
}
double magnitude(float value) {
  return std::abs(static_cast<double>(value));
}
template <class Real>
double magnitude(const std::complex<Real>& value) {
  return std::hypot(static_cast<double>(value.real()), static_cast<double>(value.imag()));
}

/// 2^exponent, -1022 ... 1023, without a call: one for each entry.
double power_of_two(int exponent) {
  const std::uint64_t bits = static_cast<std::uint64_t>(exponent + 1023) << 52;
  double power;
  std::memcpy(&power, &bits, sizeof power);
  return power;
}

}  // namespace

template <class Scalar>
RawVector<Cost> matching_costs(const Pattern& pattern, const Scalar* values,
                               const RawVector<Exponent>& exponents, const PowerScaling& scaling,
                               int threads) {
  if (values == nullptr) return RawVector<Cost>(pattern.columns.size(), 0);
  RawVector<Cost> costs(pattern.columns.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < pattern.n; ++i) {
    for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
      if (exponents[k] == kZeroEntry) {
        costs[k] = kNoEdge;
        continue;
      }
      // The entry is halved first: hypot of two huge parts would overflow. In two steps: 2^-1023 is denormal.
      const int half = exponents[k] / 2;
      const double near_one = magnitude(values[k] * static_cast<decltype(std::abs(values[k]))>(0.5)) *
                              power_of_two(-half) * power_of_two(half - exponents[k]);
      const int exponent =
          std::clamp(exponents[k] + scaling.row[i] + scaling.column[pattern.columns[k]], -1024, 1024);
      const double logarithm = exponent + 1 + std::log2(std::clamp(near_one, 0.25, 1.0));
      costs[k] = static_cast<Cost>(-std::lround(logarithm * kCostOfTwo));
    }
  }
  return costs;
}

#define MFS_INSTANTIATE(Scalar)                                                                      \
  template RawVector<Cost> matching_costs(const Pattern&, const Scalar*, const RawVector<Exponent>&, \
                                          const PowerScaling&, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

ProductMatching maximum_product_matching(const Pattern& pattern, const RawVector<Cost>& costs, int threads) {
  return Matcher(pattern, costs, threads).run();
}

}  // namespace mfs
