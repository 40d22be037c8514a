// Right-hand sides with few entries, as the sources of a circuit have, and matrices that have a block
// triangular form, by factors of the whole matrix: unknowns that are zero stand in rows that meet nothing
// else.
#include <cmath>
#include <filesystem>
#include <string>

#include "test/solver/on_device.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

/// Blocks whose diagonal is no larger than the rest; some have entries over six decades.
SparseMatrix reducible(Random& random) {
  std::vector<std::int64_t> sizes(static_cast<std::size_t>(random.integer(3, 40)));
  for (std::int64_t& size : sizes) size = random.integer(1, 12);
  SparseMatrix a = permuted_blocks(sizes, static_cast<std::uint64_t>(random.integer(0, 1000)));
  const bool graded = random.chance(0.4);
  for (double& value : a.values)
    value = graded ? random.entry() * std::pow(10, 3 * random.entry()) : random.entry();
  return a;
}

void expect_unit_vectors_are_solved_for(Backend backend) {
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE("trial " + std::to_string(trial));
    Random random(static_cast<std::uint64_t>(trial));
    const SparseMatrix a = reducible(random), at = transposed(a);
    Options options;
    options.backend = backend;
    options.threads = 1;
    // As factors in a file are those of the whole matrix.
    if (backend == Backend::serial) options.out_of_core_dir = std::filesystem::temp_directory_path();
    Solver solver(options);
    solver.factor(a.view());
    EXPECT_EQ(solver.report().diagonal_blocks, 1);
    for (int k = 0; k < 4; ++k) {
      std::vector<double> b(static_cast<std::size_t>(a.n), 0.0), x(b.size());
      b[static_cast<std::size_t>(random.integer(0, a.n))] = random.entry();
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(a, b, x), kPromised);
      solver.solve_transpose(b.data(), x.data());
      EXPECT_LE(backward_error(at, b, x), kPromised);
    }
  }
}

TEST(SparseRightSides, AreSolvedForByFactorsOfTheWhole) {
  expect_unit_vectors_are_solved_for(Backend::serial);
}
TEST(SparseRightSides, AreSolvedForByKokkos) {
  expect_unit_vectors_are_solved_for(Backend::kokkos);
}
class SparseRightSidesOnDevice : public OnDevice {};
TEST_F(SparseRightSidesOnDevice, AreSolvedFor) {
  expect_unit_vectors_are_solved_for(Backend::cuda);
}

}  // namespace
}  // namespace mfs::test
