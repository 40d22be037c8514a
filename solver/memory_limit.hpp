// How much memory the host has left for this process.
#pragma once

#include <cstddef>
#include <new>
#include <stdexcept>

#include <mfs/error.hpp>

namespace mfs {

/// Bytes that can be taken without driving the machine, the control group or the address-space limit of this
/// process out of memory: Linux grants more than it has and ends the process later, so the solver asks first.
std::size_t available_host_memory();

/// Returns what `call` does; std::bad_alloc becomes OutOfMemory, and so does the length of a vector that no
/// memory could hold.
template <class Call>
auto told_as_out_of_memory(const Call& call) {
  try {
    return call();
  } catch (const std::bad_alloc&) {
    throw OutOfMemory(MemorySpace::host, 0, available_host_memory());
  } catch (const std::length_error&) {
    throw OutOfMemory(MemorySpace::host, 0, available_host_memory());
  }
}

}  // namespace mfs
