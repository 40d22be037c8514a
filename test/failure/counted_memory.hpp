// Every operator new of this process is counted and can be made to fail. libmfs.so takes these as well, as it
// imports operator new.
#pragma once

#include <cstddef>

namespace mfs::test {

/// Counts from here on; the `fail_at`-th allocation (from 0; -1: none) throws std::bad_alloc.
void start_counting(long fail_at = -1);
/// From here on every allocation of at least `bytes` throws.
void fail_large_ones(std::size_t bytes);
/// Stops both; returns the number of allocations since start_counting.
long stop_counting();
/// Whether an allocation was made to fail since start_counting or fail_large_ones.
bool one_has_failed();
/// Blocks that are allocated now, and their bytes.
long live_blocks();
std::size_t live_bytes();

/// Since restart_marks: the most bytes that were allocated at a time, and the largest single request.
void restart_marks();
std::size_t peak_bytes();
std::size_t largest_request();

}  // namespace mfs::test
