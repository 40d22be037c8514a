// ChangeWatch of functions of coordinates and of springs: each operation that they are made of is enclosed
// along the step. Where its result leaves what it is at both ends by more than a quarter of its range in the
// run so far, something is passed over.
#pragma once

#include <cmath>
#include <vector>

#include "dae/mechanics/change_watch.hpp"
#include "dae/mechanics/watched_function.hpp"

namespace mfs::dae {

class StateChanges final : public ChangeWatch {
 public:
  explicit StateChanges(const WatchedFunctions& functions);
  /// Whether none of them can change suddenly.
  bool empty() const { return watched_.empty(); }

  void go_on(double t, const double* q, const double* v) override;
  Verdict look(double t, const double* q, const double* v) override;

 private:
  /// An operation that is looked at.
  struct Operation {
    int number;
    Interval results = {HUGE_VAL, -HUGE_VAL};  // until now
    double before = 0.0;                       // its result at the beginning of a step
    int seen = 0;     // times that a step has passed over a change, less steps that have been taken
    int ignored = 0;  // steps for which it is not looked at
  };
  struct End {
    double t = 0.0;
    WatchedFunction::Arguments arguments;
  };
  /// A function with its arguments at both ends of a step.
  struct Watched {
    std::shared_ptr<const WatchedFunction> function;
    std::vector<Operation> operations;
    End from, to;
  };
  class Along;

  std::vector<Watched> watched_;
};

}  // namespace mfs::dae
