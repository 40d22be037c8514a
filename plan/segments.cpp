#include "plan/segments.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "plan/segment_order.hpp"

namespace mfs {

namespace {

/// Entries of the region from segment `from` to segment `to`, both included.
struct Block {
  Offset entries;
  Vertex from, to;
  Offset place;

  bool meets(const Block& other) const { return from <= other.to && other.from <= to; }
  bool overlaps(const Block& other) const {
    return place < other.place + other.entries && other.place < place + entries;
  }
};

/// Gives blocks their places from `begin` on, the largest first, each in the first gap that has room for it
/// beside those that it meets; `fixed` have theirs, and ascend by them. Returns where the last one ends.
Offset place_blocks(std::vector<Block>& blocks, Offset begin, const std::vector<Block>& fixed) {
  std::vector<std::size_t> by_size(blocks.size());
  std::iota(by_size.begin(), by_size.end(), std::size_t{0});
  std::stable_sort(by_size.begin(), by_size.end(),
                   [&](std::size_t a, std::size_t b) { return blocks[a].entries > blocks[b].entries; });
  std::vector<const Block*> placed;  // by place
  for (const Block& block : fixed) placed.push_back(&block);
  Offset most = begin;
  for (const std::size_t i : by_size) {
    Block& block = blocks[i];
    block.place = begin;
    for (const Block* other : placed) {
      if (!other->meets(block)) continue;
      if (block.place + block.entries <= other->place) break;
      block.place = std::max(block.place, other->place + other->entries);
    }
    const auto after = std::upper_bound(placed.begin(), placed.end(), &block,
                                        [](const Block* a, const Block* b) { return a->place < b->place; });
    placed.insert(after, &block);
    most = std::max(most, block.place + block.entries);
  }
  return most;
}

/// How many segments may be on their way to the host while another is made, and on their way back.
struct Ahead {
  Vertex out, back;
};
constexpr Ahead kAhead[] = {{2, 3}, {1, 2}, {1, 1}};

/// Places the segments of one order; one use for each place().
class Places {
 public:
  /// Contribution blocks leave if as many segments are done until they are read.
  Places(const SymbolicPlan& plan, const SegmentOrder& order, Vertex leaving_distance)
      : plan_(plan), made_(begin(plan, order)), leaving_distance_(leaving_distance) {
    group_contributions();
  }

  Vertex count() const { return static_cast<Vertex>(made_.segments.size()); }

  /// Where segments from `first_staying` on stay. Returns the entries of the region that it takes.
  Offset place(Vertex first_staying, const Ahead& ahead, Offset spare) {
    stay_ = first_staying;
    Offset next = 0, host = 0;
    for (Vertex t = 0; t < count(); ++t) {
      Segment& segment = made_.segments[t];
      segment.host = t < stay_ ? host : -1;
      host += t < stay_ ? segment.entries : 0;
    }
    made_.host_entries = host;
    for (Vertex t = stay_; t < count(); ++t) {
      made_.segments[t].place = next;
      next += made_.segments[t].entries;
    }
    made_.spare_begin = next;
    made_.spare_entries = spare;
    place_in_factorization(ahead.out);
    place_in_solve(ahead.back);
    return made_.region_entries;
  }

  /// The plan as it was placed last.
  SegmentPlan finish() {
    find_orders();
    place_leaving();
    place_fronts();
    return made_;
  }
  Offset host_entries() const { return made_.host_entries; }
  Offset blocks_out() const {
    Offset sum = 0;
    for (const Block& block : contributions_) sum += leaves(block) ? block.entries : 0;
    return sum;
  }

 private:
  static Offset lower_entries(const SymbolicPlan& plan, Vertex f) {
    return aligned(static_cast<Offset>(plan.pivots(f)) * plan.lower_ld(f));
  }
  static Offset upper_entries(const SymbolicPlan& plan, Vertex f) {
    return aligned(static_cast<Offset>(plan.pivots(f)) * plan.border_rows(f));
  }
  Offset contribution_entries(Vertex f) const {
    return aligned(static_cast<Offset>(plan_.border_rows(f)) * plan_.contribution_ld(f));
  }

  static SegmentPlan begin(const SymbolicPlan& plan, const SegmentOrder& order) {
    SegmentPlan made;
    made.order = order.fronts;
    made.level = order.level;
    made.segment.resize(static_cast<std::size_t>(plan.num_fronts));
    for (std::size_t t = 0; t + 1 < order.begin.size(); ++t) {
      Segment segment;
      segment.begin = order.begin[t];
      segment.end = order.begin[t + 1];
      segment.step = order.step[t];
      for (Vertex i = segment.begin; i < segment.end; ++i) {
        const Vertex f = order.fronts[i];
        segment.entries += lower_entries(plan, f) + upper_entries(plan, f);
        made.segment[f] = static_cast<Vertex>(t);
      }
      made.segments.push_back(segment);
    }
    return made;
  }

  // Those of a segment that one other reads lie side by side.
  void group_contributions() {
    group_of_.assign(static_cast<std::size_t>(plan_.num_fronts), -1);
    std::map<std::pair<Vertex, Vertex>, std::size_t> group_at;
    for (const Vertex f : made_.order) {
      if (plan_.parent[f] < 0 || plan_.border_rows(f) == 0) continue;
      const std::pair<Vertex, Vertex> between{made_.segment[f], made_.segment[plan_.parent[f]]};
      const auto [at, is_new] = group_at.emplace(between, contributions_.size());
      if (is_new) contributions_.push_back({0, between.first, between.second, 0});
      group_of_[f] = static_cast<Offset>(at->second);
      contributions_[at->second].entries += contribution_entries(f);
    }
  }

  bool leaves(const Block& group) const { return group.to - group.from >= leaving_distance_; }

  void place_in_factorization(Vertex out) {
    std::vector<Block> blocks = contributions_, staying;
    for (Block& block : blocks) {
      if (leaves(block)) block.to = std::min(block.to, block.from + out);
    }
    for (Vertex t = 0; t < stay_; ++t) blocks.push_back({made_.segments[t].entries, t, t + out, 0});
    for (Vertex t = stay_; t < count(); ++t)
      staying.push_back({made_.segments[t].entries, t, count() + out, made_.segments[t].place});
    const Offset end = std::max(place_blocks(blocks, 0, staying), made_.spare_begin);
    for (std::size_t i = 0; i < contributions_.size(); ++i) contributions_[i].place = blocks[i].place;
    for (Vertex t = 0; t < stay_; ++t)
      made_.segments[t].place = blocks[contributions_.size() + static_cast<std::size_t>(t)].place;
    made_.region_entries = end;
  }

  // One more than the last segment of which something leaves that lies where segment t writes, or that it
  // reads on the host.
  Vertex leaves_first(Vertex t) const {
    const Segment& own = made_.segments[t];
    std::vector<Block> writes{{own.entries, t, t, own.place}};
    for (const Block& block : contributions_) {
      if (block.from == t) writes.push_back(block);
    }
    const auto in_the_way = [&](const Block& left) {
      return std::any_of(writes.begin(), writes.end(),
                         [&](const Block& block) { return block.overlaps(left); });
    };
    Vertex first = 0;
    for (const Block& block : contributions_) {
      if (block.from < t && leaves(block) && (block.to == t || in_the_way(block)))
        first = std::max(first, block.from + 1);
    }
    for (Vertex before = std::min(t, stay_) - 1; before >= first; --before) {
      if (in_the_way({made_.segments[before].entries, before, before, made_.segments[before].place}))
        return before + 1;
    }
    return first;
  }

  void place_in_solve(Vertex back) {
    std::vector<Block> blocks;
    for (Vertex t = 0; t < stay_; ++t) blocks.push_back({made_.segments[t].entries, t, t + back, 0});
    const Offset end = place_blocks(blocks, made_.spare_begin + made_.spare_entries, {});
    for (Vertex t = 0; t < stay_; ++t) made_.segments[t].solve_place = blocks[t].place;
    for (Vertex t = stay_; t < count(); ++t) made_.segments[t].solve_place = made_.segments[t].place;
    made_.region_entries = std::max(made_.region_entries, end);
  }

  void find_orders() {
    for (Vertex t = 0; t < count(); ++t) made_.segments[t].leaves_first = leaves_first(t);
    const auto block = [&](Vertex t) {
      const Segment& segment = made_.segments[t];
      return Block{segment.entries, t, t, segment.solve_place};
    };
    for (Vertex t = 0; t < stay_; ++t) {
      Segment& own = made_.segments[t];
      own.forward_after = t - 1;
      while (own.forward_after >= 0 && !block(t).overlaps(block(own.forward_after))) --own.forward_after;
      own.backward_after = t + 1;
      while (own.backward_after < stay_ && !block(t).overlaps(block(own.backward_after)))
        ++own.backward_after;
      if (own.backward_after == stay_) own.backward_after = -1;
    }
  }

  void place_leaving() {
    std::vector<Block> blocks;
    for (const Block& block : contributions_) {
      if (leaves(block)) blocks.push_back(block);
    }
    made_.leaving_entries = place_blocks(blocks, 0, {});
    on_host_.assign(contributions_.size(), -1);
    std::size_t next = 0;
    for (std::size_t i = 0; i < contributions_.size(); ++i) {
      const Block& block = contributions_[i];
      if (!leaves(block)) continue;
      on_host_[i] = made_.host_entries + blocks[next++].place;
      made_.leaving.push_back({block.from, block.to, block.place, block.entries, on_host_[i]});
    }
  }

  void place_fronts() {
    const auto fronts = static_cast<std::size_t>(plan_.num_fronts);
    made_.lower.resize(fronts);
    made_.upper.resize(fronts);
    made_.contribution.assign(fronts, 0);
    made_.read_on_host.assign(fronts, -1);
    std::vector<Offset> next;
    for (const Block& block : contributions_) next.push_back(block.place);
    for (const Segment& segment : made_.segments) {
      Offset place = segment.place;
      for (Vertex i = segment.begin; i < segment.end; ++i) {
        const Vertex f = made_.order[i];
        made_.lower[f] = place;
        made_.upper[f] = place + lower_entries(plan_, f);
        place = made_.upper[f] + upper_entries(plan_, f);
        if (group_of_[f] < 0) continue;
        const Offset group = group_of_[f];
        made_.contribution[f] = next[group];
        if (on_host_[group] >= 0)
          made_.read_on_host[f] = on_host_[group] + next[group] - contributions_[group].place;
        next[group] += contribution_entries(f);
      }
    }
  }

  const SymbolicPlan& plan_;
  SegmentPlan made_;
  const Vertex leaving_distance_;
  std::vector<Block> contributions_;  // one for each pair of segments, by the first
  std::vector<Offset> on_host_;       // of them: where they lie there, -1 if they do not leave
  std::vector<Offset> group_of_;      // of fronts: in contributions_, -1 for none
  Vertex stay_ = 0;                   // the first segment that stays
};

/// No segment takes more than one of these parts of the region, if it has two fronts.
constexpr Offset kParts[] = {12, 40};
constexpr Vertex kMostLevel = 10;
constexpr std::size_t kMostSegments = 3000;  // else places would take long to find
/// What a level costs beside what it keeps on the device, as a part of the factors.
constexpr double kLevelCost = 0.03;

/// The orders of a plan, from the one with the fewest levels on. `visit(order)` returns whether to go on.
template <class Visit>
void for_each_order(const SymbolicPlan& plan, Offset region, const Visit& visit) {
  for (Vertex level = 0; level <= std::min(kMostLevel, plan.num_depths - 1); ++level) {
    for (const Offset parts : kParts) {
      const SegmentOrder order = order_segments(plan, level, std::max(region / parts, Offset{1}));
      if (level > 0 && order.step.size() > kMostSegments) return;
      if (!visit(order)) return;
    }
  }
}

/// How segments of one order fit into a region with the most of them staying.
struct Fit {
  Vertex first_staying = 0;
  Ahead ahead{};
};
std::optional<Fit> fit_into(Places& places, Offset region, Offset spare) {
  for (const Ahead& ahead : kAhead) {
    if (places.place(places.count(), ahead, spare) > region) continue;
    Vertex fits = places.count(), fails = -1;
    while (fits - fails > 1) {
      const Vertex middle = fails + (fits - fails) / 2;
      (places.place(middle, ahead, spare) <= region ? fits : fails) = middle;
    }
    return Fit{fits, ahead};
  }
  return {};
}

}  // namespace

Offset SegmentPlan::blocks_out() const {
  Offset sum = 0;
  for (const LeavingBlocks& blocks : leaving) sum += blocks.entries;
  return sum;
}

Offset SegmentPlan::entries_back() const {
  Offset sum = 0;
  for (const Segment& own : segments) {
    if (!own.stays()) sum += own.entries * (own.backward_after < 0 ? 1 : 2);
  }
  return sum;
}

namespace {

/// Contribution blocks leave in none, in some, or in all cases where that makes room.
constexpr Vertex kLeavingDistances[] = {std::numeric_limits<Vertex>::max(), 5, 2};

SegmentPlan best_segments(const SymbolicPlan& plan, Offset region, Offset spare, Vertex leaving_distance) {
  SegmentPlan best;
  double least = std::numeric_limits<double>::max();
  for_each_order(plan, region, [&](const SegmentOrder& order) {
    // More levels can only pay by what they keep on the device.
    const double for_levels = order.level * kLevelCost * static_cast<double>(plan.factor_entries);
    if (for_levels >= least) return false;
    Places places(plan, order, leaving_distance);
    const std::optional<Fit> fit = fit_into(places, region, spare);
    if (!fit) return true;
    places.place(fit->first_staying, fit->ahead, spare);
    const double cost = static_cast<double>(places.host_entries() + places.blocks_out()) + for_levels;
    if (cost < least) {
      least = cost;
      best = places.finish();
    }
    return true;
  });
  return best;
}

}  // namespace

SegmentPlan make_segments(const SymbolicPlan& plan, Offset region, Offset spare) {
  for (const Vertex leaving_distance : kLeavingDistances) {
    SegmentPlan best = best_segments(plan, region, spare, leaving_distance);
    if (!best.empty()) return best;
  }
  return {};
}

Offset least_region(const SymbolicPlan& plan, Offset spare) {
  Offset least = plan.storage_entries + spare;
  // The sizes of segments are bounded by parts of the region: what was found is tried for what it takes.
  for (Offset before = 0; before != least;) {
    before = least;
    for_each_order(plan, before, [&](const SegmentOrder& order) {
      Places places(plan, order, *(std::end(kLeavingDistances) - 1));
      least = std::min(least, places.place(places.count(), kAhead[2], spare));
      return true;
    });
    if (before - least < before / 16) break;
  }
  while (make_segments(plan, least, spare).empty()) least += aligned(least / 50 + 1);
  return least;
}

SymbolicPlan placed_by(const SegmentPlan& segments, const SymbolicPlan& plan) {
  SymbolicPlan placed = plan;
  placed.lower_begin = segments.lower;
  placed.upper_begin = segments.upper;
  placed.contribution_begin = segments.contribution;
  placed.assembly_turn.assign(plan.assembly_turn.size(), 0);
  placed.storage_entries = segments.region_entries;
#pragma omp parallel for schedule(dynamic, 64)
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    const Offset lower = segments.lower[f] - plan.lower_begin[f],
                 upper = segments.upper[f] - plan.upper_begin[f];
    for (Offset e = plan.entry_begin[f]; e < plan.entry_begin[f + 1]; ++e)
      placed.entry_target[e] += plan.entry_target[e] < plan.upper_begin[f] ? lower : upper;
  }
  return placed;
}

}  // namespace mfs
