// Which factorization a backend means, whether it is there, and whether it has room.
#pragma once

#include <future>
#include <memory>

#include <mfs/options.hpp>

#include "accuracy/factorization.hpp"

namespace mfs {

/// Throws BackendError where this build or this machine lacks it.
void check_backend(Backend backend);

/// What its plans are made for.
AssemblyTurns assembly_turns(Backend backend);

/// Bytes left where the factors lie; inside Engine::run.
std::size_t available_memory(Backend backend);

/// What the backend may load beside the analysis of a matrix with this pattern. The future ends when that
/// has.
template <class Scalar>
std::future<void> load_beside(Backend backend, bool single_precision, const Pattern& pattern);

/// The factorization that `backend` means. Throws OutOfMemory before it takes what is not there. Inside
/// Engine::run, with `threads` the number given there.
template <class Scalar>
std::unique_ptr<Factorization<Scalar>> make_numeric_factorization(Backend backend, bool single_precision,
                                                                  std::shared_ptr<const SymbolicPlan> plan,
                                                                  std::shared_ptr<const Pattern> pattern,
                                                                  int threads);

}  // namespace mfs
