// How fast this machine works on fronts by their size, measured once by `mfs info --measure`, and what that
// lets one say of a matrix that was only analysed.
//
// Rates are those of the solver itself, with all that goes with a front: assembly, factors, update, waiting.
// They lie in ~/.cache/mfs/rates.json ($XDG_CACHE_HOME/mfs/rates.json), an entry for each processor or
// device, BLAS, backend and number of threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <mfs/report.hpp>

namespace mfs::program {

/// s of a level of the tree: of one front, and of each further one.
struct LevelTime {
  double alone = 0, each = 0;
};

/// Of fronts of one size on a level of the tree: one alone takes as long as its chain of pivots, each further
/// one what it adds. Rates of many are what the machine reaches where they fill it.
struct FrontRate {
  double size = 0;                ///< equivalent_size()
  double flops_per_second = 0;    ///< of a refactorization, many fronts on each level
  double entries_per_second = 0;  ///< of the factors, in a solve for one right-hand side, the same
  LevelTime refactor, solve;
};

/// What rates hold for: they are compared as a whole.
struct RatesKey {
  std::string processor;  ///< of the host, or the device of the backend
  std::string blas;
  std::string backend;
  int threads = 0;
  bool operator==(const RatesKey& other) const;
};

struct MachineRates {
  RatesKey key;
  std::string date;                          ///< of the measurement, 2026-11-25
  std::vector<FrontRate> fronts;             ///< sizes ascending
  double refactor_call = 0, solve_call = 0;  ///< s that a call takes whatever the fronts are
  /// What each entry of the matrix adds: it is put into its front, and read for the residual.
  double refactor_seconds_per_entry = 0, solve_seconds_per_entry = 0;
  /// On a device, what each row adds: b comes from the host and x goes there. Elsewhere fronts have it.
  double solve_seconds_per_row = 0;
  /// Between the memories of host and device, as a solve brings factors back; 0: not measured.
  double link_bytes_per_second = 0;
};

/// What the file holds. A file that is not there is empty, one that makes no sense is damaged and empty.
struct RatesFile {
  std::vector<MachineRates> rates;
  bool damaged = false;
};

/// Seconds of a refactorization, and of a solve for one right-hand side that needs no refinement and is not
/// the first, which takes its memory.
struct Prediction {
  double refactor = 0, solve = 0;
  std::string date;  ///< of the rates
};

/// Of the fronts of a depth, in a mean in which the large ones count most.
struct FrontShape {
  double pivots = 0, border = 0;
};
FrontShape mean_front(const DepthSummary& depth);
/// Rows and columns of the product with as many operations as mean_front: the cube root of m n k.
double equivalent_size(const DepthSummary& depth);
/// Of one front of so many pivots and border rows.
double equivalent_size(double pivots, double border);
/// Of a front of this size with twice as many border rows as pivots: operations, and entries of the factors.
double flops_of_front(double size);
double entries_of_front(double size);

/// What a call takes and the rows and entries of the matrix, and by depth the time of one front of the
/// depth's size, and for each further one what that adds. Both are interpolated between sizes that were
/// measured (in logarithms); a front beyond them is so many of the last. On a device the pivots of a front
/// decide how long a solve takes with it alone, whatever its border. Factors that do not fit a device take
/// `report.slowdown` times that, at least what leaves at the rate of the link, and a solve what comes back by
/// it besides. `rates.fronts` must not be empty.
Prediction predict(const MachineRates& rates, const Report& report, const std::vector<DepthSummary>& depths);

/// Of this machine; `threads` as the solver's report has them.
RatesKey rates_key(Backend backend, int threads);

/// Where rates are kept; empty where neither XDG_CACHE_HOME nor HOME names an absolute path.
std::string rates_path();
RatesFile read_rates(const std::string& path);
/// Before anything is measured: makes the folder of a file of rates. Throws InvalidInput where that, or the
/// file, cannot be written.
void make_rates_folder(const std::string& path);
/// Puts `rates` beside what the file has for other keys. The file is the old one or the new one at any time,
/// and its folders are made. Throws InvalidInput.
void keep_rates(const std::string& path, const MachineRates& rates);

}  // namespace mfs::program
