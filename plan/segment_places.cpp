#include "plan/segment_places.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "plan/device_plan.hpp"
#include "plan/spans.hpp"

namespace mfs {

namespace {

/// What a pass does not read of a front stays outside where it has at least kLeastApart times as many entries
/// as a small front may have: some tenths of a megabyte, which take the link longer than a copy takes to
/// begin. A triangle of P comes in at most kMostColumnBlocks blocks of columns.
constexpr Offset kLeastApart = 2;
constexpr Vertex kMostColumnBlocks = 8;

void add_run(Offset begin, Offset entries, std::vector<SegmentBlock>& blocks) {
  if (!blocks.empty() && blocks.back().columns == 1 && blocks.back().begin + blocks.back().rows == begin) {
    blocks.back().rows += entries;
  } else if (entries > 0) {
    blocks.push_back({begin, entries, entries, 1});
  }
}

/// The first place from `begin` on where a block has room beside those of `placed`, by place, that it meets.
template <class Meets>
Offset first_gap(const std::vector<Block>& placed, Offset entries, Offset begin, const Meets& meets) {
  Offset place = begin;
  for (const Block& other : placed) {
    if (!meets(other)) continue;
    if (place + entries <= other.place) break;
    place = std::max(place, other.place + other.entries);
  }
  return place;
}

/// Gives blocks their places from `begin` on, the largest first, each in the first gap that has room for it
/// beside those that it meets: where none has to wait for another one, if that ends before `limit`. `placed`
/// have theirs, and ascend by them. Returns where the last one ends.
Offset place_blocks(std::vector<Block>& blocks, Offset begin, std::vector<Block> placed, Offset limit) {
  std::vector<std::size_t> by_size(blocks.size());
  std::iota(by_size.begin(), by_size.end(), std::size_t{0});
  std::stable_sort(by_size.begin(), by_size.end(),
                   [&](std::size_t a, std::size_t b) { return blocks[a].entries > blocks[b].entries; });
  placed.reserve(placed.size() + blocks.size());
  Offset most = begin;
  for (const std::size_t i : by_size) {
    Block& block = blocks[i];
    const auto gap = [&](const auto& meets) { return first_gap(placed, block.entries, begin, meets); };
    block.place = gap([&](const Block& other) { return other.waits_for(block); });
    if (block.place + block.entries > limit)
      block.place = gap([&](const Block& other) { return other.meets(block); });
    const auto after = std::upper_bound(placed.begin(), placed.end(), block,
                                        [](const Block& a, const Block& b) { return a.place < b.place; });
    placed.insert(after, block);
    most = std::max(most, block.place + block.entries);
  }
  return most;
}
constexpr Offset kNoLimit = std::numeric_limits<Offset>::max();

}  // namespace

Vertex SegmentPlaces::first_that_may_stay() const {
  Vertex first = 0;
  for (const BorderColumns& columns : made_.border_columns) first = std::max(first, columns.segment + 1);
  return first;
}

Offset SegmentPlaces::place(Vertex first_staying, const Ahead& ahead, Offset spare) {
  stay_ = first_staying;
  Offset next = 0, host = 0;
  for (Vertex t = 0; t < count(); ++t) {
    Segment& segment = made_.segments[t];
    const bool leaves = t < stay_ && segment.entries > 0;
    segment.host = leaves ? host : -1;
    segment.solved_on_host =
        leaves && outside_ == Outside::memory && (segment.divided || segment.entries > (region_ - spare) / 2);
    host += leaves ? segment.entries : 0;
  }
  made_.host_entries = host;
  for (Vertex t = stay_; t < count(); ++t) {
    made_.segments[t].place = next;
    next += made_.segments[t].entries;
  }
  made_.spare_begin = next;
  made_.spare_entries = spare;
  place_in_factorization(ahead);
  place_in_solve(ahead.back);
  return made_.region_entries;
}

const SegmentPlan& SegmentPlaces::schedule() {
  list_leaving();
  Vertex before = 0;  // one is assembled after the other
  for (Vertex t = 0; t < count(); ++t) {
    Segment& own = made_.segments[t];
    own.leaves_first = leaves_first(t);
    // Columns of a front read what its [P; L] have waited for.
    if (own.begin == own.end)
      own.leaves_first = std::max(own.leaves_first, made_.segments[t - 1].leaves_first);
    own.assembled_after = reads_outside_[t] ? std::max(before, assembled_after(t)) : t;
    if (own.assembled_after < t) before = own.assembled_after;
  }
  return made_;
}

SegmentPlan SegmentPlaces::finish() {
  schedule();
  find_orders();
  place_fronts();
  if (outside_ == Outside::memory) {
    made_.lower_side = blocks_of(Side::lower);
    made_.upper_side = blocks_of(Side::upper);
  }
  return made_;
}

void SegmentPlaces::list_segments(const SegmentOrder& order) {
  made_.order = order.fronts;
  made_.level = order.level;
  made_.segment.resize(static_cast<std::size_t>(plan_.num_fronts));
  for (std::size_t t = 0; t + 1 < order.begin.size(); ++t) {
    Segment segment;
    segment.begin = order.begin[t];
    segment.end = order.begin[t + 1];
    segment.step = order.step[t];
    for (Vertex i = segment.begin; i < segment.end; ++i) {
      const Vertex f = order.fronts[i];
      segment.entries += lower_entries(f) + upper_entries(f);
      made_.segment[f] = count();
    }
    made_.segments.push_back(segment);
    if (segment.end - segment.begin == 1) divide(order.fronts[segment.begin]);
  }
  std::stable_sort(made_.border_columns.begin(), made_.border_columns.end(),
                   [](const BorderColumns& a, const BorderColumns& b) { return a.front < b.front; });
  upper_place_.assign(made_.border_columns.size(), 0);
}

// The front of the last segment, if it is too large.
void SegmentPlaces::divide(Vertex f) {
  const Vertex p = plan_.pivots(f), b = plan_.border_rows(f);
  const Offset lower = lower_entries(f), all = lower + upper_entries(f) + contribution_entries(f);
  if (way_.fronts == 0 || b == 0 || p == 0 || plan_.rows(f) <= small_rows_ || lower >= region_ ||
      all <= region_ / way_.fronts)
    return;
  const Offset child = last_child_beside(f, lower);
  const Offset fit = (region_ - lower - child) / way_.groups / (p + plan_.contribution_ld(f));
  const Vertex groups =
      tiles_of(b, static_cast<Vertex>(std::min<Offset>(std::max<Offset>(fit, kAlignment), b)));
  const Vertex width = static_cast<Vertex>(aligned(tiles_of(b, groups)));
  made_.segments.back().divided = true;
  for (Vertex begin = 0; begin < b; begin += width) {
    Segment segment;
    segment.begin = segment.end = made_.segments.back().end;
    segment.step = made_.segments.back().step;
    made_.border_columns.push_back({f, p + begin, p + std::min(begin + width, b), count(), 0, 0});
    made_.segments.push_back(segment);
  }
}

// Whether the contribution block of a front stays where it is beside so many entries of the parent, whose
// segment follows.
bool SegmentPlaces::stays_beside(Vertex f, Offset parent) const {
  constexpr Offset kParts = 8;
  return kParts * (contribution_entries(f) + parent) <= way_.beside * region_;
}

// Entries of that block if the front before the last segment is a child of its own.
Offset SegmentPlaces::last_child_beside(Vertex f, Offset lower) const {
  const Vertex begin = made_.segments.back().begin;
  const Vertex child = begin > 0 ? made_.order[begin - 1] : f;
  return plan_.parent[child] == f && stays_beside(child, lower) ? contribution_entries(child) : 0;
}

// Those of a segment that one other reads lie side by side.
void SegmentPlaces::group_contributions() {
  group_of_.assign(static_cast<std::size_t>(plan_.num_fronts), -1);
  std::map<std::pair<Vertex, Vertex>, std::size_t> group_at;
  for (const Vertex f : made_.order) {
    const Vertex parent = plan_.parent[f];
    if (parent < 0 || plan_.border_rows(f) == 0) continue;
    const Vertex reader = made_.segment[parent], last = made_.last_segment_of(parent);
    const bool divided = made_.segments[reader].divided;
    const Offset all = lower_entries(parent) + upper_entries(parent) + contribution_entries(parent);
    const bool beside =
        reader - made_.last_segment_of(f) == 1 && stays_beside(f, divided ? lower_entries(parent) : all);
    const auto [columns, end] = made_.columns_of(f);
    if (columns != end) group_of_[f] = static_cast<Offset>(contributions_.size());
    if (columns != end && beside) {
      contributions_.push_back({{contribution_entries(f), columns->segment, last, 0}, reader, false, f});
      continue;
    }
    for (auto own = columns; own != end; ++own)
      contributions_.push_back(
          {{aligned(contribution_entries(*own)), own->segment, last, 0}, reader, true, f});
    if (columns != end) continue;
    const std::pair<Vertex, Vertex> between{made_.segment[f], reader};
    const auto [at, is_new] = group_at.emplace(between, contributions_.size());
    if (is_new) {
      const bool leave = reader - between.first >= way_.leaving_distance || (divided && !beside);
      contributions_.push_back({{0, between.first, last, 0}, reader, leave, -1});
    }
    group_of_[f] = static_cast<Offset>(at->second);
    contributions_[at->second].made.entries += contribution_entries(f);
  }
  reads_outside_.assign(made_.segments.size(), 0);
  for (const Contributions& group : contributions_) {
    const auto first = reads_outside_.begin() + group.first_reader;
    if (group.leave) std::fill(first, reads_outside_.begin() + group.made.to + 1, 1);
  }
}

void SegmentPlaces::place_in_factorization(const Ahead& ahead) {
  std::vector<Block> blocks, staying;
  std::vector<Offset*> places;
  const auto first = [&](Vertex t) { return reads_outside_[t] ? std::max(t - ahead.assembled, 0) : t; };
  const auto add = [&](Offset entries, Vertex from, Vertex to, bool leaves, Offset& place) {
    const Vertex out = entries > region_ / 4 ? ahead.large_out : ahead.out;
    blocks.push_back({entries, from, to, 0, first(from), leaves ? to + out : to});
    places.push_back(&place);
  };
  for (Contributions& group : contributions_) {
    Block& made = group.made;
    add(made.entries, made.from, group.leave ? made.from : made.to, group.leave, made.place);
  }
  for (std::size_t i = 0; i < made_.border_columns.size(); ++i) {
    const BorderColumns& columns = made_.border_columns[i];
    add(upper_entries(columns), columns.segment, columns.segment, true, upper_place_[i]);
  }
  for (Vertex t = 0; t < stay_; ++t) {
    Segment& own = made_.segments[t];
    if (own.entries == 0) continue;
    const Vertex f = made_.order[own.begin], last = own.divided ? made_.last_segment_of(f) : t;
    add(own.divided ? lower_entries(f) : own.entries, t, last, true, own.place);
  }
  for (Vertex t = stay_; t < count(); ++t) {
    const Segment& own = made_.segments[t];
    staying.push_back({own.entries, t, count(), own.place, first(t), count()});
  }
  made_.region_entries = std::max(place_blocks(blocks, 0, staying, region_), made_.spare_begin);
  for (std::size_t i = 0; i < blocks.size(); ++i) *places[i] = blocks[i].place;
  blocks_ = std::move(blocks);
  blocks_.insert(blocks_.end(), staying.begin(), staying.end());
  std::stable_sort(blocks_.begin(), blocks_.end(),
                   [](const Block& a, const Block& b) { return a.from < b.from; });
  blocks_begin_.assign(made_.segments.size() + 1, 0);
  for (const Block& block : blocks_) ++blocks_begin_[block.from + 1];
  std::partial_sum(blocks_begin_.begin(), blocks_begin_.end(), blocks_begin_.begin());
}

// Whether segment t makes something that lies where this block does.
bool SegmentPlaces::writes_over(Vertex t, const Block& block) const {
  return std::any_of(blocks_.begin() + blocks_begin_[t], blocks_.begin() + blocks_begin_[t + 1],
                     [&](const Block& own) { return own.overlaps(block); });
}

// One more than the last segment of which something leaves that lies where segment t writes, or that it
// reads on the host.
Vertex SegmentPlaces::leaves_first(Vertex t) const {
  Vertex first = 0;
  for (const LeavingBlock& left : made_.leaving) {
    if (left.from >= t || left.from < first) continue;
    if (left.to == t || writes_over(t, {left.entries, left.from, left.from, left.place}))
      first = left.from + 1;
  }
  return first;
}

// One more than the last segment that uses what lies where segment t writes, or that makes contribution
// blocks which it reads on the device.
Vertex SegmentPlaces::assembled_after(Vertex t) const {
  Vertex after = made_.segments[t].leaves_first;
  for (const Block& block : blocks_) {
    if (block.from >= t) break;
    if (block.to >= after && writes_over(t, block)) after = block.to + 1;
  }
  for (const Contributions& group : contributions_) {
    if (group.leave || t < group.first_reader || t > group.made.to) continue;
    const Vertex made = group.divided < 0 ? group.made.from : made_.last_segment_of(group.divided);
    after = std::max(after, made + 1);
  }
  return after;
}

void SegmentPlaces::place_in_solve(Vertex back) {
  std::vector<Block> blocks;
  std::vector<Vertex> of_segment;
  for (Vertex t = 0; t < count(); ++t) {
    made_.segments[t].solve_place = made_.segments[t].place;
    if (!made_.segments[t].comes()) continue;
    blocks.push_back({made_.segments[t].entries, t, t + back, 0});
    of_segment.push_back(t);
  }
  const Offset end = place_blocks(blocks, made_.spare_begin + made_.spare_entries, {}, kNoLimit);
  for (std::size_t i = 0; i < blocks.size(); ++i) made_.segments[of_segment[i]].solve_place = blocks[i].place;
  made_.region_entries = std::max(made_.region_entries, end);
}

void SegmentPlaces::find_orders() {
  const auto meet = [&](Vertex a, Vertex b) {
    const Segment &one = made_.segments[a], &other = made_.segments[b];
    return other.comes() &&
           Block{one.entries, a, a, one.solve_place}.overlaps({other.entries, b, b, other.solve_place});
  };
  for (Vertex t = 0; t < stay_; ++t) {
    Segment& own = made_.segments[t];
    if (!own.comes()) continue;
    own.forward_after = t - 1;
    while (own.forward_after >= 0 && !meet(t, own.forward_after)) --own.forward_after;
    own.backward_after = t + 1;
    while (own.backward_after < stay_ && !meet(t, own.backward_after)) ++own.backward_after;
    if (own.backward_after == stay_) own.backward_after = -1;
  }
}

SideBlocks SegmentPlaces::blocks_of(Side side) const {
  SideBlocks made;
  for (const Segment& segment : made_.segments) {
    made.begin.push_back(made.blocks.size());
    if (segment.stays()) continue;
    std::vector<SegmentBlock> blocks;
    Offset upper = 0;
    for (Vertex i = segment.begin; i < segment.end; ++i) {
      const Vertex f = made_.order[i];
      add_lower_part(f, side, made_.lower[f] - segment.place, blocks);
      upper += upper_entries(f);
    }
    if (side == Side::upper) add_run(segment.entries - upper, upper, blocks);
    made.blocks.insert(made.blocks.end(), blocks.begin(), blocks.end());
  }
  made.begin.push_back(made.blocks.size());
  return made;
}

// What a pass reads of [P; L] of a front, which begins at `begin`.
void SegmentPlaces::add_lower_part(Vertex f, Side side, Offset begin,
                                   std::vector<SegmentBlock>& blocks) const {
  const Offset p = plan_.pivots(f), rows = plan_.rows(f), ld = plan_.lower_ld(f);
  const Offset small = std::min<Offset>(small_rows_, 1 << 20);
  const Offset least = std::max<Offset>(kLeastApart * small * small, kSolveTile * kSolveTile);
  Offset width =
      tiles_of(static_cast<Vertex>(std::max<Offset>(p, 1)), kMostColumnBlocks * kSolveTile) * kSolveTile;
  while (width * width < least) width += kSolveTile;
  const bool whole = p <= width && (side == Side::lower || p * (rows - p) < least);
  if (whole) return add_run(begin, lower_entries(f), blocks);
  for (Offset k = 0; k < p; k += width) {
    const Offset end = std::min(k + width, p), first = begin + k * ld;
    if (side == Side::upper) {
      blocks.push_back({first, end, ld, end - k});
    } else if (k == 0) {
      add_run(first, end * ld, blocks);
    } else {
      blocks.push_back({first + k, rows - k, ld, end - k});
    }
  }
}

void SegmentPlaces::list_leaving() {
  made_.leaving.clear();
  place_contributions_on_host();
  for (std::size_t i = 0; i < contributions_.size(); ++i) {
    const Contributions& group = contributions_[i];
    if (group.leave)
      made_.leaving.push_back(
          {group.made.from, group.first_reader, group.made.place, group.made.entries, on_host_[i]});
  }
  for (std::size_t i = 0; i < made_.border_columns.size(); ++i) {
    const BorderColumns& columns = made_.border_columns[i];
    const Vertex f = columns.front;
    const Offset host = made_.segments[made_.segment[f]].host + lower_entries(f) + upper_before(columns);
    const Offset entries = static_cast<Offset>(plan_.pivots(f)) * (columns.end - columns.begin);
    made_.leaving.push_back({columns.segment, -1, upper_place_[i], entries, host});
  }
  for (Vertex t = 0; t < stay_; ++t) {
    const Segment& own = made_.segments[t];
    if (own.stays()) continue;
    const Vertex f = made_.order[own.begin];
    const Vertex last = own.divided ? made_.last_segment_of(f) : t;
    made_.leaving.push_back({last, -1, own.place, own.divided ? lower_entries(f) : own.entries, own.host});
  }
  std::stable_sort(made_.leaving.begin(), made_.leaving.end(),
                   [](const LeavingBlock& a, const LeavingBlock& b) { return a.from < b.from; });
}

// Columns of one front lie side by side.
void SegmentPlaces::place_contributions_on_host() {
  std::vector<Block> blocks;
  std::vector<std::size_t> first_of;  // contributions_ that begin such a block
  for (std::size_t i = 0; i < contributions_.size(); ++i) {
    const Contributions& group = contributions_[i];
    if (!group.leave) continue;
    const bool goes_on = i > 0 && group.divided >= 0 && group.divided == contributions_[i - 1].divided;
    if (!goes_on) {
      blocks.push_back({0, group.made.from, group.made.to, 0});
      first_of.push_back(i);
    }
    blocks.back().entries += group.made.entries;
  }
  made_.leaving_entries = place_blocks(blocks, 0, {}, kNoLimit);
  on_host_.assign(contributions_.size(), -1);
  for (std::size_t k = 0; k < blocks.size(); ++k)
    on_host_[first_of[k]] = made_.host_entries + blocks[k].place;
  for (std::size_t i = 1; i < contributions_.size(); ++i) {
    if (contributions_[i].leave && on_host_[i] < 0)
      on_host_[i] = on_host_[i - 1] + contributions_[i - 1].made.entries;
  }
}

void SegmentPlaces::place_fronts() {
  const auto fronts = static_cast<std::size_t>(plan_.num_fronts);
  for (auto* all : {&made_.lower, &made_.upper, &made_.solve_lower, &made_.solve_upper}) all->resize(fronts);
  made_.contribution.assign(fronts, 0);
  made_.read_on_host.assign(fronts, -1);
  std::vector<Offset> next;
  for (const Contributions& group : contributions_) next.push_back(group.made.place);
  for (const Segment& segment : made_.segments) {
    Offset place = segment.place, upper = place;
    for (Vertex i = segment.begin; i < segment.end; ++i) upper += lower_entries(made_.order[i]);
    const Offset shift = (segment.solved_on_host ? segment.host : segment.solve_place) - segment.place;
    for (Vertex i = segment.begin; i < segment.end; ++i) {
      const Vertex f = made_.order[i];
      made_.lower[f] = place;
      made_.upper[f] = outside_ == Outside::memory ? upper : place + lower_entries(f);
      made_.solve_lower[f] = made_.lower[f] + shift;
      made_.solve_upper[f] = made_.upper[f] + shift;
      place += lower_entries(f) + (outside_ == Outside::memory ? 0 : upper_entries(f));
      upper += upper_entries(f);
      if (group_of_[f] < 0) continue;
      const Offset group = group_of_[f];
      made_.contribution[f] = next[group];
      if (on_host_[group] >= 0)
        made_.read_on_host[f] = on_host_[group] + next[group] - contributions_[group].made.place;
      next[group] += contribution_entries(f);
    }
  }
  place_border_columns();
}

void SegmentPlaces::place_border_columns() {
  for (std::size_t i = 0; i < made_.border_columns.size(); ++i) {
    BorderColumns& own = made_.border_columns[i];
    const Vertex f = own.front;
    own.upper = upper_place_[i] - upper_before(own);
    if (group_of_[f] < 0) continue;  // nobody reads it
    const auto group = contributions_.begin() + group_of_[f];
    own.contribution = group->leave
                           ? group[own.segment - made_.segment[f] - 1].made.place - contribution_before(own)
                           : group->made.place;
    if (own.begin == plan_.pivots(f)) made_.contribution[f] = own.contribution;
  }
}

}  // namespace mfs
