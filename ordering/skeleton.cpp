#include "ordering/skeleton.hpp"

#include <algorithm>
#include <numeric>

namespace mfs {
namespace {

/// A skeleton has at most this share of the vertices, and at least so many.
constexpr double kMostKept = 0.7;
constexpr Vertex kLeastKept = 64;

class SkeletonMaker {
 public:
  explicit SkeletonMaker(const SubGraph& connected)
      : whole_(connected), most_(static_cast<Vertex>(kMostKept * connected.size())) {}

  Skeleton make() {
    if (!is_size(count_if([&](Vertex v) { return neighbors(v) > 2; }))) return {};
    strip_trees();
    walk_chains();
    if (!is_size(count_if([&](Vertex v) { return made_.place[v] == Skeleton::kKept; }))) return {};
    number_vertices();
    return std::move(made_);
  }

 private:
  static constexpr Vertex kUnseen = -3;

  template <class Holds>
  Vertex count_if(const Holds& holds) const {
    Vertex count = 0;
    for (Vertex v = 0; v < whole_.size(); ++v) count += holds(v);
    return count;
  }
  bool is_size(Vertex kept) const { return kLeastKept <= kept && kept <= most_; }
  idx_t neighbors(Vertex v) const { return whole_.offsets[v + 1] - whole_.offsets[v]; }

  template <class Call>
  void for_neighbors(Vertex v, const Call& call) const {
    for (idx_t k = whole_.offsets[v]; k < whole_.offsets[v + 1]; ++k) call(whole_.neighbors[k]);
  }

  void strip_trees() {
    made_.place.assign(whole_.vertices.size(), kUnseen);
    degree_.resize(whole_.vertices.size());
    std::vector<Vertex> leaves;
    for (Vertex v = 0; v < whole_.size(); ++v) {
      degree_[v] = neighbors(v);
      if (degree_[v] == 1) leaves.push_back(v);
    }
    while (!leaves.empty()) {
      const Vertex v = leaves.back();
      leaves.pop_back();
      made_.place[v] = Skeleton::kTree;
      for_neighbors(v, [&](Vertex w) {
        if (made_.place[w] == Skeleton::kTree) return;
        made_.hanging.emplace_back(v, w);
        if (--degree_[w] == 1) leaves.push_back(w);
      });
    }
  }

  bool is_junction(Vertex v) const { return made_.place[v] != Skeleton::kTree && degree_[v] > 2; }

  void walk_chains() {
    for (Vertex v = 0; v < whole_.size(); ++v)
      if (is_junction(v)) made_.place[v] = Skeleton::kKept;
    for (Vertex v = 0; v < whole_.size(); ++v) {
      if (!is_junction(v)) continue;
      for_neighbors(v, [&](Vertex w) {
        if (made_.place[w] == kUnseen) {
          walk_chain(v, w);
        } else if (is_junction(w) && v < w) {
          made_.ends.emplace_back(v, w);
        }
      });
    }
  }

  // From a junction to the next one. A vertex that is no lighter than the last one kept is not needed: that
  // one separates as well.
  void walk_chain(Vertex kept, Vertex next) {
    Vertex before = kept, v = next;
    while (!is_junction(v)) {
      if (whole_.weights[v] < whole_.weights[kept]) {
        made_.ends.emplace_back(kept, v);
        made_.place[v] = Skeleton::kKept;
        kept = v;
      } else {
        made_.place[v] = static_cast<Vertex>(made_.ends.size());
      }
      Vertex beyond = v;
      for_neighbors(v, [&](Vertex w) {
        if (w != before && made_.place[w] != Skeleton::kTree) beyond = w;
      });
      before = std::exchange(v, beyond);
    }
    made_.ends.emplace_back(kept, v);
  }

  void number_vertices() {
    SubGraph& graph = made_.graph;
    RawVector<idx_t> number(whole_.vertices.size());
    for (Vertex v = 0; v < whole_.size(); ++v) {
      if (made_.place[v] != Skeleton::kKept) continue;
      number[v] = graph.size();
      graph.vertices.push_back(v);
      graph.weights.push_back(whole_.weights[v]);
      graph.weight += whole_.weights[v];
    }
    join_ends(number);
  }

  // Chains between the same two ends are one edge.
  void join_ends(const RawVector<idx_t>& number) {
    SubGraph& graph = made_.graph;
    const auto for_edges = [&](const auto& call) {
      for (const auto& [v, w] : made_.ends) {
        if (v == w) continue;
        call(number[v], number[w]);
        call(number[w], number[v]);
      }
    };
    graph.offsets.assign(graph.vertices.size() + 1, 0);
    for_edges([&](idx_t v, idx_t) { ++graph.offsets[v + 1]; });
    std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
    graph.neighbors.resize(static_cast<std::size_t>(graph.offsets[graph.size()]));
    std::vector<idx_t> next(graph.offsets.begin(), graph.offsets.end() - 1);
    for_edges([&](idx_t v, idx_t w) { graph.neighbors[next[v]++] = w; });
    auto* kept = graph.neighbors.data();
    idx_t begin = 0;
    for (Vertex v = 0; v < graph.size(); ++v) {
      auto *const first = graph.neighbors.data() + begin, *const last = graph.neighbors.data() + next[v];
      std::sort(first, last);
      begin = next[v];
      kept = std::copy(first, std::unique(first, last), kept);
      graph.offsets[v + 1] = static_cast<idx_t>(kept - graph.neighbors.data());
    }
    graph.neighbors.resize(static_cast<std::size_t>(graph.offsets[graph.size()]));
  }

  const SubGraph& whole_;
  const Vertex most_;
  RawVector<Vertex> degree_;  // without trees
  Skeleton made_;
};

}  // namespace

Skeleton make_skeleton(const SubGraph& connected) {
  return SkeletonMaker(connected).make();
}

RawVector<idx_t> whole_part_of(const SubGraph& connected, const Skeleton& skeleton,
                               const RawVector<idx_t>& part_of) {
  constexpr idx_t kSeparator = 2;
  RawVector<idx_t> whole(connected.vertices.size());
  Offset side[3] = {0, 0, 0};
  const auto put = [&](Vertex v, idx_t part) {
    whole[v] = part;
    side[part] += connected.weights[v];
  };
  const auto lighter = [&] { return static_cast<idx_t>(side[1] < side[0]); };

  for (Vertex v = 0; v < skeleton.graph.size(); ++v) put(skeleton.graph.vertices[v], part_of[v]);
  std::vector<idx_t> part_of_chain;
  for (const auto& [v, w] : skeleton.ends) part_of_chain.push_back(std::min(whole[v], whole[w]));
  for (Vertex v = 0; v < connected.size(); ++v) {
    if (skeleton.place[v] < 0) continue;
    idx_t& part = part_of_chain[skeleton.place[v]];
    if (part == kSeparator) part = lighter();
    put(v, part);
  }
  for (auto one = skeleton.hanging.rbegin(); one != skeleton.hanging.rend(); ++one) {
    const auto [v, holder] = *one;
    put(v, whole[holder] == kSeparator ? lighter() : whole[holder]);
  }
  return whole;
}

}  // namespace mfs
