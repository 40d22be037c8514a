#include "plan/segments.hpp"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <limits>
#include <optional>

#include "ordering/first_error.hpp"
#include "plan/segment_clock.hpp"
#include "plan/segment_order.hpp"
#include "plan/segment_places.hpp"

namespace mfs {

namespace {

/// No segment takes more than one of these parts of the region, if it has two fronts.
constexpr Offset kParts[] = {8, 12, 20, 40};
constexpr Vertex kMostLevel = 10;
constexpr std::size_t kMostSegments = 1000;  // else places would take long to find

/// Those orders of levels [begin, end) that are worth a look.
std::vector<SegmentOrder> orders_of(const SymbolicPlan& plan, Offset region, Vertex begin, Vertex end) {
  std::vector<SegmentOrder> orders;
  for (Vertex level = begin; level < std::min({end, kMostLevel + 1, plan.num_depths}); ++level) {
    for (const Offset parts : kParts) {
      SegmentOrder order = order_segments(plan, level, std::max(region / parts, Offset{1}));
      if (level == 0 || order.step.size() <= kMostSegments) orders.push_back(std::move(order));
    }
  }
  return orders;
}

/// Calls work(i) for all i < count by all threads, or until one throws, which is thrown when all have ended.
template <class Work>
void for_all(std::size_t count, const Work& work) {
  FirstError error;
#pragma omp parallel for schedule(dynamic)
  for (std::size_t i = 0; i < count; ++i) error.attempt([&] { work(i); });
  error.rethrow();
}

/// From the one that overlaps most on.
constexpr Ahead kAhead[] = {{4, 3, 4, 1}, {4, 3, 4, 0}, {2, 3, 2, 0},
                            {1, 2, 1, 1}, {1, 1, 1, 0}, {0, 1, 0, 0}};
constexpr Ahead kLeastAhead = {0, 1, 0, 0};

/// How segments of one order fit into a region with the most of them staying.
struct Fit {
  Vertex first_staying = 0;
  Ahead ahead{};
};
/// `guess`: what was found for another Ahead, from where on it is looked for in ever longer steps.
std::optional<Fit> fit_into(SegmentPlaces& places, const Ahead& ahead, Offset region, Offset spare,
                            Vertex guess) {
  const auto is_room = [&](Vertex first_staying) {
    return places.place(first_staying, ahead, spare) <= region;
  };
  if (!is_room(places.count())) return {};
  Vertex fits = places.count(), fails = places.first_that_may_stay() - 1;
  for (Vertex step = 1, next = guess; fails < next && next < fits; step *= 2) {
    if (is_room(next)) {
      fits = next;
      next = fits - step;
    } else {
      fails = next;
      next = fails + step;
    }
  }
  while (fits - fails > 1) {
    const Vertex middle = fails + (fits - fails) / 2;
    (is_room(middle) ? fits : fails) = middle;
  }
  return Fit{fits, ahead};
}

}  // namespace

Offset SegmentPlan::blocks_out() const {
  Offset sum = 0;
  for (const LeavingBlock& block : leaving) sum += block.to >= 0 ? block.entries : 0;
  return sum;
}

Offset SideBlocks::entries(Vertex t) const {
  Offset sum = 0;
  for (std::size_t i = begin[t]; i < begin[t + 1]; ++i) sum += blocks[i].rows * blocks[i].columns;
  return sum;
}

Offset SegmentPlan::entries_back() const {
  Offset sum = 0;
  for (std::size_t t = 0; t < segments.size(); ++t) {
    const Segment& own = segments[t];
    const auto k = static_cast<Vertex>(t);
    if (own.stays()) continue;
    if (own.comes() && own.backward_after < 0) {
      sum += own.entries;
    } else {
      sum += lower_side.empty() ? 2 * own.entries : lower_side.entries(k) + upper_side.entries(k);
    }
  }
  return sum;
}

std::pair<const BorderColumns*, const BorderColumns*> SegmentPlan::columns_of(Vertex f) const {
  const auto before = [](const BorderColumns& columns, Vertex front) { return columns.front < front; };
  const BorderColumns* const end = border_columns.data() + border_columns.size();
  const BorderColumns* const first = std::lower_bound(border_columns.data(), end, f, before);
  return {first, std::lower_bound(first, end, f + 1, before)};
}

Vertex SegmentPlan::segment_of(Vertex f, Vertex column) const {
  const auto [columns, end] = columns_of(f);
  for (const BorderColumns* own = columns; own != end; ++own) {
    if (own->begin <= column && column < own->end) return own->segment;
  }
  return segment[f];
}

Vertex SegmentPlan::last_segment_of(Vertex f) const {
  const auto [columns, end] = columns_of(f);
  return columns == end ? segment[f] : (end - 1)->segment;
}

namespace {

/// By turns: those of a later one are tried where none of the earlier ones fits, and those of the next one
/// where what fits leaves kernels and copies waiting for each other.
constexpr Vertex kNever = std::numeric_limits<Vertex>::max();
constexpr struct {
  int turn;
  Way way;
} kWays[] = {{0, {kNever, 0, 0, 0}}, {1, {5, 0, 0, 0}},       {1, {kNever, 2, 5, 5}}, {1, {kNever, 2, 5, 6}},
             {1, {kNever, 4, 5, 6}}, {1, {kNever, 4, 12, 5}}, {2, {2, 0, 0, 0}},      {2, {5, 2, 5, 6}},
             {2, {5, 4, 12, 5}},     {3, {2, 3, 5, 5}},       {3, {2, 4, 12, 5}},     {4, {2, 3, 5, 0}},
             {4, {2, 4, 12, 0}}};
constexpr int kTurns = 5;

/// What those read in place that leaves the region.
bool reads_outside(const Way& way) {
  return way.leaving_distance != kNever || way.fronts > 0;
}

/// Whether each front that stays whole has room alone.
bool have_room(const SymbolicPlan& plan, Offset region, const Way& way) {
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    const Offset p = plan.pivots(f), b = plan.border_rows(f), lower = p * plan.lower_ld(f);
    if (lower > region) return false;
    if (way.fronts == 0 && lower + p * b + b * plan.contribution_ld(f) > region) return false;
  }
  return true;
}

/// What was found best: how the segments of an order fit. Without an order where nothing fits.
struct Found {
  SegmentOrder order;
  Way way{};
  Fit fit;
  double seconds = std::numeric_limits<double>::max();  // of a refactorization and a solve
};

// Finds the best plan for one region, way by way.
class Search {
 public:
  Search(const SymbolicPlan& plan, Offset region, Offset spare, Vertex small_rows, Outside outside)
      : plan_(plan),
        region_(region),
        spare_(spare),
        small_rows_(small_rows),
        outside_(outside),
        clock_(plan, outside) {}

  bool found() const { return !least_.order.step.empty(); }
  /// Whether what was found sends segments to the host while others are made.
  bool overlaps() const { return least_.fit.ahead.out > 0; }
  SegmentPlan finish() const {
    SegmentPlaces places(plan_, least_.order, least_.way, region_, small_rows_, outside_);
    places.place(least_.fit.first_staying, least_.fit.ahead, spare_);
    return places.finish();
  }

  /// Some levels at a time, as long as they bring anything.
  void try_way(const Way& way) {
    constexpr Vertex kLevelsAtOnce = 4;
    if (!have_room(plan_, region_, way)) return;
    for (Vertex level = 0; level <= kMostLevel; level += kLevelsAtOnce) {
      std::vector<SegmentOrder> orders = orders_of(plan_, region_, level, level + kLevelsAtOnce);
      std::vector<Found> best(orders.size());
      for_all(orders.size(), [&](std::size_t i) { best[i] = best_of(std::move(orders[i]), way); });
      const double before = least_.seconds;
      for (Found& one : best) {
        if (one.seconds < least_.seconds) least_ = std::move(one);
      }
      if (found() && least_.seconds == before) return;
    }
  }

 private:
  Found best_of(SegmentOrder order, const Way& way) {
    Found best;
    best.way = way;
    SegmentPlaces places(plan_, order, way, region_, small_rows_, outside_);
    if (clock_.least_seconds(places.segments(), region_) > least_so_far_) return best;
    Vertex guess = places.count();
    for (const Ahead& ahead : kAhead) {
      if (ahead.assembled > 0 && !reads_outside(way)) continue;  // nothing is assembled early
      const std::optional<Fit> fit = fit_into(places, ahead, region_, spare_, guess);
      if (!fit) continue;
      guess = fit->first_staying;
      places.place(fit->first_staying, ahead, spare_);
      const double seconds = clock_.seconds(places.schedule());
      if (seconds < best.seconds) {
        best.fit = *fit;
        best.seconds = seconds;
      }
    }
    if (best.seconds < std::numeric_limits<double>::max()) best.order = std::move(order);
    for (double least = least_so_far_; best.seconds < least;) {
      if (least_so_far_.compare_exchange_weak(least, best.seconds)) break;
    }
    return best;
  }

  const SymbolicPlan& plan_;
  const Offset region_, spare_;
  const Vertex small_rows_;
  const Outside outside_;
  const SegmentClock clock_;
  Found least_;
  std::atomic<double> least_so_far_ = std::numeric_limits<double>::max();  // s, of all threads
};

}  // namespace

SegmentPlan make_segments(const SymbolicPlan& plan, Offset region, Offset spare, Vertex small_rows,
                          Outside outside) {
  Search search(plan, region, spare, small_rows, outside);
  int turns = kTurns;
  for (int turn = 0; turn < turns; ++turn) {
    const bool first = !search.found();
    for (const auto& [when, way] : kWays) {
      if (when != turn || (outside == Outside::file && reads_outside(way))) continue;
      search.try_way(way);
    }
    if (first && search.found()) turns = std::min(kTurns, turn + (search.overlaps() ? 1 : 2));
  }
  return search.found() ? search.finish() : SegmentPlan();
}

Offset least_region(const SymbolicPlan& plan, Offset spare, Vertex small_rows, Outside outside) {
  Offset least = plan.storage_entries + spare;
  // The sizes of segments are bounded by parts of the region: what was found is tried for what it takes.
  for (Offset before = 0; before != least;) {
    before = least;
    const std::vector<SegmentOrder> orders = orders_of(plan, before, 0, kMostLevel + 1);
    for (const auto& [turn, way] : kWays) {
      if (outside == Outside::file ? reads_outside(way) : turn + 1 < kTurns) continue;
      std::vector<Offset> takes(orders.size());
      for_all(orders.size(), [&, &way = way](std::size_t i) {  // clang's OpenMP takes no structured bindings
        SegmentPlaces places(plan, orders[i], way, before, small_rows, outside);
        takes[i] = places.place(places.count(), kLeastAhead, spare);
      });
      for (const Offset entries : takes) least = std::min(least, entries);
    }
    if (before - least < before / 16) break;
  }
  while (make_segments(plan, least, spare, small_rows, outside).empty()) least += aligned(least / 50 + 1);
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
