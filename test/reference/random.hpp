// Random numbers that are the same on every machine: std::mt19937_64 is fixed by the standard, its
// distributions are not.
#pragma once

#include <complex>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace mfs::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [0, 1).
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// In [-1, 1), never 0.
  double entry() {
    const double value = 2 * unit() - 1;
    return value == 0 ? 0.5 : value;
  }
  /// In [begin, end).
  std::int64_t integer(std::int64_t begin, std::int64_t end) {
    return begin + static_cast<std::int64_t>(engine_() % static_cast<std::uint64_t>(end - begin));
  }
  bool chance(double probability) { return unit() < probability; }

  template <class Integer>
  std::vector<Integer> permutation(Integer n) {
    std::vector<Integer> order(static_cast<std::size_t>(n));
    std::iota(order.begin(), order.end(), Integer(0));
    for (std::int64_t i = n - 1; i > 0; --i) std::swap(order[i], order[integer(0, i + 1)]);
    return order;
  }
  /// Entries in [-1, 1), of a complex vector both parts.
  template <class Scalar = double>
  std::vector<Scalar> vector(std::int64_t n) {
    std::vector<Scalar> v(static_cast<std::size_t>(n));
    for (Scalar& value : v) draw(value);
    return v;
  }

 private:
  template <class Real>
  void draw(Real& value) {
    value = static_cast<Real>(entry());
  }
  template <class Real>
  void draw(std::complex<Real>& value) {
    const auto real = static_cast<Real>(entry());
    value = {real, static_cast<Real>(entry())};
  }

  std::mt19937_64 engine_;
};

}  // namespace mfs::test
