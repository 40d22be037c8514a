#include "plan/segment_order.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace mfs {

namespace {

/// One use: makes one order.
class Orderer {
 public:
  Orderer(const SymbolicPlan& plan, Vertex level, Offset most) : plan_(plan), most_(most) {
    order_.level = level;
  }

  SegmentOrder run() {
    const Vertex first = plan_.depth_begin[plan_.num_depths - 1];
    std::vector<Vertex> roots(static_cast<std::size_t>(plan_.num_fronts - first));
    std::iota(roots.begin(), roots.end(), first);
    if (order_.level == 0) {
      add_below(roots);
    } else {
      for (const Vertex root : roots) add_children(root, 1);
    }
    add(roots, plan_.num_depths - 1, std::numeric_limits<Offset>::max());
    return std::move(order_);
  }

 private:
  void add_children(Vertex f, Vertex level) {
    for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) {
      const Vertex child = plan_.children[c];
      if (level == order_.level) {
        add_below({child});
      } else {
        add_children(child, level + 1);
      }
      add({child}, plan_.num_depths - 1 - level, most_);
    }
  }

  // What is below fronts of one depth.
  void add_below(const std::vector<Vertex>& fronts) {
    std::vector<std::vector<Vertex>> depths{fronts};
    while (!depths.back().empty()) {
      std::vector<Vertex> below;
      for (const Vertex f : depths.back())
        below.insert(below.end(), plan_.children.begin() + plan_.child_begin[f],
                     plan_.children.begin() + plan_.child_begin[f + 1]);
      std::sort(below.begin(), below.end());
      depths.push_back(std::move(below));
    }
    const Vertex step = step_of(fronts.front());
    for (std::size_t k = depths.size() - 1; k > 0; --k) add(depths[k], step - static_cast<Vertex>(k), most_);
  }
  Vertex step_of(Vertex f) const {
    const auto& begin = plan_.depth_begin;
    return static_cast<Vertex>(std::upper_bound(begin.begin(), begin.end(), f) - begin.begin()) - 1;
  }

  void add(const std::vector<Vertex>& fronts, Vertex step, Offset most) {
    Offset entries = 0;
    for (const Vertex f : fronts) {
      const Offset p = plan_.pivots(f);
      const Offset own = aligned(p * plan_.lower_ld(f)) + aligned(p * plan_.border_rows(f));
      if (entries > 0 && entries > most - own) {
        end_segment(step);
        entries = 0;
      }
      order_.fronts.push_back(f);
      entries += own;
    }
    end_segment(step);
  }
  void end_segment(Vertex step) {
    const auto end = static_cast<Vertex>(order_.fronts.size());
    if (end == order_.begin.back()) return;
    order_.begin.push_back(end);
    order_.step.push_back(step);
  }

  const SymbolicPlan& plan_;
  const Offset most_;
  SegmentOrder order_;
};

}  // namespace

SegmentOrder order_segments(const SymbolicPlan& plan, Vertex level, Offset most) {
  return Orderer(plan, level, most).run();
}

}  // namespace mfs
