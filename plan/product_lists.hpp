// Products of one step as launches: the largest one by one as calls of the vendor's BLAS, the others in one
// launch.
#pragma once

#include <vector>

#include "plan/device_plan.hpp"

namespace mfs {

/// Rows of a wide tile of a product.
constexpr Vertex kWideRows = 128;

/// Writes DevicePlan::products.
class ProductLists {
 public:
  ProductLists(const DeviceLimits& limits, DevicePlan& made) : limits_(limits), made_(made) {}

  /// Appends the launches of products that do not depend on each other.
  void add(const std::vector<ProductTask>& products, std::vector<Launch>& launches, Order order);
  /// Narrow tiles in those that the vendor's BLAS does not get.
  Offset tiles_in(const std::vector<ProductTask>& products) const;

 private:
  bool for_vendor(const ProductTask& task) const;
  Offset tiles_with(const ProductTask& task, Vertex rows) const;
  Offset tiles_with(const std::vector<ProductTask>& products, Vertex rows) const;

  const DeviceLimits& limits_;
  DevicePlan& made_;
};

}  // namespace mfs
