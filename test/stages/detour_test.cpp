// When a way round is taken: from the factorization on that needs it, and left for one factorization after 1,
// 2, 4, ... and 64 of those, as long as that is in vain.
#include "kernels/cuda/detour.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mfs::test {
namespace {

/// Whether a factorization that needs the way round or not tries without it first.
bool tries_without(cuda::Detour& detour, bool needed) {
  detour.begin();
  const bool tries = !detour.taken();
  if (needed) detour.take();
  detour.end();
  return tries;
}

TEST(Detour, IsLeftTheLessOftenTheMoreOftenThatWasInVain) {
  cuda::Detour detour;
  std::vector<int> tried;
  for (int k = 0; k < 260; ++k) {
    if (tries_without(detour, true)) tried.push_back(k);
    EXPECT_TRUE(detour.taken());
  }
  EXPECT_EQ(tried, (std::vector<int>{0, 1, 3, 7, 15, 31, 63, 127, 191, 255}));
}

TEST(Detour, IsForgottenOnceItIsNotNeeded) {
  cuda::Detour detour;
  EXPECT_TRUE(tries_without(detour, false));
  for (int k = 0; k < 4; ++k) tries_without(detour, true);
  EXPECT_FALSE(tries_without(detour, false));
  for (int k = 0; k < 3; ++k) EXPECT_EQ(tries_without(detour, false), k == 2);
  EXPECT_FALSE(detour.taken());
  std::vector<bool> tries;
  for (int k = 0; k < 4; ++k) tries.push_back(tries_without(detour, true));
  EXPECT_EQ(tries, (std::vector<bool>{true, true, false, true}));
}

}  // namespace
}  // namespace mfs::test
