// What an integrator is given, refused with its name where it is not what it has to be.
#pragma once

#include <vector>

#include "dae/integrator/integrator.hpp"

namespace mfs::dae {

void check_options(const IntegratorOptions& options);
/// Steps that are so short that `time` would never be over.
void check_step_number(const IntegratorOptions& options, double time);
/// One finite value for each of n coordinates.
void check_vector(const std::vector<double>& values, int n, const char* name);
/// Finite and in their order.
void check_times(double t0, double t_end, const std::vector<double>& outputs);

}  // namespace mfs::dae
