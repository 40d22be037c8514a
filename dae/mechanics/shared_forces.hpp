// Forces of elements without a colour, as those of joints that all have one body. All
// threads compute them, each element's share to a place of its own; then each coordinate gets its shares in
// the order of the elements, so that sums do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "dae/mechanics/colouring.hpp"
#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

class SharedForces {
 public:
  SharedForces() = default;
  /// `coordinates_of(element)`: those of an element, of `coordinates` in all.
  template <class CoordinatesOf>
  SharedForces(const std::vector<std::shared_ptr<const ElementGroup>>& groups, const Colouring& colouring,
               int coordinates, const CoordinatesOf& coordinates_of) {
    std::vector<std::vector<std::size_t>> shares(static_cast<std::size_t>(coordinates));
    std::size_t next = 0;
    for (std::size_t k = colouring.colour_start.back(); k < colouring.order.size(); ++k) {
      const ElementId id = colouring.order[k];
      const int* const of_element = coordinates_of(id);
      element_start_.push_back(next);
      for (int i = 0; i < groups[id.group]->local_coordinates(); ++i) shares[of_element[i]].push_back(next++);
    }
    for (int c = 0; c < coordinates; ++c) {
      if (shares[c].empty()) continue;
      coordinate_.push_back(c);
      place_.insert(place_.end(), shares[c].begin(), shares[c].end());
      place_start_.push_back(place_.size());
    }
    share_.resize(next);
  }

  std::size_t elements() const { return element_start_.size(); }
  /// The joints of a mechanism are mostly less work than waking threads.
  bool are_worth_threads() const { return share_.size() > kSharesWorthThreads; }
  /// Of the k-th of these elements.
  double* share(std::size_t k) { return share_.data() + element_start_[k]; }

  void add_to(double* force, int threads) const {
    const auto count = static_cast<std::int64_t>(coordinate_.size());
#pragma omp parallel for num_threads(threads) schedule(dynamic, 8) if (are_worth_threads())
    for (std::int64_t c = 0; c < count; ++c) {
      double sum = force[coordinate_[c]];
      for (std::size_t p = place_start_[c]; p < place_start_[c + 1]; ++p) sum += share_[place_[p]];
      force[coordinate_[c]] = sum;
    }
  }

 private:
  /// 70 joints of two bodies, 17 elements of 20 nodes.
  static constexpr std::size_t kSharesWorthThreads = 1024;

  std::vector<std::size_t> element_start_;           // of each element: its first share
  std::vector<double> share_;                        // element by element
  std::vector<int> coordinate_;                      // those that have shares
  std::vector<std::size_t> place_start_{0}, place_;  // where they are
};

}  // namespace mfs::dae
