// Where the vectors of a solve lie on a device: where contribution blocks were, as many as there is room for,
// and the others beside.
#pragma once

#include <limits>

#include "kernels/cuda/device_stages_def.hpp"

namespace mfs::cuda {

constexpr Offset kWherever = std::numeric_limits<Offset>::max();

/// For factors of S of a matrix of V; `free` bytes are left where contribution blocks were.
template <class S, class V>
class VectorLayout {
 public:
  struct Place {
    bool in_spare;
    Offset at;
  };

  VectorLayout(const SymbolicPlan& plan, const DevicePlan& lists, Offset width)
      : VectorLayout(plan, lists, width, DeviceStages<S, V>::spare_bytes(plan, lists)) {}
  VectorLayout(const SymbolicPlan& plan, const DevicePlan& lists, Offset width, Offset free) : free_(free) {
    const Offset n = plan.n;
    border = add(DeviceStages<S, V>::border_rows(lists) * width * sizeof(S));
    partial = add(DeviceStages<S, V>::partial_rows(lists) * width * sizeof(S));
    error = add((1 + kSolveColumns) * sizeof(double));
    v = add(n * width * sizeof(S));
    y = add(n * width * sizeof(S));
    x = add(n * width * sizeof(V));
  }

  ArenaLayout spare, beside;
  Place border, partial, error, v, y, x;

 private:
  Place add(Offset bytes) {
    ArenaLayout with = spare;
    with.add(bytes);
    const bool fits = with.total() <= free_;
    return {fits, (fits ? spare : beside).add(bytes)};
  }

  Offset free_;
};

}  // namespace mfs::cuda
