// Tolerances of the local error, from those that the user gives.
//
// A method of order k with local errors of tol leaves a global error that goes with tol^(k / (k + 1)): 46
// times less where tol is 100 times less and k = 5. A user expects 100 (tolerance proportionality: Shampine;
// Soderlind, "Digital filters in adaptive time-stepping", ACM TOMS 29 (2003) 1-26). So where nothing but rtol
// is given, the local error is asked to be less than rtol by (rtol / 1e-4)^(1 / k) from the default 1e-4 on.
// This is the same run as with a smaller rtol before: no work is lost. Tolerances that are given are those of
// the local error.
#pragma once

#include "dae/integrator/integrator.hpp"

namespace mfs::dae {

/// Replaces rtol, atol_position and atol_velocity of `options` by those of the local error.
void set_local_tolerances(IntegratorOptions& options);

/// Those of a run. Near singular positions rounding may be more than is asked for beyond rtol, so that no
/// search of Newton's method succeeds: for some steps then local errors may be rtol. Where a way out of one
/// is to be told from others, they have to be smaller than what tells it.
class LocalTolerances {
 public:
  /// Makes `used` the `asked` ones with tolerances of the local error. Both have to live as long.
  LocalTolerances(const IntegratorOptions& asked, IntegratorOptions& used);
  /// After a search that failed. True: local errors may be larger from now on.
  bool relax();
  /// Local errors are small from now on, whatever is asked for.
  void make_small();
  /// Not any more: the singular position has been left. As relax() besides.
  void leave_singular() {
    small_ = false;
    relax();
  }
  /// After a step.
  void go_on() {
    if (relaxed_steps_ > 0 && --relaxed_steps_ == 0) tighten();
  }

 private:
  void tighten();

  const IntegratorOptions& asked_;
  IntegratorOptions& used_;
  int relaxed_steps_ = 0;  ///< that are left
  bool small_ = false;
};

}  // namespace mfs::dae
