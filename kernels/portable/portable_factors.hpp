// The factors in the memory of Kokkos' default execution space, whichever that is: threads of the host, or a
// device. Its kernels are one source for all spaces.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "kernels/factors.hpp"

namespace mfs::portable {

/// The name that Kokkos gives the space.
const char* space_name();
/// Whether its kernels work in the memory of the host.
bool on_host();
/// Whether more than one of its threads can be of use.
bool has_threads();
/// Bytes free in its memory, if that is a device's; inside Engine::run.
std::size_t free_memory();

/// Bytes of the space's memory that factors of this plan will take, a library's left out.
template <class Value>
Offset bytes_needed(bool single_precision, const SymbolicPlan& plan, const Pattern& pattern, int threads);

/// As make_host_factors; also throws OutOfMemory(device) and BackendError. Calls check(bytes) before it takes
/// so many.
template <class Value>
std::unique_ptr<Factors<Value>> make_portable_factors(bool single_precision,
                                                      std::shared_ptr<const SymbolicPlan> plan,
                                                      std::shared_ptr<const Pattern> pattern, int threads,
                                                      const std::function<void(Offset)>& check);

}  // namespace mfs::portable
