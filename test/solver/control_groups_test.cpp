// Limits of control groups, in trees of files that are made up.
#include "kernels/runtime/control_groups.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

namespace mfs::test {
namespace {

constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();

class ControlGroups : public testing::Test {
 protected:
  ControlGroups()
      : root_(std::filesystem::temp_directory_path() / ("mfs_groups_" + std::to_string(getpid()))) {}
  ~ControlGroups() override { std::filesystem::remove_all(root_); }

  void write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = root_ / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  void groups(const std::string& text) const { write("proc/self/cgroup", text); }
  int quota() const { return processor_quota(root_.c_str()); }
  std::size_t memory() const { return group_memory(root_.c_str()); }

 private:
  std::filesystem::path root_;
};

TEST_F(ControlGroups, NothingIsNoLimit) {
  EXPECT_EQ(quota(), 0);
  EXPECT_EQ(memory(), kUnlimited);
  groups("0::/\n");
  EXPECT_EQ(quota(), 0);
  EXPECT_EQ(memory(), kUnlimited);
}

TEST_F(ControlGroups, QuotaOfVersion2) {
  groups("0::/\n");
  for (const auto& [text, processors] : {std::pair{"max 100000\n", 0},
                                         {"200000 100000\n", 2},
                                         {"250000 100000\n", 3},
                                         {"100001 100000", 2},
                                         {"5000 100000\n", 1},
                                         {"0 100000\n", 0},
                                         {"-1 100000\n", 0},
                                         {"100000 0\n", 0},
                                         {"100000\n", 0},
                                         {"", 0},
                                         {"nonsense\n", 0}}) {
    write("sys/fs/cgroup/cpu.max", text);
    EXPECT_EQ(quota(), processors) << text;
  }
}

TEST_F(ControlGroups, TheTightestOfAllAbove) {
  groups("0::/pods.slice/pod-7/main\n");
  write("sys/fs/cgroup/pods.slice/cpu.max", "800000 100000\n");
  EXPECT_EQ(quota(), 8);
  write("sys/fs/cgroup/pods.slice/pod-7/cpu.max", "150000 50000\n");
  EXPECT_EQ(quota(), 3);
  write("sys/fs/cgroup/pods.slice/pod-7/main/cpu.max", "max 100000\n");
  EXPECT_EQ(quota(), 3);
  write("sys/fs/cgroup/pods.slice/pod-8/cpu.max", "100000 100000\n");
  EXPECT_EQ(quota(), 3) << "another's";
  write("sys/fs/cgroup/pods.slice/memory.max", "9000\n");
  write("sys/fs/cgroup/pods.slice/pod-7/memory.max", "max\n");
  write("sys/fs/cgroup/pods.slice/pod-7/main/memory.max", "8000\n");
  EXPECT_EQ(memory(), 8000U);
}

TEST_F(ControlGroups, QuotaOfVersion1) {
  groups("12:memory:/box\n4:cpuset:/\n3:cpu,cpuacct:/box/inner\n1:name=systemd:/box\n");
  write("sys/fs/cgroup/cpu/cpu.cfs_quota_us", "-1\n");
  write("sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000\n");
  write("sys/fs/cgroup/cpuset/cpu.cfs_quota_us", "100000\n");
  write("sys/fs/cgroup/cpuset/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(quota(), 0);
  write("sys/fs/cgroup/cpu/box/cpu.cfs_quota_us", "350000\n");
  write("sys/fs/cgroup/cpu/box/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(quota(), 4);
}

// In a container of version 1 the group has its name outside, which is not there inside.
TEST_F(ControlGroups, AGroupThatIsNotToBeSeen) {
  groups("3:cpuacct,cpu:/docker/f00\n2:memory:/docker/f00\n");
  write("sys/fs/cgroup/cpu/cpu.cfs_quota_us", "200000\n");
  write("sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "4096\n");
  EXPECT_EQ(quota(), 2);
  EXPECT_EQ(memory(), 4096U);
}

TEST_F(ControlGroups, FilesThatWouldBeDroppedCountAsFree) {
  groups("0::/\n");
  write("sys/fs/cgroup/memory.max", "10000\n");
  write("sys/fs/cgroup/memory.current", "9000\n");
  EXPECT_EQ(memory(), 1000U);
  write("sys/fs/cgroup/memory.stat",
        "anon 2000\nfile 7000\ninactive_anon 1\ninactive_file 5000\nactive_file 2000\n");
  EXPECT_EQ(memory(), 6000U);
  write("sys/fs/cgroup/memory.current", "20000\n");
  EXPECT_EQ(memory(), 0U);
  groups("2:memory:/\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "10000\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", "9000\n");
  write("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 3000\n");
  EXPECT_EQ(memory(), 4000U);
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  EXPECT_GT(memory(), std::size_t(1) << 60) << "what version 1 says for no limit";
}

}  // namespace
}  // namespace mfs::test
