// ChangeWatch of functions of coordinates: each operation of their expressions is enclosed (interval.hpp)
// along the step. Where its result leaves what it is at both ends by more than a quarter of its range in the
// run so far, something is passed over.
#pragma once

#include <vector>

#include "dae/mechanics/change_watch.hpp"
#include "dae/mechanics/state_function.hpp"

namespace mfs::dae {

class StateChanges final : public ChangeWatch {
 public:
  /// `functions`: of coordinates; they have to live as long.
  explicit StateChanges(const std::vector<const StateFunction*>& functions);
  /// Whether none of them can change suddenly.
  bool empty() const { return watched_.empty(); }

  void go_on(double t, const double* q, const double* v) override;
  Verdict look(double t, const double* q, const double* v) override;

 private:
  /// An expression with its arguments at both ends of a step.
  struct Watched {
    const StateFunction* function;
    std::vector<int> operations;   // that are looked at
    std::vector<Interval> range;   // of each of their results until now
    std::vector<double> from, to;  // t, then coordinates, then rates
    std::vector<double> before;    // their results at `from`
    int seen = 0;     // times that a step has passed over a change, less steps that have been taken
    int ignored = 0;  // steps for which it is not looked at
  };
  class Along;
  static std::vector<double> ends(const StateFunction& function, double t, const double* q, const double* v);

  std::vector<Watched> watched_;
};

}  // namespace mfs::dae
