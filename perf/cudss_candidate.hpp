// cuDSS as a candidate: general LU, reordering by host threads through its threading layer, matrix and
// vectors on the device.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "perf/candidate.hpp"

namespace mfs::perf {

/// Loads libcudss and its threading layer from the folder `library`, and gives back what makes a candidate.
/// With a `memory_limit` in bytes of the device, in cuDSS' hybrid memory mode. Throws std::runtime_error if
/// they cannot be loaded, or if this program was built without cuDSS' headers.
std::function<std::unique_ptr<Candidate>(const System&)> load_cudss(const std::string& library, int threads,
                                                                    std::int64_t memory_limit = 0);

}  // namespace mfs::perf
