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
  /// The first after t + `moment` that is farther before `end`, or `end`.
  double next(double t, double end, double moment) const {
    const auto mark = std::upper_bound(times_.begin(), times_.end(), t + moment);
    return mark == times_.end() || *mark >= end - 2.0 * moment ? end : *mark;
  }

 private:
  std::vector<double> times_;
};

}  // namespace mfs::dae
