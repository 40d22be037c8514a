// Which fronts of a depth are shared out one per thread, and which are large enough to be worked on by all
// threads together, one after another.
#pragma once

#include <vector>

#include "ordering/symbolic_plan.hpp"

namespace mfs {

struct DepthSchedule {
  std::vector<Vertex>
      small;  // longest first, dealt so that each thread's share of the list begins with a long one
  std::vector<Vertex> large;
};

using Schedule = std::vector<DepthSchedule>;  // by step of the plan, deepest depth first

Schedule make_schedule(const SymbolicPlan& plan, int threads);

}  // namespace mfs
