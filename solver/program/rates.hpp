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

/// Of fronts of one size, on levels of so many, and of one: fronts that fill the machine take as long as
/// their operations and their entries say, one alone as long as its chain of pivots.
struct FrontRate {
  double size = 0;                ///< equivalent_size()
  double fronts = 0;              ///< of a level, at least 2
  double flops_per_second = 0;    ///< of a refactorization
  double entries_per_second = 0;  ///< of the factors, in a solve for one right-hand side
  double refactor_alone = 0;      ///< s, of a level with one front
  double solve_alone = 0;         ///< s, the same
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
  std::string date;               ///< of the measurement, 2026-11-25
  std::vector<FrontRate> fronts;  ///< sizes ascending
  /// What each entry of the matrix adds: it is put into its front, and read for the residual.
  double refactor_seconds_per_entry = 0, solve_seconds_per_entry = 0;
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

/// Rows and columns of the product with as many operations as the fronts of this depth have on the average,
/// each front weighted by its operations: the cube root of m n k.
double equivalent_size(const DepthSummary& depth);
/// Of one front of so many pivots and border rows.
double equivalent_size(double pivots, double border);

/// From the entries of the matrix and fronts by depth: the time of one front of the depth's size, and for
/// each further one what that adds. Both are interpolated between sizes that were measured (in logarithms); a
/// front beyond them is so many of the last. Factors that do not fit a device take `report.slowdown` times
/// that, at least what leaves at the rate of the link, and a solve what comes back by it besides.
/// `rates.fronts` must not be empty.
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
