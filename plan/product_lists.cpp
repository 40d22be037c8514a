#include "plan/product_lists.hpp"

#include <algorithm>

#include "plan/spans.hpp"

namespace mfs {

namespace {

constexpr Vertex kDeep = 256;

}  // namespace

bool ProductLists::for_vendor(const ProductTask& task) const {
  return static_cast<Offset>(task.m) * task.n >= limits_.vendor_entries && task.k >= limits_.vendor_depth;
}

Offset ProductLists::tiles_with(const ProductTask& task, Vertex rows) const {
  return static_cast<Offset>(tiles_of(task.m, rows)) * tiles_of(task.n, limits_.product_columns);
}

Offset ProductLists::tiles_with(const std::vector<ProductTask>& products, Vertex rows) const {
  Offset tiles = 0;
  for (const ProductTask& task : products) tiles += for_vendor(task) ? 0 : tiles_with(task, rows);
  return tiles;
}

Offset ProductLists::tiles_in(const std::vector<ProductTask>& products) const {
  return tiles_with(products, limits_.product_rows);
}

// The largest products one by one to the library, the others in one launch; larger tiles use the card
// better once there are enough of them and they are deep: else what counts is how many begin and end at
// different times.
void ProductLists::add(const std::vector<ProductTask>& products, std::vector<Launch>& launches, Order order) {
  const bool deep = std::any_of(products.begin(), products.end(), [&](const ProductTask& task) {
    return task.k >= kDeep && !for_vendor(task);
  });
  const bool use_wide =
      limits_.wide_products && deep && tiles_with(products, kWideRows) >= limits_.enough_tiles;
  Launch launch{use_wide ? Launch::Kind::wide_products : Launch::Kind::products, {}, 0, order};
  launch.tasks.begin = static_cast<Offset>(made_.products.size());
  for (ProductTask task : products) {
    if (for_vendor(task)) continue;
    task.first_tile = launch.blocks;
    launch.blocks += static_cast<Vertex>(tiles_with(task, use_wide ? kWideRows : limits_.product_rows));
    made_.products.push_back(task);
  }
  launch.tasks.end = static_cast<Offset>(made_.products.size());
  if (launch.blocks > 0) launches.push_back(launch);
  for (const ProductTask& task : products) {
    if (!for_vendor(task)) continue;
    const Offset place = static_cast<Offset>(made_.products.size());
    launches.push_back({Launch::Kind::vendor_gemm, {place, place + 1}, 1, order});
    made_.products.push_back(task);
  }
}

}  // namespace mfs
