#include "ordering/definite.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>

#include "ordering/number_parts.hpp"

namespace mfs {

namespace {

/// What rounding may leave of entries that would be equal, relative to sqrt(a_ii a_jj).
constexpr double kRounding = 1e-10;
template <class Scalar>
constexpr double kTolerance = sizeof(typename NumberParts<Scalar>::type) == sizeof(float) ? 1e-5 : kRounding;

template <class Scalar>
class DefiniteCheck {
 public:
  DefiniteCheck(const Pattern& pattern, const Scalar* values)
      : pattern_(pattern), values_(values), sign_(std::real(value(0, 0)) < 0 ? -1 : 1) {}

  bool passes(Vertex i) const {
    const double own = diagonal(i);
    if (!(own > 0)) return false;
    for (Offset slot = pattern_.offsets[i]; slot < pattern_.offsets[i + 1]; ++slot) {
      const Vertex j = pattern_.columns[slot];
      if (j <= i) continue;
      const double size = std::sqrt(own) * std::sqrt(std::max(diagonal(j), 0.0));
      const Scalar upper = values_[slot], lower = value(j, i);
      if (!(std::abs(upper) <= (1 + kTolerance<Scalar>)*size)) return false;
      if (!(std::abs(upper - conjugated(lower)) <= kTolerance<Scalar> * size)) return false;
    }
    return lower_entries(i);
  }

 private:
  // Zero where there is none.
  Scalar value(Vertex i, Vertex j) const {
    const Offset slot = slot_of(i, j);
    return slot < 0 ? Scalar(0) : values_[slot];
  }
  double diagonal(Vertex i) const { return sign_ * std::real(value(i, i)); }
  Offset slot_of(Vertex i, Vertex j) const {
    const auto begin = pattern_.columns.begin() + pattern_.offsets[i],
               end = pattern_.columns.begin() + pattern_.offsets[i + 1];
    const auto found = std::lower_bound(begin, end, j);
    return found == end || *found != j ? -1 : found - pattern_.columns.begin();
  }
  // Those without an entry opposite are not seen from there.
  bool lower_entries(Vertex i) const {
    for (Offset slot = pattern_.offsets[i]; slot < pattern_.offsets[i + 1]; ++slot) {
      const Vertex j = pattern_.columns[slot];
      if (j < i && values_[slot] != Scalar(0) && slot_of(j, i) < 0) return false;
    }
    return true;
  }

  const Pattern& pattern_;
  const Scalar* values_;
  double sign_;
};

// Whether all rows pass; not all are looked at where one does not.
template <class Passes>
bool all_rows(Vertex n, int threads, const Passes& passes) {
  constexpr Vertex kRows = 4096;
  std::atomic<bool> all = true;
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex block = 0; block < n / kRows + 1; ++block) {
    for (Offset i = Offset{block} * kRows, end = std::min<Offset>(i + kRows, n); i < end && all; ++i)
      if (!passes(static_cast<Vertex>(i))) all = false;
  }
  return all;
}

}  // namespace

template <class Scalar>
bool looks_definite(const Pattern& pattern, const Scalar* values, int threads) {
  const DefiniteCheck<Scalar> check(pattern, values);
  return all_rows(pattern.n, threads, [&](Vertex i) { return check.passes(i); });
}

template <class Scalar>
bool rows_are_dominated(const Pattern& pattern, const std::vector<Vertex>& row_order, const Scalar* values,
                        int threads) {
  return all_rows(pattern.n, threads, [&](Vertex i) {
    double own = 0, others = 0;
    for (Offset slot = pattern.offsets[i]; slot < pattern.offsets[i + 1]; ++slot) {
      const Vertex j = pattern.columns[slot];
      const bool matched = (row_order.empty() ? j : row_order[j]) == i;
      (matched ? own : others) += std::abs(values[slot]);
    }
    return others <= (1 + kTolerance<Scalar>)*own;
  });
}

#define MFS_INSTANTIATE(S)                                     \
  template bool looks_definite(const Pattern&, const S*, int); \
  template bool rows_are_dominated(const Pattern&, const std::vector<Vertex>&, const S*, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
