// What a caller may choose, grouped by phase. The defaults are meant for everybody.
#pragma once

#include <functional>
#include <string>

#include <mfs/analysis_options.hpp>

namespace mfs {

enum class Backend { serial, openmp, cuda };

/// "serial", "openmp", "cuda".
inline const char* backend_name(Backend backend) {
  switch (backend) {
    case Backend::serial:
      return "serial";
    case Backend::openmp:
      return "openmp";
    case Backend::cuda:
      return "cuda";
  }
  return "unknown";
}

/// Precision of the factors. With `single` a double precision solver takes half the memory and less time;
/// every solution is refined to the asked accuracy all the same, and where that is not reached, the matrix is
/// factored again in full precision. `automatic` is `single` on a device whose double precision is more than
/// kSlowDouble times as slow (DeviceInfo::precision), else `full`.
enum class Precision { automatic, full, single };
constexpr int kSlowDouble = 8;

inline const char* precision_name(Precision precision) {
  switch (precision) {
    case Precision::automatic:
      return "automatic";
    case Precision::full:
      return "full";
    case Precision::single:
      return "single";
  }
  return "unknown";
}

struct FactorOptions {
  Precision precision = Precision::automatic;

  /// A pivot below pivot_tolerance times the largest entry of the scaled matrix is replaced by that bound,
  /// counted and remembered; 0 takes sqrt(machine epsilon).
  double pivot_tolerance = 0.0;
  /// Where the first factorization perturbs pivots, fronts that had to are merged into their parents, so that
  /// pivots are searched in larger blocks, and the matrix is factored again: at most this often.
  int max_reanalyses = 6;
};

struct SolveOptions {
  /// Componentwise backward error max_i |b - Ax|_i / (|A||x| + |b|)_i that every solution must reach; 0 takes
  /// 1e-12 in double precision, 1e-6 in single.
  double tolerance = 0.0;
  int max_refinement_steps = 10;
  /// Above 0, rows that hold nothing but rounding do not fail a solve: what row i is divided by in that error
  /// counts at least row_floor * max_j |x_j / c_j| / r_i, with the scales r and c of rows and columns, which
  /// is a part of what a row is whose largest entry meets the largest unknown of the scaled system. From 0 to
  /// 1, and 1 is close to what Arioli, Demmel and Duff (1989) do for such rows. For callers that need no
  /// accuracy in unknowns that are tiny beside the others, as Newton's method does not in corrections.
  double row_floor = 0.0;
};

/// Where the solver is: phase ("matching", "ordering", "symbolic", "factor", "solve") and the fraction done.
struct Progress {
  const char* phase;
  double fraction;
};

struct Options {
  AnalysisOptions analysis;
  FactorOptions factor;
  SolveOptions solve;
  Backend backend = Backend::openmp;
  /// Threads of every phase, BLAS included, at most 512; 0 takes default_threads() (mfs/threads.hpp).
  int threads = 0;
  /// Called from the thread that called the solver (a libmfs with MFS_KOKKOS=shared: or from one beside it,
  /// never from both at once); must not call the solver. Empty: nobody is told. What it throws ends the call
  /// and reaches the caller as it is, whatever its type (std::bad_alloc as OutOfMemory); the solver stays
  /// usable.
  std::function<void(const Progress&)> progress;
  /// Not empty: where analyze, factor, refactor or solve throws, the system is left as Matrix Market files
  /// PREFIX_A.mtx and, of a solve, PREFIX_b.mtx (the block of at most 16 right-hand sides that failed), over
  /// those of an earlier failure, and the error's text names them; if they cannot be written, it says so and
  /// why. Not for StateError, nor for vectors that solve does not accept.
  std::string dump_prefix;
  /// Receives one line of text per event at this level or below: 0 none, 1 phases, 2 details. The library
  /// itself never prints. What `log` throws is treated as what `progress` throws.
  int verbosity = 0;
  std::function<void(const std::string&)> log;
};

}  // namespace mfs
