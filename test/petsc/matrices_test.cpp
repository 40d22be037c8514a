// Matrices of MFS_MATRIX_DIR by mfs, petsc and mumps, each with its backward error by plain loops. Tables of
// what came out are printed.
#include <gmock/gmock.h>

#include <fstream>
#include <optional>
#include <sstream>
#include <variant>

#include "solver/program/matrix_market.hpp"
#include "test/petsc/factored.hpp"

namespace mfs::test {
namespace {

struct Line {
  std::string name, expectation;
  std::int64_t n = 0;
};

/// Square matrices of the manifest, whose first columns are name, family, "kind", n, m and whose cells may
/// have commas between quotation marks.
std::vector<Line> manifest(const std::string& folder) {
  std::ifstream file(folder + "/manifest.csv");
  std::vector<Line> lines;
  std::string text;
  std::getline(file, text);
  while (std::getline(file, text)) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : text) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        cells.emplace_back();
      else
        cells.back().push_back(c);
    }
    if (cells.size() > 15 && cells[3] == cells[4])
      lines.push_back({cells[0], cells[15], std::stoll(cells[3])});
  }
  return lines;
}

/// Empty where the values are not those of this PETSc.
std::optional<Sparse> read(const std::string& path) {
  const io::SquareMatrix read = io::read_square_matrix(path);
  const auto* a = std::get_if<io::CsrMatrix<PetscScalar>>(&read);
  if (a == nullptr) return std::nullopt;
  std::vector<BasicEntry<PetscScalar>> entries;
  for (std::int64_t i = 0; i < a->rows; ++i)
    for (std::int64_t k = a->offsets[i]; k < a->offsets[i + 1]; ++k)
      entries.push_back({i, a->column_indices[k], a->values[k]});
  return from_entries_summed(a->rows, entries);
}

struct Result {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  double error = 0;
  std::string text;
};

/// Refusals of other solvers are errors of PETSc, too.
Result solve_with(const char* solver, Mat m, const Sparse& a, const std::vector<PetscScalar>& b) {
  Result result;
  std::ostringstream text;
  try {
    const Krylov ksp = direct_solver(KSPPREONLY, nullptr, solver);
    good(KSPSetOperators(ksp, m, m));
    const std::vector<PetscScalar> x = solved(ksp, b);
    result.reason = reason_of(ksp);
    result.error = backward_error(a, b, x);
    text << (result.reason > 0 ? "" : "fails ") << result.error;
  } catch (const std::exception&) {
    text << "error";
  }
  result.text = text.str();
  return result;
}

/// Whether the solver is there and does not take minutes.
bool worth_it(const char* solver, Mat m, std::int64_t n) {
  PetscBool there = PETSC_FALSE;
  good(MatGetFactorAvailable(m, solver, MAT_FACTOR_LU, &there));
  return there && n <= (std::string(solver) == "petsc" ? 4000 : 20000);
}

TEST(PetscMatrices, BesidePetscAndMumps) {
  const char* folder = std::getenv("MFS_MATRIX_DIR");
  if (folder == nullptr || *folder == '\0') GTEST_SKIP() << "MFS_MATRIX_DIR is not set";
  int solved_ones = 0, refused_ones = 0;
  std::printf("%-22s %7s  %-11s %-11s %-11s\n", "", "n", "mfs", "petsc", "mumps");
  for (const Line& line : manifest(folder)) {
    if (line.n > 20000) continue;
    const std::optional<Sparse> a = read(std::string(folder) + "/" + line.name + ".mtx.gz");
    if (!a) continue;
    const Matrix m = petsc_matrix(*a);
    const std::vector<PetscScalar> b = right_hand_sides(*a, 1, a->n, 3);
    const Result mfs = solve_with("mfs", m, *a, b);
    std::printf("%-22s %7lld  %-11s", line.name.c_str(), static_cast<long long>(line.n), mfs.text.c_str());
    for (const char* other : {"petsc", "mumps"})
      std::printf(" %-11s", worth_it(other, m, line.n) ? solve_with(other, m, *a, b).text.c_str() : "-");
    std::printf("\n");
    if (line.expectation.rfind("solve", 0) == 0) {
      EXPECT_GT(mfs.reason, 0) << line.name;
      EXPECT_LE(mfs.error, kGood) << line.name;
      ++solved_ones;
    } else {
      EXPECT_EQ(mfs.reason, KSP_DIVERGED_PC_FAILED) << line.name;
      ++refused_ones;
    }
  }
  EXPECT_GE(solved_ones, 5);
  EXPECT_GE(refused_ones, std::is_floating_point_v<PetscScalar> ? 2 : 0);
}

}  // namespace
}  // namespace mfs::test
