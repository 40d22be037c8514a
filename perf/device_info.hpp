// What the benchmarks ask the CUDA runtime itself; a build without CUDA has no device and no bytes.
#pragma once

#include <cstdint>
#include <string>

namespace mfs::perf {

/// Name of the current device, "" where there is none.
std::string device_name();
/// Bytes of its memory that are taken, by any process, once all work that was given to it is done.
std::int64_t device_bytes_in_use();

}  // namespace mfs::perf
