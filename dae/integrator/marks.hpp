// Times that no step passes over.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

namespace mfs::dae {

class Marks {
 public:
  /// `times` ascend.
  explicit Marks(std::vector<double> times) : times_(std::move(times)) {}
  /// The first after t that is before `end`, or `end`.
  double next(double t, double end) const {
    const auto mark = std::upper_bound(times_.begin(), times_.end(), t);
    return mark == times_.end() ? end : std::min(*mark, end);
  }

 private:
  std::vector<double> times_;
};

}  // namespace mfs::dae
