// Backends as objects: which options each obeys, what its plans are made for, where its factors lie and
// whether there is room, and how they are made. Nothing else in the solver asks which backend it is.
#pragma once

#include <cstddef>
#include <future>
#include <memory>
#include <string>

#include <mfs/options.hpp>
#include <mfs/version.hpp>

#include "accuracy/factorization.hpp"
#include "solver/analysis.hpp"

namespace mfs {

/// What does not depend on the kind of numbers.
class BackendRules {
 public:
  virtual ~BackendRules() = default;
  /// As the function backend_info() says.
  virtual BackendInfo info() const = 0;
  /// Whether this build and this machine have it.
  virtual bool present() const { return true; }
  /// Throws InvalidInput for an option that it cannot obey, BackendError unless it is present.
  virtual void check(const Options&) const {}
  /// Whether every phase has one thread, whatever is asked for.
  virtual bool one_thread() const { return false; }
  /// Whether its work starts kernels of Kokkos.
  virtual bool uses_kokkos() const { return false; }
  /// What Precision::automatic is.
  virtual Precision automatic_precision() const { return Precision::full; }
  /// Of `threads` at work.
  virtual PlanNeeds plan_needs(int threads) const { return host_needs(threads); }
  /// Bytes left where its factors lie; inside Engine::run.
  virtual std::size_t available_memory() const;
};

const BackendRules& rules_of(Backend backend);

/// Bytes where the factors lie: Options::memory_limit, and what factors hold that will be gone before others
/// are made; and Options::out_of_core_dir.
struct MemoryRoom {
  Offset limit = 0, held = 0;
  std::string out_of_core_dir{};
};

template <class Scalar>
class BackendFor : public BackendRules {
 public:
  /// What it may load beside the analysis of a matrix with this pattern. The future ends when that has.
  virtual std::future<void> load_beside(bool single_precision, const Pattern& pattern) const;
  /// The factors of a plan and the ladder over them. Throws OutOfMemory where no plan obeys a limit. `make`
  /// throws OutOfMemory before it takes what is not there, and is called inside Engine::run with `threads`.
  virtual Planned<Factorization<Scalar>> plan(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                              std::shared_ptr<const Pattern> pattern, int threads,
                                              const MemoryRoom& room) const = 0;
};

template <class Scalar>
const BackendFor<Scalar>& backend_for(Backend backend);

}  // namespace mfs
