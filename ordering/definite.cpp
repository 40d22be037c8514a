#include "ordering/definite.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>

#include "ordering/number_parts.hpp"
#include "ordering/row_shares.hpp"

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

}  // namespace

template <class Scalar>
bool looks_definite(const Pattern& pattern, const Scalar* values, int threads) {
  const RowShares shares(pattern.n, threads);
  const DefiniteCheck<Scalar> check(pattern, values);
  std::atomic<bool> definite = true;
#pragma omp parallel for num_threads(shares.count()) schedule(static, 1)
  for (int share = 0; share < shares.count(); ++share) {
    for (Vertex i = shares.first_row(share); i < shares.first_row(share + 1) && definite; ++i)
      if (!check.passes(i)) definite = false;
  }
  return definite;
}

template bool looks_definite(const Pattern&, const float*, int);
template bool looks_definite(const Pattern&, const double*, int);
template bool looks_definite(const Pattern&, const std::complex<float>*, int);
template bool looks_definite(const Pattern&, const std::complex<double>*, int);

}  // namespace mfs
