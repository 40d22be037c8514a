#include "plan/subtrees.hpp"

#include <algorithm>
#include <numeric>

#include "plan/schedule.hpp"

namespace mfs {

namespace {

// Entries of a stack: what a second-level cache of 1 MB holds in double precision.
constexpr Offset kMostStack = 1 << 17;
// Each thread has so many subtrees' work to do at least, so that they end at about the same time.
constexpr double kShares = 8;
// Subtrees of fewer operations are done several in a task.
constexpr double kTaskFlops = 1e6;

// Of trees with more depths not every one is tried to cut them at.
constexpr Vertex kCloseTrees = 32;

struct Range {
  Offset begin, end;
};

class SubtreeMaker {
 public:
  SubtreeMaker(const SymbolicPlan& plan, int threads) : plan_(plan), threads_(threads) {
    below_ = plan.front_flops;
    for (double& flops : below_) flops += kFrontFlops;
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      if (plan.parent[f] >= 0) below_[plan.parent[f]] += below_[f];
    }
  }

  Subtrees make() {
    for (Vertex steps = plan_.num_depths; steps > 1; steps -= 1 + steps / kCloseTrees) {
      if (!is_shared_well(steps) || !find_places(steps)) continue;
      find_stacks(steps);
      if (static_cast<int>(made_.stack.size()) < threads_) continue;
      made_.steps = steps;
      make_tasks();
      return std::move(made_);
    }
    return Subtrees();
  }

 private:
  Offset block_entries(Vertex f) const {
    return static_cast<Offset>(plan_.contribution_ld(f)) * plan_.border_rows(f);
  }

  bool is_shared_well(Vertex steps) const {
    if (threads_ == 1) return true;
    double total = 0, largest = 0;
    for (Vertex f = plan_.depth_begin[steps - 1]; f < plan_.depth_begin[steps]; ++f) {
      total += below_[f];
      largest = std::max(largest, below_[f]);
    }
    return largest * kShares * threads_ <= total;
  }

  // The fronts below the roots of these steps in postorder, and where their blocks lie on a stack; false
  // where one would be too high.
  bool find_places(Vertex steps) {
    order_.clear();
    root_begin_.clear();
    made_.place.assign(static_cast<std::size_t>(plan_.depth_begin[steps]), -1);
    height_[0] = height_[1] = 0;
    roots_.resize(static_cast<std::size_t>(plan_.depth_begin[steps] - plan_.depth_begin[steps - 1]));
    std::iota(roots_.begin(), roots_.end(), plan_.depth_begin[steps - 1]);
    std::stable_sort(roots_.begin(), roots_.end(), [&](Vertex a, Vertex b) { return below_[a] > below_[b]; });
    for (const Vertex root : roots_) {
      root_begin_.push_back(static_cast<Vertex>(order_.size()));
      if (!visit(root)) return false;
    }
    root_begin_.push_back(static_cast<Vertex>(order_.size()));
    for (Vertex k = 0; k + 1 < steps; ++k) {  // the other end begins where the first may reach to
      for (Vertex f = plan_.depth_begin[k]; k % 2 == 1 && f < plan_.depth_begin[k + 1]; ++f)
        made_.place[f] += height_[0];
    }
    return true;
  }

  // Without recursion: trees may be deep.
  bool visit(Vertex root) {
    struct Visit {
      Vertex front, next_child;
    };
    std::vector<Visit> path{{root, plan_.child_begin[root]}};
    Vertex step = step_of(root);
    Offset top[2] = {0, 0};
    while (!path.empty()) {
      Visit& visit = path.back();
      const Vertex f = visit.front;
      if (visit.next_child < plan_.child_begin[f + 1]) {
        const Vertex child = plan_.children[visit.next_child++];
        path.push_back({child, plan_.child_begin[child]});
        --step;
        continue;
      }
      order_.push_back(f);
      if (f != root) {
        Offset& end = top[step % 2];
        made_.place[f] = end;
        end += block_entries(f);
        height_[step % 2] = std::max(height_[step % 2], end);
        if (height_[0] + height_[1] > kMostStack) return false;
      }
      for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c)
        top[(step + 1) % 2] -= block_entries(plan_.children[c]);
      path.pop_back();
      ++step;
    }
    return true;
  }
  Vertex step_of(Vertex f) const {
    const auto after = std::upper_bound(plan_.depth_begin.begin(), plan_.depth_begin.end(), f);
    return static_cast<Vertex>(after - plan_.depth_begin.begin()) - 1;
  }

  // Free are the region behind the subtrees' factors and between the blocks of their roots.
  void find_stacks(Vertex steps) {
    Offset factors_end = 0;
    for (Vertex f = 0; f < plan_.depth_begin[steps]; ++f) {
      const Offset p = plan_.pivots(f);
      factors_end = std::max({factors_end, plan_.lower_begin[f] + p * plan_.lower_ld(f),
                              plan_.upper_begin[f] + p * plan_.border_rows(f)});
    }
    std::vector<Range> taken;
    for (const Vertex root : roots_) {
      if (block_entries(root) == 0) continue;
      const Offset begin = plan_.contribution_begin[root];
      taken.push_back({begin, begin + block_entries(root)});
    }
    taken.push_back({plan_.storage_entries, plan_.storage_entries});
    std::sort(taken.begin(), taken.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
    const Offset size = aligned(std::max<Offset>(height_[0] + height_[1], kAlignment));
    made_.stack.clear();
    Offset begin = aligned(factors_end);
    for (const Range& range : taken) {
      for (; begin + size <= range.begin && static_cast<int>(made_.stack.size()) < threads_; begin += size)
        made_.stack.push_back(begin);
      begin = std::max(begin, aligned(range.end));
    }
  }

  void make_tasks() {
    made_.front = order_;
    made_.begin.push_back(0);
    double flops = 0;
    for (std::size_t k = 0; k < roots_.size(); ++k) {
      flops += below_[roots_[k]];
      if (flops < kTaskFlops && k + 1 < roots_.size()) continue;
      made_.begin.push_back(root_begin_[k + 1]);
      flops = 0;
    }
  }

  const SymbolicPlan& plan_;
  int threads_;
  std::vector<double> below_;  // by front: operations of its subtree
  std::vector<Vertex> roots_, root_begin_, order_;
  Offset height_[2] = {0, 0};
  Subtrees made_;
};

}  // namespace

Subtrees make_subtrees(const SymbolicPlan& plan, int threads) {
  return SubtreeMaker(plan, threads).make();
}

}  // namespace mfs
