// A matrix by the name that a program is given: of a benchmark family or of a file.
#pragma once

#include <string>

#include "solver/program/matrix_market.hpp"

namespace mfs::io {

/// Throws InvalidInput unless `name` is FAMILY:SIZE of a known family or an existing file.
void check_bench_case(const std::string& name);
/// "elas3d:20" as it is, "data/west0479.mtx.gz" as "west0479".
std::string bench_case_name(const std::string& name);
/// Makes the matrix or reads it. Throws InvalidInput, and what read_square_matrix throws.
SquareMatrix load_bench_case(const std::string& name, int threads);

}  // namespace mfs::io
