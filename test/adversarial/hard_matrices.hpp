// One adversarial matrix per seed: the regular families of test/reference, and beside them singular, nearly
// singular and badly conditioned ones.
#pragma once

#include "test/reference/generators.hpp"

namespace mfs::test {

struct HardMatrix {
  std::string name;  // kind and seed
  SparseMatrix matrix;
  bool singular = false;                    // exactly, by construction in small integers
  std::vector<double> solution_sizes = {};  // as in NamedMatrix
};

HardMatrix hard_matrix(std::uint64_t seed);

}  // namespace mfs::test
