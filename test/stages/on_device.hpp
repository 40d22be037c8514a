// Tests that need a CUDA device; they are skipped where there is none.
#pragma once

#include <gtest/gtest.h>

#include "kernels/cuda/cuda_factors.hpp"
#include "kernels/runtime/engine.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {

class OnDeviceTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!cuda::device_found()) GTEST_SKIP() << "no CUDA device";
  }
  template <class Work>
  void on_device(const Work& work) {
    in_engine(1, [&] {
      Engine::use_cuda();
      work();
    });
  }
};

}  // namespace mfs::test
