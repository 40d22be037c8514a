#include "tiny_system.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace {
mfs::Options two_threads() {
  mfs::Options options;
  options.threads = 2;
  return options;
}
}  // namespace

TinySystem::TinySystem() : row_offsets_{0}, solver_(two_threads()) {
  for (int i = 0; i < n; ++i) {
    for (int j = std::max(i - 1, 0); j <= std::min(i + 1, n - 1); ++j) {
      columns_.push_back(j);
      values_.push_back(i == j ? 4.0 : -1.0);
    }
    row_offsets_.push_back(static_cast<int>(columns_.size()));
  }
  matrix_ = {n, n, row_offsets_.data(), columns_.data(), values_.data()};
  solver_.factor(matrix_);
}

bool TinySystem::solve() {
  std::vector<double> b(n, 2.0), x(n);
  b.front() = b.back() = 3.0;
  solver_.refactor(matrix_);
  solver_.solve(b.data(), x.data());
  for (double value : x) {
    if (!(std::fabs(value - 1.0) < 1e-12)) return false;
  }
  return true;
}
