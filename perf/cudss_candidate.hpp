// cuDSS as a candidate: general LU, reordering by host threads through its threading layer, matrix and
// vectors on the device.
#pragma once

#include <functional>
#include <string>

#include "perf/candidate.hpp"

namespace mfs::perf {

/// Loads libcudss and its threading layer from the folder `library`, and gives back what makes a candidate.
/// Throws std::runtime_error if they cannot be loaded, or if this program was built without cuDSS' headers.
std::function<std::unique_ptr<Candidate>(const System&)> load_cudss(const std::string& library, int threads);

}  // namespace mfs::perf
