// How the larger fronts of a depth are factored and updated on a device: diagonal tiles, strips and products,
// block column by block column (drawing in plan/device_plan.hpp).
#pragma once

#include <vector>

#include "plan/device_plan.hpp"
#include "plan/product_lists.hpp"
#include "plan/spans.hpp"

namespace mfs {

/// Writes DevicePlan::steps, products, exchange, roots and unpivoted; one use, depth after depth.
class StepLists {
 public:
  StepLists(const SymbolicPlan& plan, const DeviceLimits& limits, DevicePlan& made)
      : plan_(plan), limits_(limits), made_(made), products_(limits, made) {}

  /// The launches for the larger fronts of the next depth.
  void add_depth(const std::vector<Vertex>& large, DepthLaunches& depth);
  /// After the last depth, whose larger fronts are roots: those that the vendor's LAPACK can have.
  void add_roots();

 private:
  void list_steps();
  void list_exchanges();
  void list_update();
  void look_ahead(Vertex k);
  void finish_panels(Vertex k);
  template <class ColumnsOf>
  void finish_columns(const std::vector<Vertex>& fronts, Vertex begin, Vertex last, Order order,
                      const ColumnsOf& columns);
  void add_products(Vertex f, Vertex k, Vertex next, Span down, Span right,
                    std::vector<ProductTask>& products) const;
  void place_tiles(const std::vector<StepTask>& tiles, Order strips);
  void find_tall_fronts(Launch& launch);
  void place_strips(const std::vector<StepTask>& tiles, Order order);
  Vertex tile_end(Vertex f, Vertex k) const;
  bool panelled(Vertex f) const;
  Vertex panel_end(Vertex f, Vertex k) const;
  Vertex slab_end(Vertex f, Vertex k) const;

  const SymbolicPlan& plan_;
  const DeviceLimits& limits_;
  DevicePlan& made_;
  ProductLists products_;
  std::vector<Vertex> large_;       // of the depth at hand
  DepthLaunches* depth_ = nullptr;  // which it adds to
};

}  // namespace mfs
