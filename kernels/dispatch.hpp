// How the stages spread their work: one team per front for the many small fronts of a depth, tiles for the
// few large ones. On the host a team is one thread. Labels have at most 15 characters: a longer one would
// cost an allocation in every launch.
#pragma once

#include <Kokkos_Core.hpp>

#include "ordering/types.hpp"

namespace mfs {

template <class Exec>
using TeamPolicy = Kokkos::TeamPolicy<Exec, Kokkos::Schedule<Kokkos::Dynamic>>;
template <class Exec>
using Team = typename TeamPolicy<Exec>::member_type;

template <class Exec>
constexpr bool kOnHost = std::is_same_v<typename Exec::memory_space, Kokkos::HostSpace>;

// A named functor, and a plain one: teams are for the host, the device has kernels of its own.
template <class Exec, class Body>
struct TeamBody {
  Body body;
  void operator()(const Team<Exec>& team) const { body(team, static_cast<Vertex>(team.league_rank())); }
};

/// Calls body(team, i) for i = 0 ... count-1, in any order, one team each; the bodies differ in length.
template <class Exec, class Body>
void for_each_team(const Exec& exec, const char* label, Vertex count, const Body& body) {
  if (count == 0) return;
  TeamPolicy<Exec> policy =
      kOnHost<Exec> ? TeamPolicy<Exec>(exec, count, 1) : TeamPolicy<Exec>(exec, count, Kokkos::AUTO);
  if (kOnHost<Exec>) policy.set_chunk_size(1);
  Kokkos::parallel_for(label, policy, TeamBody<Exec, Body>{body});
}

/// Calls body(i) for i = 0 ... count-1, in any order; the bodies are short and alike.
template <class Exec, class Body>
void for_each_index(const Exec& exec, const char* label, Offset count, const Body& body) {
  if (count == 0) return;
  Kokkos::parallel_for(label, Kokkos::RangePolicy<Exec, Kokkos::IndexType<Offset>>(exec, 0, count), body);
}

/// Calls body(i) for the indices of [begin, end), shared by the threads of a team.
template <class TeamMember, class Body>
void team_range(const TeamMember& team, Offset begin, Offset end, const Body& body) {
  Kokkos::parallel_for(Kokkos::TeamThreadRange(team, begin, end), body);
}

}  // namespace mfs
