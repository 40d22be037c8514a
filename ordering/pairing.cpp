#include "ordering/pairing.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "ordering/first_error.hpp"
#include "ordering/row_shares.hpp"

namespace mfs {
namespace {

constexpr int kWorst = -64;  // no quality below this: one hopeless pair must not outvote all others
constexpr int kPoorPair =
    -10;  // a pair whose off-diagonal product is below 2^-10 is no better than a weak diagonal
constexpr double kPoorShare = 0.1;

/// Exponents of scaled entries, none below kWorst.
class Sizes {
 public:
  Sizes(const Pattern& pattern, const RawVector<Exponent>& exponents, const PowerScaling& scaling,
        int threads)
      : pattern_(pattern),
        exponents_(exponents),
        scaling_(scaling),
        diagonal_(static_cast<std::size_t>(pattern.n)) {
#pragma omp parallel for num_threads(threads) schedule(static)
    for (Vertex i = 0; i < pattern.n; ++i) diagonal_[i] = entry(i, i);
  }
  int entry(Vertex row, Vertex column) const {
    return std::max(scaled_exponent(pattern_, exponents_, scaling_, row, column), kWorst);
  }
  int diagonal(Vertex i) const {
    return diagonal_[i];
  }
  bool weak(Vertex i) const {
    return diagonal(i) < kWeakExponent;
  }

 private:
  const Pattern& pattern_;
  const RawVector<Exponent>& exponents_;
  const PowerScaling& scaling_;
  RawVector<std::int32_t> diagonal_;
};

/// One cycle of a matching after the other. Different cycles may be paired at the same time.
class CyclePairing {
 public:
  CyclePairing(const Sizes& sizes, std::vector<Vertex>& pair) : sizes_(sizes), pair_(pair) {}

  /// `cycle` [length], at least 2 unknowns.
  void add(const Vertex* cycle, std::size_t length) {
    cycle_ = cycle;
    measure(length);
    if (length % 2 == 0) {
      pair_from(best_even_start());
    } else {
      pair_odd();
    }
  }
  Offset needed() const { return needed_; }
  Offset poor() const { return poor_; }

 private:
  /// diagonal_[t]: entry (t, t); edge_[t]: product of the two entries between cycle_[t] and cycle_[t + 1].
  void measure(std::size_t length) {
    diagonal_.resize(length);
    edge_.resize(length);
    for (std::size_t t = 0; t < length; ++t) {
      const Vertex here = cycle_[t], next = cycle_[(t + 1) % length];
      diagonal_[t] = std::min(sizes_.diagonal(here), 0);
      edge_[t] = std::clamp(sizes_.entry(here, next) + sizes_.entry(next, here), kWorst, 0);
    }
  }

  std::size_t best_even_start() const {
    long even = 0, odd = 0;
    for (std::size_t t = 0; t < edge_.size(); ++t) (t % 2 == 0 ? even : odd) += edge_[t];
    return even >= odd ? 0 : 1;
  }

  /// Pairs (start, start + 1), (start + 2, start + 3), ... around the cycle; an odd last one is left alone.
  void pair_from(std::size_t start) {
    const std::size_t length = edge_.size();
    for (std::size_t t = 0; t + 1 < length; t += 2) {
      const std::size_t a = (start + t) % length, b = (a + 1) % length;
      if (diagonal_[a] >= kWeakExponent && diagonal_[b] >= kWeakExponent) continue;
      ++needed_;
      if (edge_[a] < kPoorPair) ++poor_;
      pair_[cycle_[a]] = cycle_[b];
      pair_[cycle_[b]] = cycle_[a];
    }
  }

  /// Leaves out the vertex that makes the rest best: quality = its diagonal + the pairs that begin behind it.
  void pair_odd() {
    const std::size_t length = edge_.size();
    // The pairs behind vertex t are edges t+1, t+3, ..., t+length-2: moving t on by two takes edge t+1 out
    // and brings edge t+length = t in. An odd cycle is walked through completely by steps of two.
    long pairs = 0;
    for (std::size_t t = 1; t + 1 < length; t += 2) pairs += edge_[t];
    std::size_t single = 0, t = 0;
    long best = pairs + diagonal_[0];
    for (std::size_t step = 1; step < length; ++step) {
      pairs += edge_[t] - edge_[(t + 1) % length];
      t = (t + 2) % length;
      if (pairs + diagonal_[t] > best) {
        best = pairs + diagonal_[t];
        single = t;
      }
    }
    pair_from((single + 1) % length);
    if (diagonal_[single] < kWeakExponent) join_neighbour(single);
  }

  /// A single with a weak diagonal joins what stands behind it: one unknown, or a pair (then three form one
  /// cycle).
  void join_neighbour(std::size_t single) {
    const Vertex first = cycle_[single], second = cycle_[(single + 1) % edge_.size()];
    pair_[first] = second;
    pair_[second] = pair_[second] == second ? first : pair_[second];
    if (pair_[second] != first) pair_[pair_[second]] = first;
  }

  const Sizes& sizes_;
  std::vector<Vertex>& pair_;
  const Vertex* cycle_ = nullptr;
  std::vector<int> diagonal_, edge_;
  Offset needed_ = 0, poor_ = 0;
};

/// The cycles of a permutation that have more than one unknown, one behind the other.
struct Cycles {
  std::vector<Vertex> unknowns;
  std::vector<std::size_t> begin{0};
  Offset count() const { return static_cast<Offset>(begin.size()) - 1; }
};

Cycles long_cycles(const std::vector<Vertex>& permutation) {
  Cycles cycles;
  std::vector<bool> seen(permutation.size(), false);
  for (Vertex start = 0; start < static_cast<Vertex>(permutation.size()); ++start) {
    if (seen[start] || permutation[start] == start) continue;
    for (Vertex v = start; !seen[v]; v = permutation[v]) {
      seen[v] = true;
      cycles.unknowns.push_back(v);
    }
    cycles.begin.push_back(cycles.unknowns.size());
  }
  return cycles;
}

/// Empty where too many pairs are poor.
std::vector<Vertex> paired(const Cycles& cycles, const Sizes& sizes, Vertex n, int threads) {
  std::vector<Vertex> pair(static_cast<std::size_t>(n));
  std::iota(pair.begin(), pair.end(), 0);
  Offset needed = 0, poor = 0;
  FirstError error;
#pragma omp parallel num_threads(threads) reduction(+ : needed, poor)
  {
    CyclePairing pairing(sizes, pair);
#pragma omp for schedule(static)
    for (Offset c = 0; c < cycles.count(); ++c)
      error.attempt(
          [&] { pairing.add(&cycles.unknowns[cycles.begin[c]], cycles.begin[c + 1] - cycles.begin[c]); });
    needed += pairing.needed();
    poor += pairing.poor();
  }
  error.rethrow();
  if (static_cast<double>(poor) > kPoorShare * static_cast<double>(needed)) pair.clear();
  return pair;
}

/// Of each pair of a weak and a good diagonal the weak one, with the neighbours that would make as good a
/// pair: those among the unknowns from `first` on and before `end`.
WeakUnknowns weak_among(const Pattern& pattern, const Sizes& sizes, const std::vector<Vertex>& pair,
                        Vertex first, Vertex end) {
  WeakUnknowns found;
  for (Vertex i = first; i < end; ++i) {
    const Vertex mate = pair[i];
    if (mate == i || pair[mate] != i || !sizes.weak(i) || sizes.weak(mate)) continue;
    found.unknown.push_back(i);
    found.partner.push_back(mate);
    for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
      const Vertex j = pattern.columns[k];
      if (j != i && j != mate && !sizes.weak(j) && sizes.entry(i, j) + sizes.entry(j, i) >= kPoorPair)
        found.partner.push_back(j);
    }
    found.begin.push_back(static_cast<Offset>(found.partner.size()));
  }
  return found;
}

WeakUnknowns weak_unknowns(const Pattern& pattern, const Sizes& sizes, const std::vector<Vertex>& pair,
                           int threads) {
  const RowShares shares(pattern.n, threads);
  std::vector<WeakUnknowns> found(static_cast<std::size_t>(shares.count()));
  FirstError error;
#pragma omp parallel for num_threads(shares.threads()) schedule(static, 1)
  for (int share = 0; share < shares.count(); ++share)
    error.attempt([&] {
      found[share] = weak_among(pattern, sizes, pair, shares.first_row(share), shares.first_row(share + 1));
    });
  error.rethrow();
  WeakUnknowns all;
  all.begin.push_back(0);
  for (const WeakUnknowns& part : found) {
    const auto before = static_cast<Offset>(all.partner.size());
    all.unknown.insert(all.unknown.end(), part.unknown.begin(), part.unknown.end());
    all.partner.insert(all.partner.end(), part.partner.begin(), part.partner.end());
    for (const Offset end : part.begin) all.begin.push_back(before + end);
  }
  return all;
}

}  // namespace

Pairs pair_unknowns(const Pattern& pattern, const RawVector<Exponent>& exponents, const PowerScaling& scaling,
                    const std::vector<Vertex>& row_of_column, int threads) {
  const Sizes sizes(pattern, exponents, scaling, threads);
  std::vector<Vertex> pair = paired(long_cycles(row_of_column), sizes, pattern.n, threads);
  if (pair.empty()) return {};
  WeakUnknowns weak = weak_unknowns(pattern, sizes, pair, threads);
  return {std::move(pair), std::move(weak)};
}

}  // namespace mfs
