#include "plan/segment_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace mfs {

namespace {

/// Of an H100 (docs/experiments/device-memory.md), by which the depths of six known cases add up to 0.95 to
/// 1.1 of what their refactorizations take. Others differ in all of these by much the same factor.
constexpr SegmentRates kDevice{150e-6, 22e-6, 50e12, 300, 2.7e11, 4e-6, 6.1e9, 4.1e9};
/// Of a host with two cores and a disk of the common kind.
constexpr SegmentRates kFile{20e-6, 0, 1e11, 60, 2.5e9, 100e-6, 8e7, 1e8};

/// Of factors and contribution blocks that a front makes, each is written, changed and read.
constexpr double kTimesMoved = 3;

double seconds_of_flops(const SegmentRates& rates, double flops) {
  if (flops <= 0) return 0;
  const double size = std::cbrt(flops / 2);
  return flops / rates.flops * (1 + rates.half_size / size);
}

}  // namespace

SegmentClock::SegmentClock(const SymbolicPlan& plan, Outside outside)
    : plan_(plan),
      rates_(outside == Outside::file ? kFile : kDevice),
      front_(static_cast<std::size_t>(plan.num_fronts)) {
#pragma omp parallel for schedule(static)
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    const double rows = plan.rows(f);
    front_[f] = seconds_of_flops(rates_, plan.front_flops[f]) + kTimesMoved * rows * rows / rates_.memory;
  }
}

double SegmentClock::tiles_seconds(Vertex f) const {
  constexpr double kTile = 128;
  return std::ceil(plan_.pivots(f) / kTile) * rates_.tile;
}

// Of fronts front(begin) ... front(end - 1), launched as one.
template <class FrontAt>
double SegmentClock::seconds_together(Vertex begin, Vertex end, const FrontAt& front) const {
  double fronts = 0, tiles = 0;
  for (Vertex i = begin; i < end; ++i) {
    fronts += front_[front(i)];
    tiles = std::max(tiles, tiles_seconds(front(i)));
  }
  return rates_.segment + fronts + tiles;
}

double SegmentClock::whole_refactor_seconds() const {
  double sum = 0;
  for (Vertex step = 0; step < plan_.num_depths; ++step)
    sum += seconds_together(plan_.depth_begin[step], plan_.depth_begin[step + 1], [](Vertex f) { return f; });
  return sum;
}

// Of segments, without what they read of contribution blocks that have left.
std::vector<double> SegmentClock::busy_seconds(const SegmentPlan& segments) const {
  std::vector<double> busy;
  for (const Segment& segment : segments.segments)
    busy.push_back(seconds_together(segment.begin, segment.end, [&](Vertex i) { return segments.order[i]; }));
  // Columns of a front have their part of it, and a chain of as many tiles, without those on the diagonal.
  constexpr double kOffDiagonal = 2.0 / 3;
  for (const BorderColumns& columns : segments.border_columns) {
    const Vertex f = columns.front;
    const double part = front_[f] * (columns.end - columns.begin) / plan_.rows(f);
    busy[columns.segment] += part + kOffDiagonal * tiles_seconds(f);
    busy[segments.segment[f]] -= part;
  }
  return busy;
}

// Of segments: to read contribution blocks in the memory of the host; columns of a front have their part.
std::vector<double> SegmentClock::reading_seconds(const SegmentPlan& segments) const {
  std::vector<double> reads(segments.segments.size(), 0.0);
  for (const LeavingBlock& block : segments.leaving) {
    if (block.to < 0) continue;
    const double seconds = static_cast<double>(block.entries) / rates_.in;
    const Segment& reader = segments.segments[block.to];
    reads[block.to] += seconds;
    if (!reader.divided) continue;
    const Vertex f = segments.order[reader.begin];
    const auto [columns, end] = segments.columns_of(f);
    for (auto own = columns; own != end; ++own) {
      const double part = seconds * (own->end - own->begin) / plan_.rows(f);
      reads[own->segment] += part;
      reads[block.to] -= part;
    }
  }
  return reads;
}

double SegmentClock::refactor_seconds(const SegmentPlan& segments) const {
  const std::size_t count = segments.segments.size();
  const std::vector<double> busy = busy_seconds(segments);
  std::vector<double> left(count, 0.0);
  const std::vector<double> reads = reading_seconds(segments);
  std::vector<double> ended(count + 1, 0.0);
  double done = 0, sent = 0, read = 0;
  auto block = segments.leaving.begin();
  for (std::size_t t = 0; t < count; ++t) {
    const Vertex before = segments.segments[t].leaves_first;
    if (before > 0) done = std::max(done, left[before - 1]);
    const Vertex after = segments.segments[t].assembled_after;
    read = std::max({read, ended[after], before > 0 ? left[before - 1] : 0.0}) + reads[t];
    done = std::max(done, reads[t] > 0 ? read : 0) + busy[t];
    ended[t + 1] = done;
    for (; block != segments.leaving.end() && block->from == static_cast<Vertex>(t); ++block)
      sent = std::max(sent, done) + rates_.copy + static_cast<double>(block->entries) / rates_.out;
    left[t] = sent;
  }
  return std::max(done, sent);
}

double SegmentClock::solve_seconds(const SegmentPlan& segments) const {
  return static_cast<double>(segments.host_entries) / rates_.out;
}

double SegmentClock::least_seconds(const SegmentPlan& segments, Offset region) const {
  const std::vector<double> busy = busy_seconds(segments);
  const double kernels = std::accumulate(busy.begin(), busy.end(), 0.0);
  return kernels + static_cast<double>(std::max<Offset>(plan_.factor_entries - region, 0)) / rates_.out;
}

double SegmentClock::seconds_of_matrix() const {
  // In entries of 8 bytes. A refactorization reads values one by one, 32 bytes over the link for each, and 8
  // of where it is and goes; the check of a solution reads a value and its column.
  constexpr double kRead = 5 + 1.5;
  return kRead * static_cast<double>(plan_.nnz) / rates_.in;
}

}  // namespace mfs
