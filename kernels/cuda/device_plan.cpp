#include "kernels/cuda/device_plan.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include <mfs/error.hpp>

namespace mfs::cuda {

namespace {

Vertex tiles_of(Offset length, Vertex tile) {
  return static_cast<Vertex>((length + tile - 1) / tile);
}

// Builds one plan and is thrown away.
class Builder {
 public:
  Builder(const SymbolicPlan& plan, const PlanCuts& cuts) : plan_(plan), cuts_(cuts) {
    made_.tile = cuts.tile;
    made_.small_rows = cuts.small_rows;
  }

  DevicePlan build() {
    number_rows();
    for (Vertex k = 0; k < plan_.num_depths; ++k) {
      made_.depths.emplace_back();
      sort_fronts(k);
      list_small();
      list_assembly();
      list_steps();
      list_update();
    }
    list_roots();
    list_parts();
    list_solve();
    list_sources();
    list_wide_tiles();
    list_child_rows();
    place_entries();
    return std::move(made_);
  }

 private:
  static constexpr int kFrontsAtOnce = 64;  // of a thread

  DepthLaunches& depth() { return made_.depths.back(); }
  Vertex rows(Vertex f) const { return plan_.pivots(f) + plan_.border_rows(f); }

  void sort_fronts(Vertex step) {
    small_.clear();
    large_.clear();
    for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) {
      (rows(f) <= made_.small_rows ? small_ : large_).push_back(f);
    }
  }

  // Fronts of like size share a launch, so that shared memory fits them.
  void list_small() {
    for (Vertex most = kSmallStep; most < made_.small_rows + kSmallStep; most += kSmallStep) {
      SmallLaunch launch;
      launch.fronts.begin = static_cast<Offset>(made_.small_fronts.size());
      for (const Vertex f : small_) {
        if (rows(f) <= most && rows(f) > most - kSmallStep) {
          made_.small_fronts.push_back(f);
          launch.rows = std::max(launch.rows, rows(f));
        }
      }
      launch.fronts.end = static_cast<Offset>(made_.small_fronts.size());
      if (launch.fronts.count() > 0) depth().small.push_back(launch);
    }
  }

  void list_assembly() {
    depth().assemble.begin = parts_;
    for (const Vertex f : large_) {
      const Vertex p = plan_.pivots(f);
      assemble_block(f, {0, rows(f)}, {0, p}, true);
      assemble_block(f, {0, p}, {p, rows(f)}, true);
    }
    depth().assemble.end = parts_;
    Vertex last = 0;
    for (const Vertex f : large_) last = std::max(last, plan_.assembly_turn[f]);
    for (Vertex turn = 0; turn <= last; ++turn) {
      const Offset begin = parts_;
      for (const Vertex f : large_) {
        const Span border{plan_.pivots(f), rows(f)};
        if (plan_.assembly_turn[f] == turn) assemble_block(f, border, border, false);
      }
      depth().assemble_contribution.push_back({begin, parts_});
    }
  }

  struct Span {
    Vertex begin, end;
    Vertex length() const { return end - begin; }
  };
  // Its parts have `columns` columns each.
  struct AssemblyBlock {
    Vertex front;
    Span down, right;
    Vertex columns;
    bool has_entries;  // of the matrix
    Offset first_part;
  };

  void assemble_block(Vertex f, Span down, Span right, bool has_entries) {
    if (down.length() == 0) return;
    const Vertex columns = std::max(kAssembleColumns, kAssembleEntries / down.length());
    blocks_.push_back({f, down, right, columns, has_entries, parts_});
    parts_ += tiles_of(right.length(), columns);
  }

  void list_parts() {
    made_.assemble.resize(static_cast<std::size_t>(parts_));
    const auto blocks = static_cast<Offset>(blocks_.size());
#pragma omp parallel for schedule(dynamic)
    for (Offset i = 0; i < blocks; ++i) {
      const AssemblyBlock& block = blocks_[i];
      const Vertex f = block.front;
      Offset part = block.first_part;
      Offset entry = block.has_entries ? first_entry_from(f, plan_.entry_begin[f], block.right.begin)
                                       : plan_.entry_begin[f + 1];
      for (Vertex begin = block.right.begin; begin < block.right.end; begin += block.columns) {
        const Vertex end = std::min(begin + block.columns, block.right.end);
        const Offset first = entry;
        entry = first_entry_from(f, entry, end);
        made_.assemble[part++] = {f, begin, end, block.down.begin, block.down.end, first, entry};
      }
    }
  }

  // The first entry of f from `entry` on in column `end` or right of it.
  Offset first_entry_from(Vertex f, Offset entry, Vertex end) const {
    Offset past = plan_.entry_begin[f + 1];
    while (entry < past) {
      const Offset middle = entry + (past - entry) / 2;
      if (column_of_entry(f, middle) < end) {
        entry = middle + 1;
      } else {
        past = middle;
      }
    }
    return entry;
  }

  // Of the front; the entries of a front ascend by it.
  Vertex column_of_entry(Vertex f, Offset entry) const {
    const Offset p = plan_.pivots(f), lower = plan_.entry_target[entry] - plan_.lower_begin[f];
    if (lower < p * plan_.lower_ld(f)) return static_cast<Vertex>(lower / plan_.lower_ld(f));
    return static_cast<Vertex>(p + (plan_.entry_target[entry] - plan_.upper_begin[f]) / p);
  }

  void list_steps() {
    Vertex most = 0;
    for (const Vertex f : large_) most = std::max(most, plan_.pivots(f));
    const bool by_panels = std::any_of(large_.begin(), large_.end(), [&](Vertex f) { return panelled(f); });
    for (Vertex k = 0; k < most; k += made_.tile) {
      std::vector<StepTask> tiles;
      std::vector<ProductTask> products;
      for (const Vertex f : large_) {
        if (plan_.pivots(f) <= k) continue;
        const Vertex next = tile_end(f, k), right = panel_end(f, k) - next;
        tiles.push_back({f, k, 1, 0, right, 0});
        add_products(f, k, next, {next, rows(f)}, {next, next + right}, products);
      }
      place_tiles(tiles, by_panels ? Order::next : Order::joined);
      if (!by_panels && tiles_in(products, kNarrow) > cuts_.ahead_tiles) {
        look_ahead(k);
      } else {
        place_products(products, depth().factor, Order::next);
      }
      finish_panels(k);
    }
    list_exchanges();
  }

  // The products of step k: what the next diagonal tiles need, then the others, beside those.
  void look_ahead(Vertex k) {
    std::vector<ProductTask> first, others;
    for (const Vertex f : large_) {
      const Vertex next = tile_end(f, k), end = tile_end(f, next), p = plan_.pivots(f);
      if (next >= p) continue;
      // The last tile looks at the border rows of its columns, too.
      const Vertex down = end < p ? end : rows(f);
      add_products(f, k, next, {next, down}, {next, end}, first);
      add_products(f, k, next, {down, rows(f)}, {next, end}, others);
      add_products(f, k, next, {next, rows(f)}, {end, rows(f)}, others);
    }
    place_products(first, depth().factor, Order::next);
    place_products(others, depth().factor, Order::aside);
  }

  Vertex tile_end(Vertex f, Vertex k) const {
    return std::min<Vertex>(k + made_.tile, plan_.pivots(f));
  }
  bool panelled(Vertex f) const {
    return plan_.pivots(f) >= cuts_.panelled && rows(f) >= cuts_.panelled_rows;
  }
  // Columns before this one are made together with the tile at k.
  Vertex panel_end(Vertex f, Vertex k) const {
    return panelled(f) ? std::min(k / cuts_.panel * cuts_.panel + cuts_.panel, plan_.pivots(f)) : rows(f);
  }

  // Columns before this one are made before what is right of them.
  Vertex slab_end(Vertex f, Vertex k) const {
    return std::min(k / cuts_.slab * cuts_.slab + cuts_.slab, plan_.pivots(f));
  }

  // What is right of the panels that end with the tile at k: the rest of their slabs, or where those end,
  // too, what the next slabs need, then all others.
  void finish_panels(Vertex k) {
    std::vector<Vertex> inside, ended;
    for (const Vertex f : large_) {
      if (!panelled(f) || plan_.pivots(f) <= k || tile_end(f, k) != panel_end(f, k)) continue;
      (panel_end(f, k) < slab_end(f, k) ? inside : ended).push_back(f);
    }
    const Vertex panel = k / cuts_.panel * cuts_.panel, slab = k / cuts_.slab * cuts_.slab;
    const auto next_end = [&](Vertex f) { return std::min(slab_end(f, k) + cuts_.slab, plan_.pivots(f)); };
    finish_columns(inside, panel, k, Order::next, [&](Vertex f) {
      return Span{panel_end(f, k), slab_end(f, k)};
    });
    finish_columns(ended, slab, k, Order::joined, [&](Vertex f) {
      return Span{slab_end(f, k), next_end(f)};
    });
    finish_columns(ended, slab, k, Order::aside, [&](Vertex f) { return Span{next_end(f), rows(f)}; });
  }

  // Columns columns(f) right of block columns [begin, end), of which the tile at `last` is the last: their
  // block rows, panel by panel, then all below them.
  template <class ColumnsOf>
  void finish_columns(const std::vector<Vertex>& fronts, Vertex begin, Vertex last, Order order,
                      const ColumnsOf& columns) {
    if (fronts.empty()) return;
    std::vector<ProductTask> below;
    for (Vertex tile = begin; tile <= last; tile += made_.tile) {
      std::vector<StepTask> tiles;
      std::vector<ProductTask> products, below_panel;
      for (const Vertex f : fronts) {
        const Vertex next = tile_end(f, tile), end = tile_end(f, last), panel = panel_end(f, tile);
        const Span right = columns(f);
        if (right.length() == 0) continue;
        tiles.push_back({f, tile, 0, right.begin - next, right.end - next, 0});
        add_products(f, tile, next, {next, panel}, right, products);
        if (next == panel)
          add_products(f, tile / cuts_.panel * cuts_.panel, panel, {panel, end}, right, below_panel);
        if (tile == last) add_products(f, begin, end, {end, rows(f)}, right, below);
      }
      if (!tiles.empty()) place_strips(tiles, order);
      place_products(products, depth().factor, order);
      place_products(below_panel, depth().factor, order);
    }
    place_products(below, depth().factor, order);
  }

  // Pivots [k, next) from `rows` and `columns` of P, L and U; what would be C is left out. Products that
  // reach the last row take those along that only align the next column: the library is faster so.
  void add_products(Vertex f, Vertex k, Vertex next, Span down, Span right,
                    std::vector<ProductTask>& products) const {
    const Vertex leading = plan_.lower_ld(f);
    const Offset ld = leading, lower = plan_.lower_begin[f], upper = plan_.upper_begin[f];
    const Vertex p = plan_.pivots(f), s = next - k;
    const Span own{right.begin, std::min(right.end, p)};
    if (own.length() > 0 && down.length() > 0) {
      const Vertex end = down.end == rows(f) ? leading : down.end;
      products.push_back({lower + down.begin + k * ld, lower + k + own.begin * ld,
                          lower + down.begin + own.begin * ld, end - down.begin, own.length(), s, leading,
                          leading, leading, 0});
    }
    const Span border{std::max(right.begin, p), right.end}, pivots{down.begin, std::min(down.end, p)};
    if (border.length() > 0 && pivots.length() > 0) {
      const Offset first = static_cast<Offset>(border.begin - p) * p;
      products.push_back({lower + pivots.begin + k * ld, upper + k + first, upper + pivots.begin + first,
                          pivots.length(), border.length(), s, leading, p, p, 0});
    }
  }

  // The strips wait for all products before them, the tiles do not.
  void place_tiles(const std::vector<StepTask>& tiles, Order strips) {
    place_strips(tiles, strips);
    Launch launch = depth().factor.back();
    launch.kind = Launch::Kind::diagonal;
    launch.order = Order::next;
    launch.blocks = static_cast<Vertex>(tiles.size());
    depth().factor.insert(depth().factor.end() - 1, launch);
  }

  void place_strips(const std::vector<StepTask>& tiles, Order order) {
    Launch launch{Launch::Kind::strips, {static_cast<Offset>(made_.steps.size()), 0}, 0, order};
    for (StepTask task : tiles) {
      task.first_strip = launch.blocks;
      const Vertex below = task.left ? rows(task.front) - tile_end(task.front, task.k) : 0;
      launch.blocks += tiles_of(below, kStrip) + tiles_of(task.end - task.begin, kStrip);
      launch.width = std::max(launch.width, tile_end(task.front, task.k) - task.k);
      made_.steps.push_back(task);
    }
    launch.tasks.end = static_cast<Offset>(made_.steps.size());
    depth().factor.push_back(launch);
  }

  // After all depths: large_ is that of the last, whose fronts are roots.
  void list_roots() {
    const auto for_tiles = [&](Vertex f) {
      return plan_.pivots(f) < cuts_.least_root || plan_.pivots(f) > cuts_.most_root;
    };
    if (large_.empty() || std::any_of(large_.begin(), large_.end(), for_tiles)) return;
    for (const Vertex f : large_) {
      made_.roots.push_back({plan_.lower_begin[f], plan_.pivots(f), plan_.lower_ld(f)});
      for (Vertex k = 0; k < plan_.pivots(f); k += made_.tile) made_.unpivoted.push_back({f, k, k});
    }
    const Offset tiles = static_cast<Offset>(made_.unpivoted.size());
    made_.on_diagonal = {0, tiles};
    const Range& blocks = made_.depths.back().exchange;
    made_.unpivoted.insert(made_.unpivoted.end(), made_.exchange.begin() + blocks.begin,
                           made_.exchange.begin() + blocks.end);
    made_.below_diagonal = {tiles, static_cast<Offset>(made_.unpivoted.size())};
  }

  void list_exchanges() {
    depth().exchange.begin = static_cast<Offset>(made_.exchange.size());
    for (const Vertex f : large_) {
      const Vertex blocks = tiles_of(plan_.pivots(f), made_.tile);
      for (Vertex i = 1; i < blocks; ++i) {
        for (Vertex j = 0; j < i; ++j) made_.exchange.push_back({f, i * made_.tile, j * made_.tile});
      }
    }
    depth().exchange.end = static_cast<Offset>(made_.exchange.size());
  }

  void list_update() {
    std::vector<ProductTask> products;
    for (const Vertex f : large_) {
      const Vertex p = plan_.pivots(f), b = plan_.border_rows(f);
      if (b == 0 || p == 0) continue;
      const Vertex leading = plan_.lower_ld(f), ldc = plan_.contribution_ld(f);
      products.push_back({plan_.lower_begin[f] + p, plan_.upper_begin[f], plan_.contribution_begin[f],
                          std::min(leading - p, ldc), b, p, leading, p, ldc, 0});
    }
    place_products(products, depth().update, Order::next);
  }

  static constexpr Vertex kNarrow = 64, kWide = 128;  // rows of a tile of a product
  static Offset tiles_in(const ProductTask& task, Vertex rows) {
    return static_cast<Offset>(tiles_of(task.m, rows)) * tiles_of(task.n, kNarrow);
  }
  static Offset tiles_in(const std::vector<ProductTask>& products, Vertex rows) {
    Offset tiles = 0;
    for (const ProductTask& task : products) tiles += for_library(task) ? 0 : tiles_in(task, rows);
    return tiles;
  }
  static constexpr Vertex kDeep = 256;
  static bool for_library(const ProductTask& task) {
    constexpr Offset kLibraryEntries = Offset(1) << 20;
    return static_cast<Offset>(task.m) * task.n >= kLibraryEntries && task.k >= kDeep;
  }

  // The largest products one by one to the library, the others in one launch; larger tiles use the card
  // better once there are enough of them and they are deep: else what counts is how many begin and end at
  // different times.
  void place_products(const std::vector<ProductTask>& products, std::vector<Launch>& launches, Order order) {
    constexpr Offset kEnough = 2 * kMultiprocessors;
    const bool deep = std::any_of(products.begin(), products.end(), [](const ProductTask& task) {
      return task.k >= kDeep && !for_library(task);
    });
    const bool use_wide = cuts_.wide_products && deep && tiles_in(products, kWide) >= kEnough;
    Launch launch{use_wide ? Launch::Kind::wide_products : Launch::Kind::products, {}, 0, order};
    launch.tasks.begin = static_cast<Offset>(made_.products.size());
    for (ProductTask task : products) {
      if (for_library(task)) continue;
      task.first_tile = launch.blocks;
      launch.blocks += static_cast<Vertex>(tiles_in(task, use_wide ? kWide : kNarrow));
      made_.products.push_back(task);
    }
    launch.tasks.end = static_cast<Offset>(made_.products.size());
    if (launch.blocks > 0) launches.push_back(launch);
    for (const ProductTask& task : products) {
      if (!for_library(task)) continue;
      const Offset place = static_cast<Offset>(made_.products.size());
      launches.push_back({Launch::Kind::library, {place, place + 1}, 1, order});
      made_.products.push_back(task);
    }
  }

  // What the solve does with the fronts of a depth.
  struct SolveDepth {
    std::vector<Vertex> fronts;  // in tiles
    Range tiny;
  };

  // Each depth waits for the one before it: forward for the deeper one, backward for the higher one.
  void list_solve() {
    std::vector<SolveDepth> depths;
    for (Vertex k = 0; k < plan_.num_depths; ++k) depths.push_back(solve_depth(k));
    for (const SolveDepth& depth : depths) {
      list_tiles(depth, made_.forward, [&] { list_forward(depth.fronts); });
      forward_launch_.push_back(made_.forward.size() - 1);
    }
    for (auto depth = depths.rbegin(); depth != depths.rend(); ++depth)
      list_tiles(*depth, made_.backward, [&] { list_backward(depth->fronts); });
  }

  SolveDepth solve_depth(Vertex step) {
    SolveDepth depth;
    std::vector<Vertex> tiny;
    for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) {
      const Offset entries = static_cast<Offset>(plan_.pivots(f)) * rows(f);
      (plan_.pivots(f) <= kTinyPivots && entries <= kTinyEntries ? tiny : depth.fronts).push_back(f);
    }
    if (static_cast<Vertex>(tiny.size()) < cuts_.many_tiny) {
      depth.fronts.insert(depth.fronts.end(), tiny.begin(), tiny.end());
      tiny.clear();
    }
    depth.tiny.begin = static_cast<Offset>(made_.tiny_fronts.size());
    made_.tiny_fronts.insert(made_.tiny_fronts.end(), tiny.begin(), tiny.end());
    depth.tiny.end = static_cast<Offset>(made_.tiny_fronts.size());
    return depth;
  }

  template <class List>
  void list_tiles(const SolveDepth& depth, std::vector<SolveLaunch>& launches, const List& list) {
    const Offset begin = static_cast<Offset>(made_.solve.size());
    list();
    if (launches.empty() || launches.back().tiny.count() > 0 || depth.tiny.count() > 0)
      launches.push_back({depth.tiny, {begin, begin}, {}});
    launches.back().tiles.end = static_cast<Offset>(made_.solve.size());
  }

  Vertex most_solve_tiles(const std::vector<Vertex>& fronts) const {
    Vertex most = 0;
    for (const Vertex f : fronts) most = std::max(most, solve_tiles(f));
    return most;
  }

  // The tiles of a front in the order in which they depend on each other, those of all fronts by turns.
  void list_forward(const std::vector<Vertex>& fronts) {
    const Vertex most = most_solve_tiles(fronts);
    for (Vertex i = 0; i < most; ++i) {
      for (const Vertex f : fronts) {
        if (i < solve_tiles(f)) add_part({f, i * kSolveTile, 0, i, true, 0, 0, {}, kSolveTile});
      }
    }
    Vertex tiles = 0;
    for (const Vertex f : fronts) tiles += steps_of_border(f);
    for (const Vertex f : fronts) {
      const Vertex height = tiles > cuts_.crowd && solve_tiles(f) == 1 ? kTallTile : kSolveTile;
      for (Vertex i = 0; i < plan_.border_rows(f); i += height)
        add_part({f, plan_.pivots(f) + i, 0, solve_tiles(f), true, 0, 0, {}, height});
    }
  }

  // The other way round, and only pivots. By turns too, but tiles come some turns before their parts: what
  // they wait for in the pivot block takes them long, and no block that has begun stands in the way of a
  // part.
  void list_backward(const std::vector<Vertex>& fronts) {
    const Vertex most = most_solve_tiles(fronts);
    std::vector<Offset> places;
    for (const Vertex f : fronts) {
      places.push_back(made_.solve_places);
      made_.solve_places += static_cast<Offset>(solve_tiles(f)) * parts_of_border(f);
    }
    const Vertex lead = fronts.empty() ? 0 : cuts_.waiting_tiles / static_cast<Vertex>(fronts.size());
    for (Vertex turn = -lead; turn < most; ++turn) {
      for (std::size_t i = 0; i < fronts.size(); ++i) list_parts_back(fronts[i], turn, places[i]);
      for (std::size_t i = 0; i < fronts.size(); ++i) list_tile_back(fronts[i], turn + lead, places[i]);
    }
  }

  Vertex solve_tiles(Vertex f) const {
    return tiles_of(plan_.pivots(f), kSolveTile);
  }
  Vertex steps_of_border(Vertex f) const {
    return tiles_of(plan_.border_rows(f), kSolveTile);
  }
  Vertex parts_of_border(Vertex f) const {
    return steps_of_border(f) / cuts_.solve_steps;
  }
  // Row where the tile of this turn begins: the last tile has the first turn.
  Vertex tile_of_turn(Vertex f, Vertex turn) const {
    return (solve_tiles(f) - 1 - turn) * kSolveTile;
  }

  void list_parts_back(Vertex f, Vertex turn, Offset first_place) {
    if (turn < 0 || turn >= solve_tiles(f)) return;
    const Vertex parts = parts_of_border(f), steps = cuts_.solve_steps;
    for (Vertex i = 0; i < parts; ++i) {
      const Offset place = first_place + static_cast<Offset>(turn) * parts + i;
      add_part({f, tile_of_turn(f, turn), i * steps, (i + 1) * steps, false, place, 0, {}, kSolveTile});
    }
  }
  // The steps of the border that are left, and those of the pivot block, which wait for other tiles.
  void list_tile_back(Vertex f, Vertex turn, Offset first_place) {
    if (turn >= solve_tiles(f)) return;
    const Vertex parts = parts_of_border(f), last = steps_of_border(f) + turn;
    const Offset place = first_place + static_cast<Offset>(turn) * parts;
    add_part({f, tile_of_turn(f, turn), parts * cuts_.solve_steps, last, true, place, parts, {}, kSolveTile});
  }

  void add_part(SolvePart part) {
    const Vertex f = part.front;
    part.where = {plan_.lower_begin[f], plan_.upper_begin[f], plan_.border_begin[f], made_.row_begin[f],
                  plan_.pivot_begin[f], plan_.pivots(f),      plan_.border_rows(f),  plan_.lower_ld(f)};
    part.rows = std::min(part.rows, (part.begin < plan_.pivots(f) ? plan_.pivots(f) : rows(f)) - part.begin);
    made_.solve.push_back(part);
  }

  void list_wide_tiles() {
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      for (Vertex k = 0; k + kInverted < plan_.pivots(f); k += kSolveTile)
        made_.wide_tiles.push_back({f, k, k});
    }
  }

  void number_rows() {
    Offset row = 0;
    for (Vertex step = 0; step < plan_.num_depths; ++step) {
      for (Vertex f = plan_.depth_begin[step]; f < plan_.depth_begin[step + 1]; ++f) {
        made_.row_begin.push_back(row);
        row += rows(f);
      }
      ++row;  // where the last row of the step ends
    }
    made_.source_begin.resize(static_cast<std::size_t>(row));
  }

  // Row i of a front counts at its source_begin[i + 1]; then source_begin[i] is the place of its next source,
  // until all have theirs.
  void list_sources() {
    made_.destination.resize(plan_.border.size());
    made_.source_begin.front() = 0;
#pragma omp parallel for schedule(dynamic, kFrontsAtOnce)
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      Vertex* const counts = &made_.source_begin[made_.row_begin[f] + 1];
      std::fill_n(counts, rows(f), 0);
      for_each_child_row(f, [&](Vertex row, Offset) { ++counts[row]; });
    }
    place_sources();
#pragma omp parallel for schedule(dynamic, kFrontsAtOnce)
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      Vertex* const next = &made_.source_begin[made_.row_begin[f]];
      const Vertex first = *next;
      for_each_child_row(f, [&](Vertex row, Offset place) { made_.destination[place] = next[row]++; });
      std::copy_backward(next, next + rows(f) - 1, next + rows(f));
      *next = first;
    }
  }

  // From counts to places.
  void place_sources() {
    std::vector<Offset> next = place_borders();
    RawVector<Vertex>& places = made_.source_begin;
    for (Vertex step = 1; step < plan_.num_depths; ++step) {
      const bool last = step + 1 == plan_.num_depths;
      const auto begin = places.begin() + made_.row_begin[plan_.depth_begin[step]];
      const auto end = last ? places.end() : places.begin() + made_.row_begin[plan_.depth_begin[step + 1]];
      Offset& of_children = next[forward_launch_[step - 1]];
      *begin = static_cast<Vertex>(of_children);
      std::partial_sum(begin, end, begin);
      of_children += border_rows_of(step - 1);
    }
  }

  // Where what each launch leaves begins. It is read by the same launch and the next one, so two share a
  // place by turns.
  std::vector<Offset> place_borders() {
    std::vector<Offset> count(made_.forward.size(), 0), begin;
    for (Vertex step = 0; step < plan_.num_depths; ++step)
      count[forward_launch_[step]] += border_rows_of(step);
    Offset most[2] = {0, 0};
    for (std::size_t launch = 0; launch < count.size(); ++launch)
      most[launch % 2] = std::max(most[launch % 2], count[launch]);
    made_.border_places = most[0] + most[1];
    if (made_.border_places > std::numeric_limits<Vertex>::max())
      throw BackendError("CUDA", 0, "borders of more than 2^31 - 1 rows are solved with on the host only");
    for (std::size_t launch = 0; launch < count.size(); ++launch) {
      begin.push_back(launch % 2 == 0 ? 0 : most[0]);
      made_.forward[launch].border = {begin.back(), begin.back() + count[launch]};
    }
    return begin;
  }

  Offset border_rows_of(Vertex step) const {
    return plan_.border_begin[plan_.depth_begin[step + 1]] - plan_.border_begin[plan_.depth_begin[step]];
  }

  // Only of larger fronts: small ones add their children up in shared memory.
  void list_child_rows() {
    made_.child_row_begin.assign(plan_.children.size() + 1, 0);
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c)
        made_.child_row_begin[c + 1] = made_.child_row_begin[c] + (rows(f) > made_.small_rows ? rows(f) : 0);
    }
    made_.child_row.resize(static_cast<std::size_t>(made_.child_row_begin.back()));
#pragma omp parallel for schedule(dynamic, kFrontsAtOnce)
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      if (rows(f) <= made_.small_rows) continue;
      for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
        const Vertex child = plan_.children[c];
        const Vertex* map = plan_.border_in_parent.data() + plan_.border_begin[child];
        Vertex* const child_row = made_.child_row.data() + made_.child_row_begin[c];
        std::fill_n(child_row, rows(f), -1);
        for (Vertex i = 0; i < plan_.border_rows(child); ++i) child_row[map[i]] = i;
      }
    }
  }

  void place_entries() {
    made_.entry_place.resize(static_cast<std::size_t>(plan_.nnz));
    const auto place_from = [&](Offset begin, Offset first, Offset last) {
      for (Offset e = first; e < last; ++e)
        made_.entry_place[e] = static_cast<Vertex>(plan_.entry_target[e] - begin);
    };
    const auto parts = static_cast<Offset>(made_.assemble.size());
#pragma omp parallel for schedule(static)
    for (Offset i = 0; i < parts; ++i) {
      const AssemblyPart& part = made_.assemble[i];
      place_from(column_begin(part.front, part.begin), part.first_entry, part.last_entry);
    }
    const auto small = static_cast<Offset>(made_.small_fronts.size());
#pragma omp parallel for schedule(static)
    for (Offset i = 0; i < small; ++i) {
      const Vertex f = made_.small_fronts[i];
      const Offset lower = static_cast<Offset>(plan_.pivots(f)) * rows(f);
      const Offset *const targets = plan_.entry_target.data(), *const end =
                                                                   targets + plan_.entry_begin[f + 1];
      const Offset beyond =
          std::lower_bound(targets + plan_.entry_begin[f], end, plan_.upper_begin[f]) - targets;
      place_from(plan_.lower_begin[f], plan_.entry_begin[f], beyond);
      place_from(plan_.upper_begin[f] - lower, beyond, plan_.entry_begin[f + 1]);
    }
  }

  // Of [P; L] or U.
  Offset column_begin(Vertex f, Vertex column) const {
    const Offset p = plan_.pivots(f);
    return column < p ? plan_.lower_begin[f] + column * static_cast<Offset>(plan_.lower_ld(f))
                      : plan_.upper_begin[f] + (column - p) * p;
  }

  // visit(row of the front, place in the plan's border)
  template <class Visit>
  void for_each_child_row(Vertex f, const Visit& visit) const {
    for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
      const Vertex child = plan_.children[c];
      for (Offset place = plan_.border_begin[child]; place < plan_.border_begin[child + 1]; ++place)
        visit(plan_.border_in_parent[place], place);
    }
  }

  const SymbolicPlan& plan_;
  const PlanCuts& cuts_;
  std::vector<Vertex> small_, large_;
  std::vector<AssemblyBlock> blocks_;
  Offset parts_ = 0;                         // of them all
  std::vector<std::size_t> forward_launch_;  // of each depth
  DevicePlan made_;
};

}  // namespace

DevicePlan make_device_plan(const SymbolicPlan& plan, const PlanCuts& cuts) {
  return Builder(plan, cuts).build();
}

}  // namespace mfs::cuda
