// What a caller may choose, grouped by phase. The defaults are meant for everybody.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <mfs/analysis_options.hpp>

namespace mfs {

/// Where the numeric phases run: one thread of the host, its threads, an NVIDIA GPU, or (kokkos) the
/// execution space that the Kokkos inside the library has by default, a device where it was built for one, by
/// kernels that are one source for all spaces.
enum class Backend { serial, openmp, cuda, kokkos };

/// "serial", "openmp", "cuda", "kokkos"; "unknown" for any other value.
inline const char* backend_name(Backend backend) {
  switch (backend) {
    case Backend::serial:
      return "serial";
    case Backend::openmp:
      return "openmp";
    case Backend::cuda:
      return "cuda";
    case Backend::kokkos:
      return "kokkos";
  }
  return "unknown";
}

/// Precision of the factors. Factors of `single` precision take half the memory and less time in a double
/// precision solver. Every solution is refined to the same tolerance. Where that is not reached, the matrix
/// is factored again in full precision. `automatic` is `single` on a device whose double precision is more
/// than kSlowDouble times as slow (DeviceInfo::precision), else `full`.
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

  /// A pivot below pivot_tolerance times the largest entry of the scaled matrix is perturbed: it is replaced
  /// by that bound, counted and remembered. 0 means sqrt(machine epsilon).
  double pivot_tolerance = 0.0;
  /// Where the first factorization perturbs pivots, they are moved to fronts above, where more rows are
  /// searched, and the matrix is factored again: at most this often. So it is, and the values are matched
  /// anew, where solves for later values have become dearer: at most this often each.
  int max_reanalyses = 6;
};

struct SolveOptions {
  /// Componentwise backward error max_i |b - Ax|_i / (|A||x| + |b|)_i that every solution must reach (Oettli
  /// and Prager 1964). Of a residual, 8 |A| 1 times the least number (4.9e-324; 1.4e-45 in single) counts
  /// as zero, as unknowns have no digits below. 0 means 1e-12 in double precision, 1e-6 in single.
  double tolerance = 0.0;
  /// Steps of iterative refinement at most. 0 means that neither refinement nor FGMRES is tried.
  int max_refinement_steps = 10;
  /// Lower bound of the divisor of row i in that error, from 0 (none) to 1: row_floor * max_j |x_j / c_j| /
  /// r_i, with the scales r and c of rows and columns. 1 is the size of a row whose largest entry meets the
  /// largest unknown of the scaled system; Arioli, Demmel and Duff (1989) do about the same for rows of
  /// rounding. A bound above 0 is for callers that need no accuracy in unknowns that are tiny beside the
  /// others, as Newton's method needs none in corrections: rows that hold only such unknowns then fail no
  /// solve.
  double row_floor = 0.0;
  /// Where the matrix is singular to working precision, solve throws SingularMatrix. With this it returns a
  /// solution whose backward error reaches the tolerance all the same, if one is found, and
  /// Report::singularity tells: the exact solution of a system as near as rounding, but not the only one.
  bool solve_singular = false;
};

/// The phase that runs ("matching", "ordering", "symbolic", "factor", "solve"), and the fraction of it that
/// is done, from 0 to 1.
struct Progress {
  const char* phase;
  double fraction;
};

struct Options {
  AnalysisOptions analysis;
  FactorOptions factor;
  SolveOptions solve;
  Backend backend = Backend::openmp;
  /// Bytes that the factors and all that goes with them (Report::bytes_peak) may take where the factors lie;
  /// 0: all that are free. Of Backend::kokkos no limit may be set.
  ///
  /// In a device's memory, for Backend::cuda: right after the analysis it is known whether everything fits
  /// there. Where it does not, factors that have been made lie in page-locked memory of the host, are copied
  /// beside the work on others, and come back in each solve (Report::partial). The solutions are the same bit
  /// for bit. OutOfMemory names bytes that would do where even that does not fit. What the process takes for
  /// CUDA itself, some 0.6 GB, is counted, so that all that it holds of the device stays below the limit.
  ///
  /// In the memory of the host, for Backend::serial and openmp: what does not fit goes to a file if there is
  /// an out_of_core_dir, else analyze throws OutOfMemory. Where the vectors of 16 right-hand sides have no
  /// room fewer are solved for at once, which BLAS may round differently. The matrix, its analysis and what
  /// only some rungs of the accuracy ladder take, as the vectors of FGMRES, are not counted.
  std::int64_t memory_limit = 0;
  /// A folder on a disk, for Backend::serial and openmp; empty: none. Where memory_limit, or without one the
  /// memory that is free, does not do, fronts are made in segments, whose factors go to a file there beside
  /// the work on others and come back ahead of it in each pass of a solve (Report::partial, bytes_out,
  /// bytes_back). The solutions are the same bit for bit, whatever the limit; those of systems of up to some
  /// thousand unknowns may be others without a folder. The file has no name, so nothing is left of it
  /// whatever becomes of the process; its room is reserved before any work. OutOfMemory names bytes that
  /// would do where even that does not fit. BackendError("file") tells the error number of the system, the
  /// folder and the block of the file: no such folder, no room on the disk, a block that cannot be read or is
  /// not what was written. After one, refactor and solve may be called again.
  std::string out_of_core_dir;
  /// Threads of every phase, BLAS included, at most 512. 0 means default_threads() (mfs/threads.hpp).
  int threads = 0;
  /// Called with the progress of a phase, if not empty, by the thread that called the solver. A libmfs with
  /// MFS_KOKKOS=shared may call it by another thread instead, never by both at once. It must not call the
  /// solver. What it throws ends the phase and reaches the caller unchanged, whatever its type
  /// (std::bad_alloc as OutOfMemory). The solver stays usable.
  std::function<void(const Progress&)> progress;
  /// Where analyze, factor, refactor or solve throws, the system is written to Matrix Market files, if this
  /// is not empty: PREFIX_A.mtx and, of a solve, PREFIX_b.mtx (the block of at most 16 right-hand sides that
  /// failed). Files of an earlier failure are replaced. The error's text names the files, or says why they
  /// could not be written. StateError writes none, nor do vectors that solve does not accept.
  std::string dump_prefix;
  /// Events that `log` receives: 0 none, 1 phases, 2 details.
  int verbosity = 0;
  /// Receives one line of text per event, if not empty. The library itself never prints. What `log` throws is
  /// treated as what `progress` throws.
  std::function<void(const std::string&)> log;
};

}  // namespace mfs
