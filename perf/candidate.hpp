// A solver that perf_device measures: the phases of a direct solver on one matrix, each of which has ended
// when its call returns. Every figure is taken by the same code (measure.hpp) for all of them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <mfs/options.hpp>

#include "cases/families.hpp"

namespace mfs::perf {

using cases::FamilyMatrix;

/// Right-hand sides of the larger solve.
constexpr int kColumns = 16;

/// A matrix with kColumns right-hand sides, n x kColumns column-major.
struct System {
  FamilyMatrix a;  ///< of a family or of a file
  std::vector<double> b;
};

struct AnalysisTime {
  double reorder = 0, symbolic = 0;  ///< s
};

/// What a solver says about its last factorization and solve.
struct Facts {
  std::string version;
  std::string vectors;              ///< where values, b and x of the timed calls lie: "host" or "device"
  std::int64_t factor_entries = 0;  ///< of L and U
  double flops = 0;
  std::int64_t device_bytes = 0;  ///< that it says it took, at its peak
  std::int64_t perturbed_pivots = 0;
  int refinement_steps = 0;
  std::int64_t segments = 0, bytes_out = 0, bytes_in = 0, bytes_back = 0;  ///< as mfs::Report has them
};

/// Calls come in this order; every one throws std::exception on a failure.
class Candidate {
 public:
  virtual ~Candidate() = default;
  virtual AnalysisTime analyze() = 0;
  virtual void factor() = 0;
  virtual void refactor() = 0;
  /// For the first `columns` right-hand sides.
  virtual void solve(int columns) = 0;
  /// The last solution, n x columns, to `x`.
  virtual void read_solution(int columns, double* x) = 0;
  /// Refines further solutions by `steps`; false where the solver refines by itself.
  virtual bool refine(int steps) = 0;
  virtual Facts facts() = 0;
  /// Of device memory: what a caller with so many columns holds itself, the matrix, b and x.
  virtual std::int64_t caller_bytes(int columns) const = 0;
};

/// MFS by its public class, with a limit of bytes where its factors lie on a device (0: none); values and
/// vectors of the caller do, too, then. `system` must outlive it.
std::unique_ptr<Candidate> make_mfs(const System& system, Backend backend, int threads,
                                    std::int64_t memory_limit = 0);

}  // namespace mfs::perf
