// Loops over indices on an execution space. Labels have at most 15 characters: a longer one would cost an
// allocation in every launch.
#pragma once

#include <Kokkos_Core.hpp>

#include "ordering/types.hpp"

namespace mfs {

/// Kokkos' space of many threads. A shared Kokkos may have none (Debian's Trilinos): then one thread does it
/// all.
#ifdef KOKKOS_ENABLE_OPENMP
using HostThreads = Kokkos::OpenMP;
#else
using HostThreads = Kokkos::Serial;
#endif

/// Calls body(i) for i = 0 ... count-1, in any order; the bodies are short and alike, or one per thread.
template <class Exec, class Body>
void for_each_index(const Exec& exec, const char* label, Offset count, const Body& body) {
  if (count == 0) return;
  Kokkos::parallel_for(label, Kokkos::RangePolicy<Exec, Kokkos::IndexType<Offset>>(exec, 0, count), body);
}

}  // namespace mfs
