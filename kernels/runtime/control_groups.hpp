// What the control groups of this process leave it of processors and memory: a container's limits, which
// neither the affinity mask nor /proc/meminfo shows. Both versions of Linux' interface are read, from the
// group of the process up to the root, as each of them may set a limit:
//
//   version 2    /sys/fs/cgroup/<group>/cpu.max, memory.max, memory.current, memory.stat
//   version 1    /sys/fs/cgroup/cpu/<group>/cpu.cfs_quota_us, cpu.cfs_period_us
//                /sys/fs/cgroup/memory/<group>/memory.limit_in_bytes, memory.usage_in_bytes, memory.stat
//
// /proc/self/cgroup names the groups. Nothing is allocated: it is asked when there may be nothing left.
// Source: Linux' Documentation/admin-guide/cgroup-v2.rst, cgroup-v1/memory.rst, scheduler/sched-bwc.rst.
#pragma once

#include <cstddef>

namespace mfs {

/// Processors whose whole time the groups grant, rounded up, at least 1; 0 where none sets a limit. `root`:
/// of the file system that has /proc and /sys.
int processor_quota(const char* root = "");

/// Bytes that the groups leave; the largest number where none sets a limit. Files that the kernel holds in
/// memory and would drop first count as free.
std::size_t group_memory(const char* root = "");

}  // namespace mfs
