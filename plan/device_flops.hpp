// The operations of the launches of a device plan, as they are made there: by its tiles, not by the blocks of
// the host.
#pragma once

#include "plan/device_plan.hpp"

namespace mfs {

struct DeviceFlops {
  BlockFlops done{0, 0, 0};
  double padding = 0;             // more that products spend on rows which only align the next column
  std::vector<BlockFlops> steps;  // those done, by step of the plan
};

/// Of one factorization: the LU of diagonal tiles, the strips beside them, and products; of a small front
/// those of its pivot block, of what is beside it and of its contribution block. In all they are as many as
/// in any other division into blocks. What inverses of diagonal blocks and searches for pivots cost is left
/// out. With `library_roots` DevicePlan::roots are factored as a whole.
DeviceFlops count_flops(const SymbolicPlan& plan, const DevicePlan& lists, bool library_roots);

}  // namespace mfs
