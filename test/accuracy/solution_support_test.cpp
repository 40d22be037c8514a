// Which unknowns may differ from zero, beside what elimination modulo a prime makes of random values: there a
// number that is zero by chance is next to impossible, and nothing is rounded.
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "accuracy/solution_support.hpp"
#include "test/reference/random.hpp"
#include "test/reference/sparse.hpp"
#include "test/stages/artificial_problem.hpp"

namespace mfs::test {
namespace {

using Numbers = std::vector<std::uint64_t>;
constexpr std::uint64_t kPrime = 2147483629;

std::uint64_t inverse_of(std::uint64_t a) {
  std::uint64_t result = 1;
  for (std::uint64_t power = kPrime - 2; power > 0; power /= 2, a = a * a % kPrime)
    if (power % 2 == 1) result = result * a % kPrime;
  return result;
}

/// A^-1 b; empty where A is singular.
Numbers solved(std::vector<Numbers> a, Numbers b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    while (pivot < n && a[pivot][k] == 0) ++pivot;
    if (pivot == n) return {};
    std::swap(a[pivot], a[k]);
    std::swap(b[pivot], b[k]);
    const std::uint64_t inverse = inverse_of(a[k][k]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const std::uint64_t minus = kPrime - a[i][k] * inverse % kPrime;
      for (std::size_t j = k; j < n; ++j) a[i][j] = (a[i][j] + minus * a[k][j]) % kPrime;
      b[i] = (b[i] + minus * b[k]) % kPrime;
    }
  }
  for (std::size_t k = 0; k < n; ++k) b[k] = b[k] * inverse_of(a[k][k]) % kPrime;
  return b;
}

std::vector<char> support_of(const SparseMatrix& a, const std::vector<char>& b, bool transposed) {
  const Pattern pattern = pattern_of(a);
  RawVector<Cost> costs(a.values.size());
  for (std::size_t k = 0; k < costs.size(); ++k) costs[k] = a.values[k] == 0 ? kNoEdge : 0;
  return SolutionSupport(pattern, std::move(costs)).of(b, transposed);
}

TEST(SolutionSupport, IsThatOfRandomValues) {
  Random random(1);
  int reducible = 0, singular = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const std::int64_t n = random.integer(1, 13);
    std::vector<Entry> entries;
    const std::vector<std::int64_t> place = random.permutation(n);
    const double density = random.unit() * 3 / static_cast<double>(n);
    for (std::int64_t i = 0; i < n; ++i)
      for (std::int64_t j = 0; j < n; ++j)
        if ((j == place[i] && random.chance(0.97)) || random.chance(density))
          entries.push_back({i, j, random.chance(0.1) ? 0.0 : 1.0});
    const SparseMatrix a = from_entries(n, entries);
    std::vector<char> b(static_cast<std::size_t>(n));
    for (char& entry : b) entry = random.chance(0.3);
    for (const bool transposed : {false, true}) {
      std::vector<Numbers> dense(b.size(), Numbers(b.size()));
      Numbers right_side;
      for (const Entry& e : entries)
        if (e.value != 0)
          (transposed ? dense[e.column][e.row] : dense[e.row][e.column]) = random.integer(1, kPrime);
      for (const char entry : b) right_side.push_back(entry ? random.integer(1, kPrime) : 0);
      const Numbers x = solved(dense, right_side);
      const std::vector<char> found = support_of(a, b, transposed);
      if (x.empty()) {
        ++singular;
        EXPECT_TRUE(found.empty());
        continue;
      }
      std::vector<char> expected;
      for (const std::uint64_t entry : x) expected.push_back(entry != 0);
      if (std::find(expected.begin(), expected.end(), false) == expected.end()) {
        EXPECT_TRUE(found.empty());
      } else {
        ++reducible;
        EXPECT_EQ(found, expected) << "trial " << trial << (transposed ? ", A^T" : "");
      }
    }
  }
  EXPECT_GT(reducible, 1000);
  EXPECT_GT(singular, 300);
}

// Without recursion, and in linear time.
TEST(SolutionSupport, OfALongChain) {
  const std::int64_t n = 300000;
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, 1.0});
    if (i > 0) entries.push_back({i, i - 1, 1.0});
  }
  const SparseMatrix a = from_entries(n, entries);
  std::vector<char> b(n, false);
  b[1000] = true;
  const std::vector<char> forward = support_of(a, b, false), back = support_of(a, b, true);
  EXPECT_EQ(std::count(forward.begin(), forward.end(), true), n - 1000);
  EXPECT_TRUE(forward[1000] && !forward[999]);
  EXPECT_EQ(std::count(back.begin(), back.end(), true), 1001);
}

}  // namespace
}  // namespace mfs::test
