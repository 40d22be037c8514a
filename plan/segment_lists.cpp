#include "plan/segment_lists.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace mfs {

namespace {

/// Calls take(segment, indices) for the elements of a range, by segment, in their order.
template <class SegmentOf, class Take>
void for_each_segment(const Range& range, const SegmentOf& segment_of, const Take& take) {
  std::map<Vertex, std::vector<Offset>> found;
  for (Offset i = range.begin; i < range.end; ++i) found[segment_of(i)].push_back(i);
  for (const auto& [segment, indices] : found) take(segment, indices);
}

/// Moves the elements of a range to the end of another list, by segment. Calls take(segment, their range).
template <class From, class To, class SegmentOf, class Take>
void move_by_segment(const From& from, const Range& range, To& to, const SegmentOf& segment_of,
                     const Take& take) {
  for_each_segment(
      range, [&](Offset i) { return segment_of(from[i]); },
      [&](Vertex segment, const std::vector<Offset>& indices) {
        const auto begin = static_cast<Offset>(to.size());
        for (const Offset i : indices) to.push_back(from[i]);
        take(segment, Range{begin, static_cast<Offset>(to.size())});
      });
}

/// Blocks of task i of a launch whose tasks tell the first of theirs.
template <class Task>
Vertex blocks_of(const std::vector<Task>& tasks, const Launch& launch, Vertex Task::*first, Offset i) {
  const Vertex end = i + 1 < launch.tasks.end ? tasks[i + 1].*first : launch.blocks;
  return end - tasks[i].*first;
}

}  // namespace

void SegmentLists::run() {
  segments_.resize(made_.segments.segments.size());
  divide_fronts();
  divide_parts();
  divide_launches(&DepthLaunches::factor);
  divide_launches(&DepthLaunches::update);
  divide_blocks();
  divide_wide_tiles();
  made_.depths = std::move(segments_);
  made_.steps = std::move(steps_);
  made_.products = std::move(products_);
}

void SegmentLists::divide_fronts() {
  std::vector<Vertex> fronts;
  for (const DepthLaunches& depth : made_.depths) {
    for (const SmallLaunch& launch : depth.small) {
      move_by_segment(
          made_.small_fronts, launch.fronts, fronts, [&](Vertex f) { return made_.segments.segment[f]; },
          [&](Vertex segment, const Range& range) {
            segments_[segment].small.push_back({range, launch.rows});
          });
    }
  }
  made_.small_fronts = std::move(fronts);
}

// Contribution blocks are assembled in one turn.
void SegmentLists::divide_parts() {
  std::vector<AssemblyPart> parts;
  parts.reserve(made_.assemble.size());
  const auto segment_of = [&](const AssemblyPart& part) { return made_.segments.segment[part.front]; };
  for (const DepthLaunches& depth : made_.depths) {
    move_by_segment(made_.assemble, depth.assemble, parts, segment_of,
                    [&](Vertex segment, const Range& range) { segments_[segment].assemble = range; });
    move_by_segment(
        made_.assemble, depth.assemble_contribution.front(), parts, segment_of,
        [&](Vertex segment, const Range& range) { segments_[segment].assemble_contribution = {range}; });
  }
  std::copy(parts.begin(), parts.end(), made_.assemble.begin());
  for (DepthLaunches& segment : segments_) {
    if (segment.assemble_contribution.empty()) segment.assemble_contribution = {Range()};
  }
}

void SegmentLists::divide_launches(std::vector<Launch> DepthLaunches::*launches) {
  for (const DepthLaunches& depth : made_.depths) {
    for (const Launch& launch : depth.*launches) {
      switch (launch.kind) {
        case Launch::Kind::diagonal:
        case Launch::Kind::strips:
          divide(launch, made_.steps, &StepTask::first_strip, steps_, launches);
          break;
        case Launch::Kind::products:
        case Launch::Kind::wide_products:
        case Launch::Kind::vendor_gemm:
          divide(launch, made_.products, &ProductTask::first_tile, products_, launches);
          break;
      }
    }
  }
}

// A launch that joins has something of each front that needs it (step_lists.cpp), so no segment misses one.
template <class Task>
void SegmentLists::divide(const Launch& launch, const std::vector<Task>& tasks, Vertex Task::*first,
                          std::vector<Task>& divided, std::vector<Launch> DepthLaunches::*launches) {
  const bool one_block = launch.kind == Launch::Kind::diagonal || launch.kind == Launch::Kind::vendor_gemm;
  for_each_segment(
      launch.tasks, [&](Offset i) { return made_.segments.segment[tasks[i].front]; },
      [&](Vertex segment, const std::vector<Offset>& indices) {
        Launch own = launch;
        own.tasks.begin = static_cast<Offset>(divided.size());
        own.blocks = 0;
        for (const Offset i : indices) {
          divided.push_back(tasks[i]);
          divided.back().*first = own.blocks;
          own.blocks += one_block ? 1 : blocks_of(tasks, launch, first, i);
        }
        own.tasks.end = static_cast<Offset>(divided.size());
        (segments_[segment].*launches).push_back(own);
      });
}

void SegmentLists::divide_blocks() {
  std::vector<FrontPart> blocks;
  for (const DepthLaunches& depth : made_.depths) {
    move_by_segment(
        made_.exchange, depth.exchange, blocks,
        [&](const FrontPart& part) { return made_.segments.segment[part.front]; },
        [&](Vertex segment, const Range& range) { segments_[segment].exchange = range; });
  }
  made_.exchange = std::move(blocks);
}

void SegmentLists::divide_wide_tiles() {
  std::vector<FrontPart> tiles;
  move_by_segment(
      made_.wide_tiles, {0, static_cast<Offset>(made_.wide_tiles.size())}, tiles,
      [&](const FrontPart& part) { return made_.segments.segment[part.front]; },
      [&](Vertex segment, const Range& range) { segments_[segment].inverses = range; });
  made_.wide_tiles = std::move(tiles);
}

}  // namespace mfs
