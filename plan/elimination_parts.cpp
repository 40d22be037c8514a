#include "plan/elimination_parts.hpp"

#include <algorithm>
#include <numeric>

namespace mfs {

namespace {

class Division {
 public:
  explicit Division(const SymbolicPlan& plan)
      : plan_(plan), done_(static_cast<std::size_t>(plan.num_fronts)), left_(done_.size()) {}

  /// Fronts that are not done, in parts of about as much work, at most `most` of them; all are done by one.
  void add_stage(EliminationParts& parts, std::size_t most) {
    weigh();
    std::vector<Vertex> pieces = divided(most);
    std::stable_sort(pieces.begin(), pieces.end(), [&](Vertex a, Vertex b) { return left_[a] > left_[b]; });
    std::vector<std::vector<Vertex>> bins(std::min(most, pieces.size()));
    std::vector<double> work(bins.size());
    for (const Vertex piece : pieces) {
      const auto least = static_cast<std::size_t>(std::min_element(work.begin(), work.end()) - work.begin());
      bins[least].push_back(piece);
      work[least] += left_[piece];
    }
    for (std::vector<Vertex>& bin : bins) {
      std::sort(bin.begin(), bin.end());
      for (const Vertex root : bin) add_subtree(root, parts.order);
      parts.part_begin.push_back(static_cast<Vertex>(parts.order.size()));
    }
    parts.stage_begin.push_back(static_cast<Vertex>(parts.part_begin.size()) - 1);
  }
  bool is_done() const {
    return std::all_of(done_.begin(), done_.end(), [](char done) { return done != 0; });
  }

 private:
  // The work that is left in each subtree. Children come before their parents.
  void weigh() {
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      left_[f] = done_[f] ? 0 : 1 + plan_.front_flops[f];
      for_children(f, [&](Vertex child) { left_[f] += left_[child]; });
    }
  }
  template <class Body>
  void for_children(Vertex f, const Body& body) const {
    for (Vertex c = plan_.child_begin[f]; c < plan_.child_begin[f + 1]; ++c) body(plan_.children[c]);
  }
  // Subtrees so small that they can be put into bins of the same size; what is above them waits.
  std::vector<Vertex> divided(std::size_t most) const {
    std::vector<Vertex> roots, pieces;
    double all = 0;
    for (Vertex f = 0; f < plan_.num_fronts; ++f) {
      const bool is_root = !done_[f] && (plan_.parent[f] < 0 || done_[plan_.parent[f]]);
      if (!is_root) continue;
      roots.push_back(f);
      all += left_[f];
    }
    if (most == 1) return roots;
    while (!roots.empty()) {
      const Vertex f = roots.back();
      roots.pop_back();
      bool has_more = false;
      for_children(f, [&](Vertex child) { has_more = has_more || !done_[child]; });
      if (!has_more || left_[f] * 2 * static_cast<double>(most) <= all) {
        pieces.push_back(f);
      } else {
        for_children(f, [&](Vertex child) {
          if (!done_[child]) roots.push_back(child);
        });
      }
    }
    return pieces;
  }
  void add_subtree(Vertex root, std::vector<Vertex>& order) {
    std::vector<Vertex> waiting{root}, fronts;  // each before its children
    while (!waiting.empty()) {
      const Vertex f = waiting.back();
      waiting.pop_back();
      fronts.push_back(f);
      for_children(f, [&](Vertex child) {
        if (!done_[child]) waiting.push_back(child);
      });
    }
    for (auto f = fronts.rbegin(); f != fronts.rend(); ++f) {
      done_[*f] = 1;
      for (Vertex k = plan_.pivot_begin[*f]; k < plan_.pivot_begin[*f + 1]; ++k) order.push_back(k);
    }
  }

  const SymbolicPlan& plan_;
  std::vector<char> done_;    // by front
  std::vector<double> left_;  // likewise
};

}  // namespace

EliminationParts divide_elimination(const SymbolicPlan& plan, int most) {
  EliminationParts parts;
  parts.part_begin.push_back(0);
  parts.stage_begin.push_back(0);
  Division division(plan);
  for (int bins = std::max(most, 1); !division.is_done(); bins = std::max(bins / 4, 1))
    division.add_stage(parts, static_cast<std::size_t>(bins));
  return parts;
}

}  // namespace mfs
