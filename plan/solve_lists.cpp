#include "plan/solve_lists.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include <mfs/error.hpp>

#include "plan/spans.hpp"

namespace mfs {

namespace {

constexpr int kFrontsAtOnce = 64;  // of a thread

}  // namespace

void SolveLists::run() {
  number_rows();
  place_factors();
  list_solve();
  list_sources();
  list_wide_tiles();
}

// Each depth waits for the one before it: forward for the deeper one, backward for the higher one.
void SolveLists::list_solve() {
  std::vector<SolveDepth> depths;
  if (by_segments()) {
    depths = segments_of_depths();
  } else {
    for (Vertex k = 0; k < plan_.num_depths; ++k) {
      SortedFronts fronts = sort_depth(k);
      depths.push_back({std::move(fronts.in_tiles), list_tiny(fronts.tiny), fronts.crowded});
    }
  }
  for (const SolveDepth& depth : depths) {
    list_tiles(depth, made_.forward, [&] { list_forward(depth); });
    forward_launch_.push_back(made_.forward.size() - 1);
  }
  for (auto depth = depths.rbegin(); depth != depths.rend(); ++depth)
    list_tiles(*depth, made_.backward, [&] { list_backward(depth->fronts); });
}

// What is done with a front is decided for its depth as a whole.
std::vector<SolveLists::SolveDepth> SolveLists::segments_of_depths() {
  const std::vector<Segment>& segments = made_.segments.segments;
  std::vector<std::vector<Vertex>> tiny(segments.size()), in_tiles(segments.size());
  std::vector<char> crowded;
  for (Vertex k = 0; k < plan_.num_depths; ++k) {
    const SortedFronts fronts = sort_depth(k);
    for (const Vertex f : fronts.tiny) tiny[made_.segments.segment[f]].push_back(f);
    for (const Vertex f : fronts.in_tiles) in_tiles[made_.segments.segment[f]].push_back(f);
    crowded.push_back(fronts.crowded);
  }
  std::vector<SolveDepth> made;
  for (std::size_t t = 0; t < segments.size(); ++t)
    made.push_back({std::move(in_tiles[t]), list_tiny(tiny[t]), crowded[segments[t].step] != 0});
  return made;
}

SolveLists::SortedFronts SolveLists::sort_depth(Vertex step) const {
  SortedFronts depth;
  std::vector<Vertex>& tiny = depth.tiny;
  for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) {
    const Offset entries = static_cast<Offset>(plan_.pivots(f)) * plan_.rows(f);
    (plan_.pivots(f) <= kTinyPivots && entries <= kTinyEntries ? tiny : depth.in_tiles).push_back(f);
  }
  if (static_cast<Vertex>(tiny.size()) < limits_.many_tiny) {
    depth.in_tiles.insert(depth.in_tiles.end(), tiny.begin(), tiny.end());
    tiny.clear();
  }
  Vertex tiles = 0;
  for (const Vertex f : depth.in_tiles) tiles += steps_of_border(f);
  depth.crowded = tiles > limits_.crowd;
  return depth;
}

Range SolveLists::list_tiny(const std::vector<Vertex>& tiny) {
  const auto begin = static_cast<Offset>(made_.tiny_fronts.size());
  made_.tiny_fronts.insert(made_.tiny_fronts.end(), tiny.begin(), tiny.end());
  return {begin, static_cast<Offset>(made_.tiny_fronts.size())};
}

template <class List>
void SolveLists::list_tiles(const SolveDepth& depth, std::vector<SolveLaunch>& launches, const List& list) {
  const Offset begin = static_cast<Offset>(made_.solve.size());
  list();
  if (launches.empty() || by_segments() || launches.back().tiny.count() > 0 || depth.tiny.count() > 0)
    launches.push_back({depth.tiny, {begin, begin}, {}});
  launches.back().tiles.end = static_cast<Offset>(made_.solve.size());
}

Vertex SolveLists::most_solve_tiles(const std::vector<Vertex>& fronts) const {
  Vertex most = 0;
  for (const Vertex f : fronts) most = std::max(most, solve_tiles(f));
  return most;
}

// The tiles of a front in the order in which they depend on each other, those of all fronts by turns.
void SolveLists::list_forward(const SolveDepth& depth) {
  const std::vector<Vertex>& fronts = depth.fronts;
  const Vertex most = most_solve_tiles(fronts);
  for (Vertex i = 0; i < most; ++i) {
    for (const Vertex f : fronts) {
      if (i < solve_tiles(f)) add_part({f, i * kSolveTile, 0, i, true, 0, 0, {}, kSolveTile});
    }
  }
  for (const Vertex f : fronts) {
    const Vertex height = depth.crowded && solve_tiles(f) == 1 ? kTallTile : kSolveTile;
    for (Vertex i = 0; i < plan_.border_rows(f); i += height)
      add_part({f, plan_.pivots(f) + i, 0, solve_tiles(f), true, 0, 0, {}, height});
  }
}

// The other way round, and only pivots. By turns too, but tiles come some turns before their parts: what
// they wait for in the pivot block takes them long, and no block that has begun stands in the way of a
// part.
void SolveLists::list_backward(const std::vector<Vertex>& fronts) {
  const Vertex most = most_solve_tiles(fronts);
  std::vector<Offset> places;
  for (const Vertex f : fronts) {
    places.push_back(made_.solve_places);
    made_.solve_places += static_cast<Offset>(solve_tiles(f)) * parts_of_border(f);
  }
  const Vertex lead = fronts.empty() ? 0 : limits_.waiting_tiles / static_cast<Vertex>(fronts.size());
  for (Vertex turn = -lead; turn < most; ++turn) {
    for (std::size_t i = 0; i < fronts.size(); ++i) list_parts_back(fronts[i], turn, places[i]);
    for (std::size_t i = 0; i < fronts.size(); ++i) list_tile_back(fronts[i], turn + lead, places[i]);
  }
}

Vertex SolveLists::solve_tiles(Vertex f) const {
  return tiles_of(plan_.pivots(f), kSolveTile);
}
Vertex SolveLists::steps_of_border(Vertex f) const {
  return tiles_of(plan_.border_rows(f), kSolveTile);
}
Vertex SolveLists::parts_of_border(Vertex f) const {
  return steps_of_border(f) / limits_.solve_steps;
}
// Row where the tile of this turn begins: the last tile has the first turn.
Vertex SolveLists::tile_of_turn(Vertex f, Vertex turn) const {
  return (solve_tiles(f) - 1 - turn) * kSolveTile;
}

void SolveLists::list_parts_back(Vertex f, Vertex turn, Offset first_place) {
  if (turn < 0 || turn >= solve_tiles(f)) return;
  const Vertex parts = parts_of_border(f), steps = limits_.solve_steps;
  for (Vertex i = 0; i < parts; ++i) {
    const Offset place = first_place + static_cast<Offset>(turn) * parts + i;
    add_part({f, tile_of_turn(f, turn), i * steps, (i + 1) * steps, false, place, 0, {}, kSolveTile});
  }
}
// The steps of the border that are left, and those of the pivot block, which wait for other tiles.
void SolveLists::list_tile_back(Vertex f, Vertex turn, Offset first_place) {
  if (turn >= solve_tiles(f)) return;
  const Vertex parts = parts_of_border(f), last = steps_of_border(f) + turn;
  const Offset place = first_place + static_cast<Offset>(turn) * parts;
  add_part({f, tile_of_turn(f, turn), parts * limits_.solve_steps, last, true, place, parts, {}, kSolveTile});
}

void SolveLists::add_part(SolvePart part) {
  const Vertex f = part.front;
  part.where = {lower_of(f),          upper_of(f),     plan_.border_begin[f], made_.row_begin[f],
                plan_.pivot_begin[f], plan_.pivots(f), plan_.border_rows(f),  plan_.lower_ld(f)};
  part.rows =
      std::min(part.rows, (part.begin < plan_.pivots(f) ? plan_.pivots(f) : plan_.rows(f)) - part.begin);
  made_.solve.push_back(part);
}

// Those of segments are divided among them later.
void SolveLists::list_wide_tiles() {
  for (Vertex f = 0; f < plan_.num_fronts; ++f) {
    for (Vertex k = 0; k + kInverted < plan_.pivots(f); k += kSolveTile)
      made_.wide_tiles.push_back({f, k, k});
  }
}

void SolveLists::place_factors() {
  if (!by_segments()) return;
  made_.solve_lower = made_.segments.solve_lower;
  made_.solve_upper = made_.segments.solve_upper;
}

void SolveLists::number_rows() {
  Offset row = 0;
  for (Vertex step = 0; step < plan_.num_depths; ++step) {
    for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) {
      made_.row_begin.push_back(row);
      row += plan_.rows(f);
    }
    ++row;  // where the last row of the step ends
  }
  made_.source_begin.resize(static_cast<std::size_t>(row));
}

// Row i of a front counts at its source_begin[i + 1]; then source_begin[i] is the place of its next source,
// until all have theirs.
void SolveLists::list_sources() {
  made_.destination.resize(plan_.border.size());
  made_.source_begin.front() = 0;
#pragma omp parallel for schedule(dynamic, kFrontsAtOnce)
  for (Vertex f = 0; f < plan_.num_fronts; ++f) {
    Vertex* const counts = &made_.source_begin[made_.row_begin[f] + 1];
    std::fill_n(counts, plan_.rows(f), 0);
    for_each_child_row(f, [&](Vertex row, Offset) { ++counts[row]; });
  }
  place_sources();
#pragma omp parallel for schedule(dynamic, kFrontsAtOnce)
  for (Vertex f = 0; f < plan_.num_fronts; ++f) {
    Vertex* const next = &made_.source_begin[made_.row_begin[f]];
    const Vertex first = *next;
    for_each_child_row(f, [&](Vertex row, Offset place) { made_.destination[place] = next[row]++; });
    std::copy_backward(next, next + plan_.rows(f) - 1, next + plan_.rows(f));
    *next = first;
  }
}

// From counts to places.
void SolveLists::place_sources() {
  std::vector<Offset> next = place_borders();
  RawVector<Vertex>& places = made_.source_begin;
  for (Vertex step = 1; step < plan_.num_depths; ++step) {
    const bool last = step + 1 == plan_.num_depths;
    const auto begin = places.begin() + made_.row_begin[plan_.depth_begin[step]];
    const auto end = last ? places.end() : places.begin() + made_.row_begin[plan_.depth_begin[step + 1]];
    Offset& of_children = next[by_segments() ? 0 : forward_launch_[step - 1]];
    *begin = static_cast<Vertex>(of_children);
    std::partial_sum(begin, end, begin);
    of_children += border_rows_of(step - 1);
  }
}

// Where what each launch leaves begins. It is read by the same launch and the next one, so two share a
// place by turns. What segments leave is read later, and all have places of their own.
std::vector<Offset> SolveLists::place_borders() {
  if (by_segments()) {
    count_borders(static_cast<Offset>(plan_.border.size()));
    return {0};
  }
  std::vector<Offset> count(made_.forward.size(), 0), begin;
  for (Vertex step = 0; step < plan_.num_depths; ++step) count[forward_launch_[step]] += border_rows_of(step);
  Offset most[2] = {0, 0};
  for (std::size_t launch = 0; launch < count.size(); ++launch)
    most[launch % 2] = std::max(most[launch % 2], count[launch]);
  count_borders(most[0] + most[1]);
  for (std::size_t launch = 0; launch < count.size(); ++launch) {
    begin.push_back(launch % 2 == 0 ? 0 : most[0]);
    made_.forward[launch].border = {begin.back(), begin.back() + count[launch]};
  }
  return begin;
}

void SolveLists::count_borders(Offset places) {
  made_.border_places = places;
  if (places > std::numeric_limits<Vertex>::max())
    throw BackendError("CUDA", 0, "borders of more than 2^31 - 1 rows are solved with on the host only");
}

Offset SolveLists::border_rows_of(Vertex step) const {
  return plan_.border_begin[plan_.depth_begin[step + 1]] - plan_.border_begin[plan_.depth_begin[step]];
}

// visit(row of the front, place in the plan's border)
template <class Visit>
void SolveLists::for_each_child_row(Vertex f, const Visit& visit) const {
  for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
    const Vertex child = plan_.children[c];
    for (Offset place = plan_.border_begin[child]; place < plan_.border_begin[child + 1]; ++place)
      visit(plan_.border_in_parent[place], place);
  }
}

}  // namespace mfs
