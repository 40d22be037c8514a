#include "plan/step_lists.hpp"

#include <algorithm>

namespace mfs {

void StepLists::add_depth(const std::vector<Vertex>& large, DepthLaunches& depth) {
  large_ = large;
  depth_ = &depth;
  list_steps();
  list_exchanges();
  list_update();
}

void StepLists::list_steps() {
  Vertex most = 0;
  for (const Vertex f : large_) most = std::max(most, plan_.pivots(f));
  const bool by_panels = std::any_of(large_.begin(), large_.end(), [&](Vertex f) { return panelled(f); });
  for (Vertex k = 0; k < most; k += limits_.tile) {
    std::vector<StepTask> tiles;
    std::vector<ProductTask> products;
    for (const Vertex f : large_) {
      if (plan_.pivots(f) <= k) continue;
      const Vertex next = tile_end(f, k), right = panel_end(f, k) - next;
      tiles.push_back({f, k, 1, 0, right, 0, plan_.upper_begin[f]});
      add_products(f, k, next, {next, plan_.rows(f)}, {next, next + right}, products);
    }
    place_tiles(tiles, by_panels ? Order::sequential : Order::join);
    if (!by_panels && products_.tiles_in(products) > limits_.ahead_tiles) {
      look_ahead(k);
    } else {
      products_.add(products, depth_->factor, Order::sequential);
    }
    finish_panels(k);
  }
}

// The products of step k: what the next diagonal tiles need, then the others, beside those.
void StepLists::look_ahead(Vertex k) {
  std::vector<ProductTask> first, others;
  for (const Vertex f : large_) {
    const Vertex next = tile_end(f, k), end = tile_end(f, next), p = plan_.pivots(f);
    if (next >= p) continue;
    // The last tile looks at the border rows of its columns, too.
    const Vertex down = end < p && !limits_.whole_columns ? end : plan_.rows(f);
    add_products(f, k, next, {next, down}, {next, end}, first);
    add_products(f, k, next, {down, plan_.rows(f)}, {next, end}, others);
    add_products(f, k, next, {next, plan_.rows(f)}, {end, plan_.rows(f)}, others);
  }
  products_.add(first, depth_->factor, Order::sequential);
  products_.add(others, depth_->factor, Order::concurrent);
}

Vertex StepLists::tile_end(Vertex f, Vertex k) const {
  return std::min<Vertex>(k + limits_.tile, plan_.pivots(f));
}
bool StepLists::panelled(Vertex f) const {
  return plan_.pivots(f) >= limits_.panelled && plan_.rows(f) >= limits_.panelled_rows;
}
// Columns before this one are made together with the tile at k.
Vertex StepLists::panel_end(Vertex f, Vertex k) const {
  return panelled(f) ? std::min(k / limits_.panel * limits_.panel + limits_.panel, plan_.pivots(f))
                     : plan_.rows(f);
}

// Columns before this one are made before what is right of them.
Vertex StepLists::slab_end(Vertex f, Vertex k) const {
  return std::min(k / limits_.slab * limits_.slab + limits_.slab, plan_.pivots(f));
}

// What is right of the panels that end with the tile at k: the rest of their slabs, or where those end,
// too, what the next slabs need, then all others.
void StepLists::finish_panels(Vertex k) {
  std::vector<Vertex> inside, ended;
  for (const Vertex f : large_) {
    if (!panelled(f) || plan_.pivots(f) <= k || tile_end(f, k) != panel_end(f, k)) continue;
    (panel_end(f, k) < slab_end(f, k) ? inside : ended).push_back(f);
  }
  const Vertex panel = k / limits_.panel * limits_.panel, slab = k / limits_.slab * limits_.slab;
  const auto next_end = [&](Vertex f) { return std::min(slab_end(f, k) + limits_.slab, plan_.pivots(f)); };
  finish_columns(inside, panel, k, Order::sequential, [&](Vertex f) {
    return Span{panel_end(f, k), slab_end(f, k)};
  });
  finish_columns(ended, slab, k, Order::join, [&](Vertex f) { return Span{slab_end(f, k), next_end(f)}; });
  finish_columns(ended, slab, k, Order::concurrent, [&](Vertex f) {
    return Span{next_end(f), plan_.rows(f)};
  });
}

// Columns columns(f) right of block columns [begin, end), of which the tile at `last` is the last: their
// block rows, panel by panel, then all below them.
template <class ColumnsOf>
void StepLists::finish_columns(const std::vector<Vertex>& fronts, Vertex begin, Vertex last, Order order,
                               const ColumnsOf& columns) {
  if (fronts.empty()) return;
  std::vector<ProductTask> below;
  for (Vertex tile = begin; tile <= last; tile += limits_.tile) {
    std::vector<StepTask> tiles;
    std::vector<ProductTask> products, below_panel;
    for (const Vertex f : fronts) {
      const Vertex next = tile_end(f, tile), end = tile_end(f, last), panel = panel_end(f, tile);
      const Span right = columns(f);
      if (right.length() == 0) continue;
      tiles.push_back({f, tile, 0, right.begin - next, right.end - next, 0, plan_.upper_begin[f]});
      add_products(f, tile, next, {next, panel}, right, products);
      if (next == panel)
        add_products(f, tile / limits_.panel * limits_.panel, panel, {panel, end}, right, below_panel);
      if (tile == last) add_products(f, begin, end, {end, plan_.rows(f)}, right, below);
    }
    if (!tiles.empty()) place_strips(tiles, order);
    products_.add(products, depth_->factor, order);
    products_.add(below_panel, depth_->factor, order);
  }
  products_.add(below, depth_->factor, order);
}

// Pivots [k, next) from `rows` and `columns` of P, L and U; what would be C is left out. Products that
// reach the last row take those along that only align the next column: the vendor's BLAS is faster so.
void StepLists::add_products(Vertex f, Vertex k, Vertex next, Span down, Span right,
                             std::vector<ProductTask>& products) const {
  const Vertex leading = plan_.lower_ld(f);
  const Offset ld = leading, lower = plan_.lower_begin[f], upper = plan_.upper_begin[f];
  const Vertex p = plan_.pivots(f), s = next - k;
  const Span own{right.begin, std::min(right.end, p)};
  if (own.length() > 0 && down.length() > 0) {
    const Vertex end = down.end == plan_.rows(f) ? leading : down.end;
    products.push_back({lower + down.begin + k * ld, lower + k + own.begin * ld,
                        lower + down.begin + own.begin * ld, end - down.begin, own.length(), s, leading,
                        leading, leading, 0, end - down.end, f});
  }
  const Span border{std::max(right.begin, p), right.end}, pivots{down.begin, std::min(down.end, p)};
  if (border.length() > 0 && pivots.length() > 0) {
    const Offset first = static_cast<Offset>(border.begin - p) * p;
    products.push_back({lower + pivots.begin + k * ld, upper + k + first, upper + pivots.begin + first,
                        pivots.length(), border.length(), s, leading, p, p, 0, 0, f});
  }
}

// The strips wait for all products before them, the tiles do not.
void StepLists::place_tiles(const std::vector<StepTask>& tiles, Order strips) {
  place_strips(tiles, strips);
  Launch launch = depth_->factor.back();
  launch.kind = Launch::Kind::diagonal;
  launch.order = Order::sequential;
  launch.blocks = static_cast<Vertex>(tiles.size());
  find_tall_fronts(launch);
  depth_->factor.insert(depth_->factor.end() - 1, launch);
}

void StepLists::find_tall_fronts(Launch& launch) {
  Offset border = 0;
  for (Offset i = launch.tasks.begin; i < launch.tasks.end; ++i) {
    StepTask& task = made_.steps[i];
    const Vertex pivots = plan_.pivots(task.front);
    if (pivots <= limits_.tall) continue;
    task.border_at = border * kMostPanelColumns;
    border += plan_.border_rows(task.front);
    launch.tall_pivots = std::max(launch.tall_pivots, pivots - task.k);
    launch.tall_rows = std::max(launch.tall_rows, plan_.rows(task.front));
    launch.tall_border = std::max(launch.tall_border, plan_.border_rows(task.front));
  }
  if (launch.tall_pivots == 0) return;
  made_.tall_tasks = std::max(made_.tall_tasks, launch.blocks);
  made_.tall_border = std::max(made_.tall_border, border * kMostPanelColumns);
}

void StepLists::place_strips(const std::vector<StepTask>& tiles, Order order) {
  Launch launch{Launch::Kind::strips, {static_cast<Offset>(made_.steps.size()), 0}, 0, order};
  for (StepTask task : tiles) {
    task.first_strip = launch.blocks;
    const Vertex below = task.left ? plan_.rows(task.front) - tile_end(task.front, task.k) : 0;
    launch.blocks += tiles_of(below, limits_.strip) + tiles_of(task.end - task.begin, limits_.strip);
    launch.width = std::max(launch.width, tile_end(task.front, task.k) - task.k);
    made_.steps.push_back(task);
  }
  launch.tasks.end = static_cast<Offset>(made_.steps.size());
  depth_->factor.push_back(launch);
}

void StepLists::list_exchanges() {
  depth_->exchange.begin = static_cast<Offset>(made_.exchange.size());
  for (const Vertex f : large_) {
    const Vertex blocks = tiles_of(plan_.pivots(f), limits_.tile);
    for (Vertex i = 1; i < blocks; ++i) {
      for (Vertex j = 0; j < i; ++j) made_.exchange.push_back({f, i * limits_.tile, j * limits_.tile});
    }
  }
  depth_->exchange.end = static_cast<Offset>(made_.exchange.size());
}

void StepLists::list_update() {
  std::vector<ProductTask> products;
  for (const Vertex f : large_) {
    const Vertex p = plan_.pivots(f), b = plan_.border_rows(f);
    if (b == 0 || p == 0) continue;
    const Vertex leading = plan_.lower_ld(f), ldc = plan_.contribution_ld(f);
    const Vertex down = std::min(leading - p, ldc);
    products.push_back({plan_.lower_begin[f] + p, plan_.upper_begin[f], plan_.contribution_begin[f], down, b,
                        p, leading, p, ldc, 0, down - b, f});
  }
  products_.add(products, depth_->update, Order::sequential);
}

void StepLists::add_roots() {
  const auto for_tiles = [&](Vertex f) {
    return plan_.pivots(f) < limits_.least_root || plan_.pivots(f) > limits_.most_root;
  };
  if (large_.empty() || std::any_of(large_.begin(), large_.end(), for_tiles)) return;
  for (const Vertex f : large_) {
    made_.roots.push_back({plan_.lower_begin[f], plan_.pivots(f), plan_.lower_ld(f)});
    for (Vertex k = 0; k < plan_.pivots(f); k += limits_.tile) made_.unpivoted.push_back({f, k, k});
  }
  const Offset tiles = static_cast<Offset>(made_.unpivoted.size());
  made_.on_diagonal = {0, tiles};
  const Range& blocks = made_.depths.back().exchange;
  made_.unpivoted.insert(made_.unpivoted.end(), made_.exchange.begin() + blocks.begin,
                         made_.exchange.begin() + blocks.end);
  made_.below_diagonal = {tiles, static_cast<Offset>(made_.unpivoted.size())};
}

}  // namespace mfs
