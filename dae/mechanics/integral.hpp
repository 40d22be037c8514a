// The integral of a function of one variable: the energy of a spring.
#pragma once

#include "dae/mechanics/smooth_function.hpp"

namespace mfs::dae {

/// From `from` to `to`, to 1e-12 of the largest value times the length, and next to kinks to 1e-5 of itself.
/// No pulse is too narrow to be found. NaN: it has more than some ten thousand waves there.
double integral(const SmoothFunction& function, double from, double to);

}  // namespace mfs::dae
