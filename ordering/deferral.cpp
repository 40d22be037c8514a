#include "ordering/deferral.hpp"

#include <algorithm>

#include "ordering/elimination_tree.hpp"

namespace mfs {
namespace {

/// Gives each weak unknown a partner of its own that stands before it, as far as alternating paths find one
/// (Duff's depth-first search, with as many steps in all as kSearch times the lists are long).
class PartnerSearch {
 public:
  PartnerSearch(const WeakUnknowns& weak, const Partition& partition, const std::vector<Vertex>& position)
      : weak_(weak),
        partition_(partition),
        position_(position),
        mate_(weak.unknown.size()),
        next_(weak.unknown.size()),
        visited_(weak.unknown.size(), -1),
        holder_(partition.vertex_of.size(), -1),
        steps_(kSearch * static_cast<Offset>(weak.partner.size())) {
    for (Vertex k = 0; k < count(); ++k) {
      mate_[k] = weak.partner[weak.begin[k]];
      holder_[mate_[k]] = k;
    }
    for (Vertex k = 0; k < count(); ++k) {
      if (!served(k)) augment(k);
    }
    for (Vertex k = 0; k < count(); ++k) {
      if (!served(k)) take_first_free(k);
    }
  }

  Vertex count() const { return static_cast<Vertex>(weak_.unknown.size()); }
  bool served(Vertex k) const { return place(mate_[k]) <= place(weak_.unknown[k]); }
  /// Where k's partner stands.
  Vertex partner_place(Vertex k) const { return place(mate_[k]); }

 private:
  static constexpr Offset kSearch = 20;

  Vertex place(Vertex unknown) const { return position_[partition_.vertex_of[unknown]]; }
  bool stands_before(Vertex partner, Vertex k) const { return place(partner) <= place(weak_.unknown[k]); }

  /// A path root - partner - its holder - partner - ... - free partner, each partner before its new holder.
  void augment(Vertex root) {
    path_.assign(1, root);
    enter(root, root);
    while (!path_.empty() && steps_ > 0) {
      const Vertex k = path_.back();
      if (next_[k] == weak_.begin[k + 1]) {
        path_.pop_back();
        continue;
      }
      const Vertex partner = weak_.partner[next_[k]++];
      --steps_;
      if (!stands_before(partner, k)) continue;
      const Vertex holder = holder_[partner];
      if (holder < 0) return flip(root);
      if (visited_[holder] != root && served(holder)) {
        path_.push_back(holder);
        enter(holder, root);
      }
    }
  }
  void enter(Vertex k, Vertex root) {
    visited_[k] = root;
    next_[k] = weak_.begin[k];
  }
  /// Each on the path takes the partner that was looked at last; the root's own becomes free.
  void flip(Vertex root) {
    holder_[mate_[root]] = -1;
    for (const Vertex k : path_) {
      mate_[k] = weak_.partner[next_[k] - 1];
      holder_[mate_[k]] = k;
    }
  }

  void take_first_free(Vertex k) {
    holder_[mate_[k]] = -1;
    for (Offset p = weak_.begin[k]; p < weak_.begin[k + 1]; ++p) {
      const Vertex partner = weak_.partner[p];
      if (holder_[partner] < 0 && place(partner) < place(mate_[k])) mate_[k] = partner;
    }
    holder_[mate_[k]] = k;
  }

  const WeakUnknowns& weak_;
  const Partition& partition_;
  const std::vector<Vertex>& position_;
  std::vector<Vertex> mate_;
  std::vector<Offset> next_;
  std::vector<Vertex> visited_, holder_, path_;
  Offset steps_;
};

}  // namespace

Deferral defer_weak_unknowns(const WeakUnknowns& weak, const Partition& partition,
                             const std::vector<Vertex>& order) {
  const std::vector<Vertex> position = inverse_permutation(order);
  const PartnerSearch search(weak, partition, position);
  std::vector<Vertex> behind(order.size(), -1);  // by vertex: the position that it moves behind
  for (Vertex k = 0; k < search.count(); ++k) {
    Vertex& target = behind[partition.vertex_of[weak.unknown[k]]];
    if (!search.served(k)) target = std::max(target, search.partner_place(k));
  }

  Deferral result{order, 0};
  const auto key = [&](Vertex v) {
    return behind[v] < 0 ? 2 * Offset{position[v]} : 2 * Offset{behind[v]} + 1;
  };
  std::stable_sort(result.order.begin(), result.order.end(),
                   [&](Vertex a, Vertex b) { return key(a) < key(b); });
  result.moved =
      static_cast<Vertex>(std::count_if(behind.begin(), behind.end(), [](Vertex b) { return b >= 0; }));
  return result;
}

}  // namespace mfs
