// Tests on a device, skipped where there is none.
#pragma once

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include <mfs/mfs.hpp>

namespace mfs::test {

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
