#include "plan/segment_lists.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "plan/product_lists.hpp"
#include "plan/spans.hpp"

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
  const auto segment_of = [&](const AssemblyPart& part) {
    return made_.segments.segment_of(part.front, part.begin);
  };
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
// Columns of a divided front have no tiles that others could run beside: one after the other.
template <class Task>
void SegmentLists::divide(const Launch& launch, const std::vector<Task>& tasks, Vertex Task::*first,
                          std::vector<Task>& divided, std::vector<Launch> DepthLaunches::*launches) {
  std::map<Vertex, std::vector<Task>> found;
  for (Offset i = launch.tasks.begin; i < launch.tasks.end; ++i)
    for_each_piece(tasks[i], [&](Vertex segment, const Task& piece) { found[segment].push_back(piece); });
  for (const auto& [segment, pieces] : found) {
    const bool has_tiles = segment == made_.segments.segment[pieces.front().front];
    if (!has_tiles && launch.kind == Launch::Kind::diagonal) continue;
    Launch own = launch;
    own.tasks.begin = static_cast<Offset>(divided.size());
    own.blocks = 0;
    for (Task piece : pieces) {
      piece.*first = own.blocks;
      own.blocks += blocks_of(piece, launch);
      divided.push_back(piece);
    }
    own.tasks.end = static_cast<Offset>(divided.size());
    if (!has_tiles) own.order = Order::sequential;
    (segments_[segment].*launches).push_back(own);
  }
}

Vertex SegmentLists::blocks_of(const StepTask& task, const Launch& launch) const {
  if (launch.kind == Launch::Kind::diagonal) return 1;
  const Vertex next = std::min(task.k + limits_.tile, plan_.pivots(task.front));
  return (task.left ? tiles_of(plan_.rows(task.front) - next, limits_.strip) : 0) +
         tiles_of(task.end - task.begin, limits_.strip);
}
Vertex SegmentLists::blocks_of(const ProductTask& task, const Launch& launch) const {
  if (launch.kind == Launch::Kind::vendor_gemm) return 1;
  const Vertex rows = launch.kind == Launch::Kind::wide_products ? kWideRows : limits_.product_rows;
  return tiles_of(task.m, rows) * tiles_of(task.n, limits_.product_columns);
}

// take(segment, what of the task is its)
template <class Take>
void SegmentLists::for_each_piece(const StepTask& task, const Take& take) const {
  const Vertex f = task.front, p = plan_.pivots(f), next = std::min(task.k + limits_.tile, p);
  const auto [columns, end] = made_.segments.columns_of(f);
  if (columns == end) return take(made_.segments.segment[f], task);
  StepTask own = task;
  own.end = std::min(task.end, p - next);
  own.begin = std::min(task.begin, own.end);
  if (task.left || own.begin < own.end) take(made_.segments.segment[f], own);
  own.left = 0;
  for (auto right = columns; right != end; ++right) {
    own.begin = std::max(task.begin, right->begin - next);
    own.end = std::min(task.end, right->end - next);
    own.upper = right->upper;
    if (own.begin < own.end) take(right->segment, own);
  }
}

// What a product makes is part of P, L, U or C, of which only U and C are divided.
template <class Take>
void SegmentLists::for_each_piece(const ProductTask& task, const Take& take) const {
  const Vertex f = task.front, p = plan_.pivots(f);
  const auto [columns, end] = made_.segments.columns_of(f);
  if (columns == end || task.ldb != p) return take(made_.segments.segment[f], task);
  const Offset b = task.b - plan_.upper_begin[f];
  const Vertex first = p + static_cast<Vertex>(b / p), last = first + task.n;
  const bool of_contribution = (task.a - plan_.lower_begin[f]) % task.lda >= p;
  for (auto own = columns; own != end; ++own) {
    const Vertex left = std::max(first, own->begin), right = std::min(last, own->end);
    if (left >= right) continue;
    ProductTask piece = task;
    piece.n = right - left;
    const Offset before = left - first;
    piece.b += own->upper - plan_.upper_begin[f] + before * task.ldb;
    const Offset shift =
        of_contribution ? own->contribution - plan_.contribution_begin[f] : own->upper - plan_.upper_begin[f];
    piece.c += shift + before * task.ldc;
    take(own->segment, piece);
  }
}

void SegmentLists::divide_blocks() {
  std::vector<FrontPart> blocks;
  for (const DepthLaunches& depth : made_.depths) {
    move_by_segment(
        made_.exchange, depth.exchange, blocks,
        [&](const FrontPart& part) { return made_.segments.last_segment_of(part.front); },
        [&](Vertex segment, const Range& range) { segments_[segment].exchange = range; });
  }
  made_.exchange = std::move(blocks);
}

void SegmentLists::divide_wide_tiles() {
  std::vector<FrontPart> tiles;
  move_by_segment(
      made_.wide_tiles, {0, static_cast<Offset>(made_.wide_tiles.size())}, tiles,
      [&](const FrontPart& part) { return made_.segments.last_segment_of(part.front); },
      [&](Vertex segment, const Range& range) { segments_[segment].inverses = range; });
  made_.wide_tiles = std::move(tiles);
}

}  // namespace mfs
