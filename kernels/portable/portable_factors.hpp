// The factors in the memory of Kokkos' default execution space, whichever that is: threads of the host, or a
// device. Its kernels are one source for all spaces.
#pragma once

#include <cstddef>
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

/// The launches for the factors of this plan. What a library takes is left out of the bytes. `make` is as
/// make_host_factors, and throws OutOfMemory(device) and BackendError as well.
template <class Value>
Planned<Factors<Value>> plan_portable_factors(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                              std::shared_ptr<const Pattern> pattern, int threads);

}  // namespace mfs::portable
