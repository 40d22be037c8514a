#include "plan/segment_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

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

// Of what `segment` computes, without what it reads of contribution blocks that have left.
double SegmentClock::busy_seconds(const SegmentPlan& segments, const Segment& segment) const {
  constexpr double kTile = 128;
  double sum = rates_.segment, tiles = 0;
  for (Vertex i = segment.begin; i < segment.end; ++i) {
    const Vertex f = segments.order[i];
    tiles = std::max(tiles, std::ceil(plan_.pivots(f) / kTile));
    sum += front_[f];
  }
  return sum + tiles * rates_.tile;
}

// Of these columns alone: their part of the front.
double SegmentClock::column_seconds(const BorderColumns& columns) const {
  return front_[columns.front] * (columns.end - columns.begin) / plan_.rows(columns.front);
}

double SegmentClock::refactor_seconds(const SegmentPlan& segments) const {
  const std::size_t count = segments.segments.size();
  std::vector<double> busy(count), left(count, 0.0);
  for (std::size_t t = 0; t < count; ++t) busy[t] = busy_seconds(segments, segments.segments[t]);
  for (const BorderColumns& columns : segments.border_columns) {
    const double part = column_seconds(columns);
    busy[columns.segment] += part;
    busy[segments.segment[columns.front]] -= part;
  }
  for (const LeavingBlock& block : segments.leaving) {
    if (block.to >= 0) busy[block.to] += static_cast<double>(block.entries) / rates_.in;
  }
  double done = 0, sent = 0;
  auto block = segments.leaving.begin();
  for (std::size_t t = 0; t < count; ++t) {
    const Vertex before = segments.segments[t].leaves_first;
    if (before > 0) done = std::max(done, left[before - 1]);
    done += busy[t];
    for (; block != segments.leaving.end() && block->from == static_cast<Vertex>(t); ++block)
      sent = std::max(sent, done) + rates_.copy + static_cast<double>(block->entries) / rates_.out;
    left[t] = sent;
  }
  return std::max(done, sent);
}

double SegmentClock::solve_seconds(const SegmentPlan& segments) const {
  return static_cast<double>(segments.host_entries) / rates_.out;
}

double SegmentClock::seconds_of_matrix() const {
  // In entries of 8 bytes. A refactorization reads values one by one, 32 bytes over the link for each, and 8
  // of where it is and goes; the check of a solution reads a value and its column.
  constexpr double kRead = 5 + 1.5;
  return kRead * static_cast<double>(plan_.nnz) / rates_.in;
}

}  // namespace mfs
