// When a fallback is active: from the factorization on that needs it, and left for one factorization after 1,
// 8 and 64 of those, as long as that is in vain.
#include "kernels/fallback.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mfs::test {
namespace {

/// Whether a factorization that needs it or not tries without it first.
bool tries_without(Fallback& fallback, bool needed) {
  fallback.begin();
  const bool tries = !fallback.active();
  if (needed) fallback.activate();
  fallback.end();
  return tries;
}

TEST(Fallback, IsLeftTheLessOftenTheMoreOftenThatWasInVain) {
  Fallback fallback;
  std::vector<int> tried;
  for (int k = 0; k < 260; ++k) {
    if (tries_without(fallback, true)) tried.push_back(k);
    EXPECT_TRUE(fallback.active());
  }
  EXPECT_EQ(tried, (std::vector<int>{0, 1, 9, 73, 137, 201}));
}

TEST(Fallback, IsForgottenOnceItIsNotNeeded) {
  Fallback fallback;
  EXPECT_TRUE(tries_without(fallback, false));
  for (int k = 0; k < 4; ++k) tries_without(fallback, true);
  EXPECT_FALSE(tries_without(fallback, false));
  for (int k = 0; k < 5; ++k) EXPECT_EQ(tries_without(fallback, false), k == 4);
  EXPECT_FALSE(fallback.active());
  std::vector<bool> tries;
  for (int k = 0; k < 10; ++k) tries.push_back(tries_without(fallback, true));
  EXPECT_EQ(tries, (std::vector<bool>{true, true, false, false, false, false, false, false, false, true}));
}

}  // namespace
}  // namespace mfs::test
