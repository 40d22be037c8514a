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
/// Makes them as they would be if `rtol`, which was given alone, were that of the local error. False: they
/// are.
bool relax_local_tolerances(IntegratorOptions& options, double rtol);

}  // namespace mfs::dae
