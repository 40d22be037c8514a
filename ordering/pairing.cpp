#include "ordering/pairing.hpp"

#include <algorithm>

namespace mfs {
namespace {

constexpr int kWorst = -64;  // no quality below this: one hopeless pair must not outvote all others
constexpr int kPoorPair =
    -10;  // a pair whose off-diagonal product is below 2^-10 is no better than a weak diagonal
constexpr double kPoorShare = 0.1;

class Pairing {
 public:
  Pairing(const Pattern& pattern, const RawVector<Exponent>& exponents, const PowerScaling& scaling)
      : pattern_(pattern), exponents_(exponents), scaling_(scaling), pair_(pattern.n) {
    for (Vertex i = 0; i < pattern.n; ++i) pair_[i] = i;
  }

  void add_cycle(const std::vector<Vertex>& cycle) {
    if (cycle.size() < 2) return;
    measure(cycle);
    if (cycle.size() % 2 == 0) {
      pair_from(cycle, best_even_start());
    } else {
      pair_odd(cycle);
    }
  }

  Pairs take() {
    const bool poor = needed_ > 0 && poor_ > kPoorShare * needed_;
    if (poor) return {};
    WeakUnknowns weak = weak_unknowns();
    return {std::move(pair_), std::move(weak)};
  }

 private:
  bool weak(Vertex i) const { return exponent(i, i) < kWeakExponent; }

  /// Of each pair of a weak and a good diagonal the weak one, with the neighbours that would make as good a
  /// pair.
  WeakUnknowns weak_unknowns() const {
    WeakUnknowns result;
    result.begin.push_back(0);
    for (Vertex i = 0; i < pattern_.n; ++i) {
      const Vertex mate = pair_[i];
      if (mate == i || pair_[mate] != i || !weak(i) || weak(mate)) continue;
      result.unknown.push_back(i);
      result.partner.push_back(mate);
      for (Offset k = pattern_.offsets[i]; k < pattern_.offsets[i + 1]; ++k) {
        const Vertex j = pattern_.columns[k];
        if (j != i && j != mate && !weak(j) && exponent(i, j) + exponent(j, i) >= kPoorPair)
          result.partner.push_back(j);
      }
      result.begin.push_back(static_cast<Offset>(result.partner.size()));
    }
    return result;
  }

  int exponent(Vertex row, Vertex column) const {
    return std::max(scaled_exponent(pattern_, exponents_, scaling_, row, column), kWorst);
  }

  /// diagonal_[t]: entry (t, t); edge_[t]: product of the two entries between cycle[t] and cycle[t + 1].
  void measure(const std::vector<Vertex>& cycle) {
    const std::size_t length = cycle.size();
    diagonal_.resize(length);
    edge_.resize(length);
    for (std::size_t t = 0; t < length; ++t) {
      const Vertex here = cycle[t], next = cycle[(t + 1) % length];
      diagonal_[t] = std::min(exponent(here, here), 0);
      edge_[t] = std::clamp(exponent(here, next) + exponent(next, here), kWorst, 0);
    }
  }

  std::size_t best_even_start() const {
    long even = 0, odd = 0;
    for (std::size_t t = 0; t < edge_.size(); ++t) (t % 2 == 0 ? even : odd) += edge_[t];
    return even >= odd ? 0 : 1;
  }

  /// Pairs (start, start + 1), (start + 2, start + 3), ... around the cycle; an odd last one is left alone.
  void pair_from(const std::vector<Vertex>& cycle, std::size_t start) {
    const std::size_t length = cycle.size();
    for (std::size_t t = 0; t + 1 < length; t += 2) {
      const std::size_t a = (start + t) % length, b = (a + 1) % length;
      if (diagonal_[a] >= kWeakExponent && diagonal_[b] >= kWeakExponent) continue;
      ++needed_;
      if (edge_[a] < kPoorPair) ++poor_;
      pair_[cycle[a]] = cycle[b];
      pair_[cycle[b]] = cycle[a];
    }
  }

  /// Leaves out the vertex that makes the rest best: quality = its diagonal + the pairs that begin behind it.
  void pair_odd(const std::vector<Vertex>& cycle) {
    const std::size_t length = cycle.size();
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
    pair_from(cycle, (single + 1) % length);
    if (diagonal_[single] < kWeakExponent) join_neighbour(cycle, single);
  }

  /// A single with a weak diagonal joins what stands behind it: one unknown, or a pair (then three form one
  /// cycle).
  void join_neighbour(const std::vector<Vertex>& cycle, std::size_t single) {
    const Vertex first = cycle[single], second = cycle[(single + 1) % cycle.size()];
    pair_[first] = second;
    pair_[second] = pair_[second] == second ? first : pair_[second];
    if (pair_[second] != first) pair_[pair_[second]] = first;
  }

  const Pattern& pattern_;
  const RawVector<Exponent>& exponents_;
  const PowerScaling& scaling_;
  std::vector<Vertex> pair_;
  std::vector<int> diagonal_, edge_;
  Offset needed_ = 0, poor_ = 0;
};

}  // namespace

Pairs pair_unknowns(const Pattern& pattern, const RawVector<Exponent>& exponents, const PowerScaling& scaling,
                    const std::vector<Vertex>& row_of_column) {
  Pairing pairing(pattern, exponents, scaling);
  std::vector<bool> seen(pattern.n, false);
  std::vector<Vertex> cycle;
  for (Vertex start = 0; start < pattern.n; ++start) {
    cycle.clear();
    for (Vertex v = start; !seen[v]; v = row_of_column[v]) {
      seen[v] = true;
      cycle.push_back(v);
    }
    pairing.add_cycle(cycle);
  }
  return pairing.take();
}

}  // namespace mfs
