// Systems of one pattern for perf_batch: a matrix of a family or a file, or a chain of rigid bodies with
// joints, and values within 10 % of it by chance.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cases/families.hpp"

namespace mfs::perf {

struct BatchCase {
  cases::FamilyMatrix a;          ///< of which the values are those of the analysis
  std::int64_t count = 0;         ///< systems
  std::vector<double> values, b;  ///< one system after the other
};

/// `name`: FAMILY:SIZE, a file, or chain:BODIES, whose 11 BODIES + 2 unknowns are the accelerations of the
/// bodies and the forces of the joints.
BatchCase make_batch_case(const std::string& name, std::int64_t count);

/// The worst componentwise backward error of all systems.
double worst_error(const BatchCase& batch, const double* x);

}  // namespace mfs::perf
