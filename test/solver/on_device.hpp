// Tests on a device, skipped where there is none.
#pragma once

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include <mfs/mfs.hpp>

#include "test/reference/sparse.hpp"

namespace mfs::test {

/// A circulant. Where its diagonal is 0, the matching of one that is strong is of no use.
inline SparseMatrix circulant(double diagonal) {
  const std::int64_t n = 400;
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, diagonal});
    entries.push_back({i, (i * 7 + 3) % n, 1.0});
    entries.push_back({i, (i * 11 + 5) % n, 0.5});
  }
  return from_entries_summed(n, entries);
}

class OnDevice : public testing::Test {
 protected:
  void SetUp() override {
    const std::vector<Backend> usable = backends();
    if (std::count(usable.begin(), usable.end(), Backend::cuda) == 0) GTEST_SKIP() << "no CUDA device";
    options_.backend = Backend::cuda;
    options_.threads = 2;
  }

  Options options_;
};

}  // namespace mfs::test
