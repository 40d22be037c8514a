// Measures how fast the solver works on fronts, by their size: `mfs info --measure`.
#pragma once

#include <cstdint>
#include <functional>

#include <mfs/options.hpp>

#include "solver/program/rates.hpp"

namespace mfs::program {

/// Factors and solves systems made of fronts of one size, for sizes from 7 to some 1000, on a device 8000,
/// with backend and threads of `options`; of repeated refactorizations and solves the least time counts.
/// `factor_entries`: of each system at least; fewer than the cache holds make the solve seem faster than it
/// is. `progress` gets what is done, from 0 to 1. Throws what the solver throws.
MachineRates measure_rates(const Options& options, std::int64_t factor_entries,
                           const std::function<void(double)>& progress);

/// Of `mfs info --measure`: 48 MB of factors in double precision.
constexpr std::int64_t kMeasuredEntries = 6'000'000;

}  // namespace mfs::program
