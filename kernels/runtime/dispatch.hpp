// Loops over indices on an execution space. Labels have at most 15 characters: a longer one would cost an
// allocation in every launch.
#pragma once

#include <limits>

#include <Kokkos_Core.hpp>

#include "kernels/runtime/team.hpp"
#include "ordering/types.hpp"

namespace mfs {

#ifdef MFS_SHARED_KOKKOS
/// The program's Kokkos starts all loops, and its profiler sees them. It may have no space of many threads
/// (Debian's Trilinos): then one thread does it all.
using OneThread = Kokkos::Serial;
#ifdef KOKKOS_ENABLE_OPENMP
using HostThreads = Kokkos::OpenMP;
#else
using HostThreads = Kokkos::Serial;
#endif
#else
/// The thread that calls. Unlike Kokkos' Serial, which has one scratch memory for a process, any number of
/// threads may be at work in it.
struct OneThread {
  void fence() const {}
};
/// The threads of the team at work in the thread that calls: several teams may be at work at the same time,
/// as Kokkos' OpenMP space cannot.
struct HostThreads {
  void fence() const {}
};
#endif

/// Calls body(i) for i = 0 ... count-1, in any order; the bodies are short and alike, or one per thread.
template <class Exec, class Body>
void for_each_index(const Exec& exec, const char* label, Offset count, const Body& body) {
  if (count == 0) return;
  Kokkos::parallel_for(label, Kokkos::RangePolicy<Exec, Kokkos::IndexType<Offset>>(exec, 0, count), body);
}

/// Takes a maximum to a place in the memory of Exec, without waiting for it.
template <class Exec>
auto maximum_at(double* place) {
  using Space = typename Exec::memory_space;
  return Kokkos::Max<double, Space>(Kokkos::View<double, Space>(place));
}

/// *place = the largest `most` that body(i, most) leaves, i = 0 ... count-1.
template <class Exec, class Body>
void find_maximum(const Exec& exec, const char* label, Offset count, const Body& body, double* place) {
  Kokkos::parallel_reduce(label, Kokkos::RangePolicy<Exec, Kokkos::IndexType<Offset>>(exec, 0, count), body,
                          maximum_at<Exec>(place));
}

/// The sum of what body(i, sum) adds, i = 0 ... count-1; with the same number of threads always in the same
/// order.
template <class Sum, class Exec, class Body>
Sum find_sum(const Exec& exec, const char* label, Offset count, const Body& body) {
  Sum sum(0);
  Kokkos::parallel_reduce(label, Kokkos::RangePolicy<Exec, Kokkos::IndexType<Offset>>(exec, 0, count), body,
                          sum);
  return sum;
}

#ifndef MFS_SHARED_KOKKOS
template <class Body>
void for_each_index(const OneThread&, const char*, Offset count, const Body& body) {
  for (Offset i = 0; i < count; ++i) body(i);
}

template <class Body>
void for_each_index(const HostThreads&, const char*, Offset count, const Body& body) {
#pragma omp parallel for num_threads(team_threads()) schedule(static)
  for (Offset i = 0; i < count; ++i) body(i);
}

template <class Body>
void find_maximum(const OneThread&, const char*, Offset count, const Body& body, double* place) {
  double most = std::numeric_limits<double>::lowest();
  for (Offset i = 0; i < count; ++i) body(i, most);
  *place = most;
}

template <class Body>
void find_maximum(const HostThreads&, const char*, Offset count, const Body& body, double* place) {
  double most = std::numeric_limits<double>::lowest();
#pragma omp parallel for num_threads(team_threads()) schedule(static) reduction(max : most)
  for (Offset i = 0; i < count; ++i) body(i, most);
  *place = most;
}

template <class Sum, class Body>
Sum find_sum(const OneThread&, const char*, Offset count, const Body& body) {
  Sum sum(0);
  for (Offset i = 0; i < count; ++i) body(i, sum);
  return sum;
}

// Parts are added in their order, as OpenMP's own sum is not.
template <class Sum, class Body>
Sum find_sum(const HostThreads&, const char*, Offset count, const Body& body) {
  constexpr Offset kParts = 64;
  Sum parts[kParts];
#pragma omp parallel for num_threads(team_threads()) schedule(static)
  for (Offset part = 0; part < kParts; ++part) {
    Sum sum(0);
    for (Offset i = count * part / kParts; i < count * (part + 1) / kParts; ++i) body(i, sum);
    parts[part] = sum;
  }
  Sum sum(0);
  for (const Sum& part : parts) sum += part;
  return sum;
}
#endif

}  // namespace mfs
