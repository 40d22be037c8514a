#include "solver/program/measure_rates.hpp"

#include <algorithm>
#include <ctime>
#include <iterator>
#include <numeric>
#include <string>

#include <mfs/error.hpp>
#include <mfs/solver.hpp>
#include <mfs/version.hpp>

#include "ordering/stopwatch.hpp"
#include "solver/program/matrix_market.hpp"

namespace mfs::program {
namespace {

constexpr std::int64_t kPivots[] = {4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096};
/// Up to so many pivots on the host, where larger fronts are as fast.
constexpr std::int64_t kMostOnHost = 512;
/// The last levels of a chain have smaller borders: there are more levels where fronts are many.
constexpr std::int64_t kLeastLevels = 4, kMostLevels = 16, kFrontsOfALevel = 1000;
/// Fronts that are alone on their level have so many pivots together, so that what a call takes is little,
/// and no more entries than the others.
constexpr std::int64_t kPivotsAlone = 16384, kMostLevelsAlone = 256;
/// A device has so many times the entries from so many pivots on: few fronts would not fill it, and what the
/// link brings shall be large.
constexpr std::int64_t kTimesAsMany = 16, kFromPivots = 8;
/// Fewer fronts on a level do not fill a device, and hardly take longer than one. It has so many beside each
/// other up to kMostFilled pivots, by which memory is at its rate.
constexpr std::int64_t kFewToCompare = 8, kMostFilled = 1024;

/// `count` chains of `levels` fronts with `pivots` pivots each, whose borders are the pivots of the next
/// `width`, two here:
///
///   D F F .
///   F D F F      D: pivot block, F: block beside it
///   F F D F
///   . F F D
///
/// Where the matrix is not `full`, only the first row and column of each block, and the diagonal, have
/// entries: eliminating the first unknown of a front fills it all, so the matrix is small beside its factors.
struct Chains {
  std::int64_t pivots, count, levels, width = 2;

  std::int64_t rows() const { return pivots * count * levels; }
  /// Of level k of a chain, beginning with its first unknown; levels of all chains lie together.
  std::int64_t begin(std::int64_t level, std::int64_t chain) const {
    return (level * count + chain) * pivots;
  }

  io::CsrMatrix<double> matrix(bool full) const {
    io::CsrMatrix<double> a{rows(), rows(), {0}, {}, {}};
    for (std::int64_t level = 0; level < levels; ++level)
      for (std::int64_t chain = 0; chain < count; ++chain)
        for (std::int64_t i = 0; i < pivots; ++i) add_row(level, chain, i, full, a);
    return a;
  }

  void add_row(std::int64_t level, std::int64_t chain, std::int64_t i, bool full,
               io::CsrMatrix<double>& a) const {
    const double small = 1 / (8.0 * static_cast<double>(pivots));
    const std::int64_t first = std::max<std::int64_t>(level - width, 0),
                       last = std::min(level + width, levels - 1);
    for (std::int64_t block = first; block <= last; ++block) {
      const auto add = [&](std::int64_t j) {
        a.column_indices.push_back(static_cast<std::int32_t>(begin(block, chain) + j));
        a.values.push_back(block == level && j == i ? 4 : small);
      };
      if (full || (i == 0 && block >= level)) {
        for (std::int64_t j = 0; j < pivots; ++j) add(j);
      } else if (block <= level) {
        add(0);
        if (block == level) add(i);
      }
    }
    a.offsets.push_back(static_cast<std::int64_t>(a.values.size()));
  }

  void put_order(AnalysisOptions& options) const {
    options.permutation.resize(static_cast<std::size_t>(rows()));
    std::iota(options.permutation.begin(), options.permutation.end(), 0);
    options.tree.offsets = {0};
    for (std::int64_t node = 0; node < count * levels; ++node) {
      options.tree.offsets.push_back((node + 1) * pivots);
      options.tree.parent.push_back(node + count < count * levels ? node + count : -1);
    }
  }
};

Chains chains_of(std::int64_t pivots, std::int64_t factor_entries, std::int64_t least_count = 2) {
  const std::int64_t fronts = factor_entries / (5 * pivots * pivots) + 1;
  const std::int64_t levels = std::clamp(fronts / kFrontsOfALevel, kLeastLevels, kMostLevels);
  return {pivots, std::max(fronts / levels, least_count), levels};
}
Chains chain_alone(std::int64_t pivots, std::int64_t factor_entries) {
  const std::int64_t levels = std::min(kPivotsAlone, factor_entries / (5 * pivots)) / pivots;
  return {pivots, 1, std::clamp(levels, kLeastLevels, kMostLevelsAlone)};
}

// Of at least three, and of as many as a fifth of a second holds.
template <class Call>
double least_time(const Call& call) {
  const Stopwatch all;
  double least = 0;
  for (int done = 0; done < 3 || (done < 100 && all.seconds() < 0.2); ++done) {
    const Stopwatch one;
    call();
    least = done == 0 ? one.seconds() : std::min(least, one.seconds());
  }
  return least;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  char text[16];
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

struct Measured {
  double size = 0, flops = 0;
  double refactor = 0, solve = 0;  // s
  Report report;
};

Measured measure(const Chains& chains, bool full, Options options) {
  options.analysis.matching = Matching::never;
  chains.put_order(options.analysis);
  const io::CsrMatrix<double> a = chains.matrix(full);
  const std::vector<double> b(static_cast<std::size_t>(a.rows), 1.0);
  std::vector<double> x(b.size());
  Solver solver(options);
  solver.factor(a.view());
  Measured found;
  found.refactor = least_time([&] { solver.refactor(a.view()); });
  found.solve = least_time([&] { solver.solve(b.data(), x.data()); });
  found.report = solver.report();
  double weighted = 0;
  for (const DepthSummary& depth : solver.depths()) {
    found.flops += depth.flops.total();
    weighted += depth.flops.total() * equivalent_size(depth);
  }
  found.size = weighted / found.flops;
  return found;
}

// What a call takes beside fronts, from two chains of the smallest that differ in their length.
void measure_call(const Options& options, MachineRates& rates) {
  constexpr std::int64_t kShort = 4, kLong = 64;
  const Measured few = measure({kPivots[0], 1, kShort}, false, options);
  const Measured many = measure({kPivots[0], 1, kLong}, false, options);
  const auto call = [](double few, double many) {
    return std::max(0.0, few - (many - few) / (kLong - kShort) * kShort);
  };
  rates.refactor_call = call(few.refactor, many.refactor);
  rates.solve_call = call(few.solve, many.solve);
}

// What an entry of the matrix costs beside the factors, from two matrices with the same fronts.
void measure_entries(const Options& options, std::int64_t factor_entries, MachineRates& rates) {
  constexpr std::int64_t kPivotsOfEntries = 32;
  const Chains chains = chains_of(kPivotsOfEntries, 2 * factor_entries);
  const Measured few = measure(chains, false, options), many = measure(chains, true, options);
  const auto entries = static_cast<double>(many.report.nnz - few.report.nnz);
  rates.refactor_seconds_per_entry = std::max(0.0, (many.refactor - few.refactor) / entries);
  rates.solve_seconds_per_entry = std::max(0.0, (many.solve - few.solve) / entries);
}

/// Chains beside each other, one of them, and one that is as long or longer.
struct MeasuredChains {
  Chains chains, longer;
  Measured many, one, alone;
};
MeasuredChains measure_chains(std::int64_t pivots, std::int64_t factor_entries, std::int64_t least_count,
                              const Options& options) {
  MeasuredChains found{
      chains_of(pivots, factor_entries, least_count), chain_alone(pivots, factor_entries), {}, {}, {}};
  found.many = measure(found.chains, false, options);
  found.one = measure({pivots, 1, found.chains.levels}, false, options);
  found.alone =
      found.longer.levels == found.chains.levels ? found.one : measure(found.longer, false, options);
  return found;
}

/// s for the factors of a front of this size, by the best rate at which fronts were added so far.
double least_solve(double size, const std::vector<FrontRate>& smaller) {
  double best = 0;
  for (const FrontRate& rate : smaller) best = std::max(best, entries_of_front(rate.size) / rate.solve.each);
  return best > 0 ? entries_of_front(size) / best : 0;
}

/// `rates` has what a call takes, and smaller fronts. Times are of levels whose fronts are all full, but a
/// solve of one chain, which takes as long as its pivots.
FrontRate front_rate(const MeasuredChains& measured, const MachineRates& rates) {
  constexpr double kLeast = 1e-3;  // clocks are not exact
  const auto& [chains, longer, many, one, alone] = measured;
  const auto beside_call = [](double time, double call) { return std::max(time - call, time / 10); };
  const auto count = static_cast<double>(chains.count);
  const auto entries = static_cast<double>(many.report.nnz_factor);
  FrontRate rate;
  rate.size = many.size;
  const double flops = flops_of_front(rate.size), added = (count - 1) / count;
  rate.flops_per_second = many.flops / beside_call(many.refactor, rates.refactor_call);
  rate.entries_per_second = entries / beside_call(many.solve, rates.solve_call);
  rate.refactor.alone = beside_call(alone.refactor, rates.refactor_call) * flops / alone.flops;
  rate.refactor.each =
      std::max((many.refactor - one.refactor) * flops / (added * many.flops), kLeast * rate.refactor.alone);
  rate.solve.alone = beside_call(alone.solve, rates.solve_call) / static_cast<double>(longer.levels);
  rate.solve.each = std::max((many.solve - one.solve) * entries_of_front(rate.size) / (added * entries),
                             kLeast * rate.solve.alone);
  // Memory is not faster for large fronts than for those that were enough to tell.
  if (chains.count < kFewToCompare)
    rate.solve.each = std::max(rate.solve.each, least_solve(rate.size, rates.fronts));
  return rate;
}

// A device brings vectors from the host and back, and reads factors at one rate whatever the fronts are. That
// is measured by borders of a real tree, of which more fit beside each other than of twice the pivots. What
// small fronts take beside is their rows'.
void measure_device_solve(const Options& options, std::int64_t factor_entries, MachineRates& rates) {
  constexpr std::int64_t kPivotsOfRows = 8, kPivotsOfMemory = 256, kWidth = 6;
  const auto added = [&](const Chains& one, std::int64_t count, const auto& amount) {
    Chains several = one;
    several.count = count;
    const Measured few = measure(one, false, options), many = measure(several, false, options);
    const double rows = rates.solve_seconds_per_row * static_cast<double>(many.report.n - few.report.n);
    return std::max(many.solve - few.solve - rows, many.solve / 10) /
           static_cast<double>(amount(many) - amount(few));
  };
  rates.solve_seconds_per_row = added({kPivotsOfRows, 1, kMostLevels},
                                      factor_entries / (5 * kPivotsOfRows * kPivotsOfRows * kMostLevels),
                                      [](const Measured& measured) { return measured.report.n; });
  const std::int64_t front = (1 + 2 * kWidth) * kPivotsOfMemory * kPivotsOfMemory;
  const double per_entry = added({kPivotsOfMemory, 1, kMostLevels, kWidth},
                                 std::max(factor_entries / (front * kMostLevels), kFewToCompare),
                                 [](const Measured& measured) { return measured.report.nnz_factor; });
  for (FrontRate& rate : rates.fronts) rate.solve.each = per_entry * entries_of_front(rate.size);
}

/// The least memory limit that factors of this system can do with.
std::int64_t least_limit(const Chains& chains, Options options) {
  options.analysis.matching = Matching::never;
  options.memory_limit = 1;
  chains.put_order(options.analysis);
  Solver solver(options);
  try {
    solver.factor(chains.matrix(false).view());
  } catch (const OutOfMemory& error) {
    return static_cast<std::int64_t>(error.needed());
  }
  return 0;
}

// By how much longer a solve takes that brings factors back. Where they cannot be had, or memory is never
// limited, nothing is said.
void measure_link(const Options& options, std::int64_t factor_entries, MachineRates& rates) {
  constexpr std::int64_t kPivotsOfLink = 256;
  const Chains chains = chains_of(kPivotsOfLink, factor_entries);
  try {
    const double whole = measure(chains, false, options).solve;
    Options limited = options;
    limited.memory_limit = least_limit(chains, options);
    const Measured part = measure(chains, false, limited);
    if (part.report.partial && part.solve > whole)
      rates.link_bytes_per_second = static_cast<double>(part.report.bytes_back) / (part.solve - whole);
  } catch (const OutOfMemory&) {
  } catch (const InvalidInput&) {  // of a backend without limits
  }
}

}  // namespace

MachineRates measure_rates(const Options& options, std::int64_t factor_entries,
                           const std::function<void(double)>& progress) {
  Options own;
  own.backend = options.backend;
  own.threads = options.threads;
  own.factor.precision = Precision::full;
  const bool on_device = backend_info(own.backend).memory == MemorySpace::device;
  const auto sizes = std::count_if(std::begin(kPivots), std::end(kPivots),
                                   [&](std::int64_t pivots) { return on_device || pivots <= kMostOnHost; });
  MachineRates rates;
  measure_call(own, rates);
  for (std::ptrdiff_t i = 0; i < sizes; ++i) {
    progress(static_cast<double>(i) / static_cast<double>(sizes));
    const std::int64_t times = on_device && kPivots[i] >= kFromPivots ? kTimesAsMany : 1;
    const std::int64_t least_count = on_device && kPivots[i] <= kMostFilled ? kFewToCompare : 2;
    const MeasuredChains measured = measure_chains(kPivots[i], times * factor_entries, least_count, own);
    if (measured.many.report.partial) break;  // a small device
    rates.fronts.push_back(front_rate(measured, rates));
    rates.key = rates_key(own.backend, measured.many.report.threads);
  }
  measure_entries(own, factor_entries, rates);
  if (on_device) {
    measure_device_solve(own, kTimesAsMany * factor_entries, rates);
    measure_link(own, kTimesAsMany * factor_entries, rates);
  }
  rates.date = today();
  return rates;
}

}  // namespace mfs::program
