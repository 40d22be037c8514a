// How many threads the integrator and the solver have on the host. Each has a team of its own, as the
// solver's loops start from a thread of its own. OpenMP's library (GCC's) keeps threads that wait for the
// next loop awake for some milliseconds, unless all teams together have more threads than there are
// processors: then they sleep at once, and to wake them takes longer than most of the thirty loops of an
// iteration do.
#pragma once

#include <algorithm>

#include <mfs/version.hpp>

namespace mfs::dae {

/// For each of the two teams where `asked` threads are wanted; 0: all. Of a backend with a device, whose
/// loops on the host are short, both fit on the processors; the factorizations of other backends are worth
/// all of them.
inline int host_threads(int asked, Backend backend, int processors) {
  if (backend_info(backend).memory == MemorySpace::host) return asked;
  const int most = std::max(processors / 2, 1);
  return asked > 0 ? std::min(asked, most) : most;
}

/// For the analysis of a matrix, while which the integrator's team has nothing to do; 0: as many as above.
inline int analysis_threads(int asked, Backend backend, int processors) {
  if (backend_info(backend).memory == MemorySpace::host) return 0;
  return asked > 0 ? std::min(asked, processors) : processors;
}

}  // namespace mfs::dae
