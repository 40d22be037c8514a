// How much memory the host has left for this process.
#pragma once

#include <cstddef>

namespace mfs {

/// Bytes that can be taken without driving the machine, the control group or the address-space limit of this
/// process out of memory: Linux grants more than it has and ends the process later, so the solver asks first.
std::size_t available_host_memory();

}  // namespace mfs
