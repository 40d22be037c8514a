// How many threads the program gives to each of its two teams.
#include "dae/program/host_threads.hpp"

#include <gtest/gtest.h>

namespace mfs::dae {
namespace {

TEST(HostThreads, OfBothTeamsFitOnTheProcessorsWithADevice) {
  EXPECT_EQ(host_threads(0, Backend::cuda, 16), 8);
  EXPECT_EQ(host_threads(16, Backend::cuda, 16), 8);
  EXPECT_EQ(host_threads(8, Backend::cuda, 16), 8);
  EXPECT_EQ(host_threads(3, Backend::cuda, 16), 3);
  EXPECT_EQ(host_threads(4, Backend::cuda, 1), 1);
}

TEST(HostThreads, AreAllThatAreAskedForOnTheHost) {
  for (const Backend backend : {Backend::serial, Backend::openmp}) {
    EXPECT_EQ(host_threads(0, backend, 16), 0);
    EXPECT_EQ(host_threads(16, backend, 16), 16);
  }
}

TEST(HostThreads, OfTheAnalysisAreAllWithADevice) {
  EXPECT_EQ(analysis_threads(0, Backend::cuda, 16), 16);
  EXPECT_EQ(analysis_threads(16, Backend::cuda, 16), 16);
  EXPECT_EQ(analysis_threads(32, Backend::cuda, 16), 16);
  EXPECT_EQ(analysis_threads(3, Backend::cuda, 16), 3);
  for (const Backend backend : {Backend::serial, Backend::openmp})
    EXPECT_EQ(analysis_threads(16, backend, 16), 0);
}

}  // namespace
}  // namespace mfs::dae
