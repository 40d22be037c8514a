// What PETSc is told of systems that cannot be solved: a reason, not an error, unless an error was asked for;
// and with the next good values all is well again.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <cstdint>
#include <fstream>
#include <limits>

#include "test/petsc/factored.hpp"

namespace mfs::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// Rows 5 and 20 of a grid are the same; `distance` 0: singular.
Sparse with_equal_rows(double distance) {
  std::vector<BasicEntry<PetscScalar>> entries;
  const Sparse grid = scalar_grid(8, 7);
  for (const auto& e : mfs::test::entries_of(grid)) {
    if (e.row == 20) continue;
    entries.push_back(e);
    if (e.row == 5) entries.push_back({20, e.column, e.value});
  }
  entries.push_back({20, 20, PetscScalar(distance)});
  return from_entries_summed(grid.n, entries);
}

/// Row 11 has no value but zero; `value` is that of its diagonal.
Sparse with_zero_row(double value) {
  Sparse a = scalar_grid(8, 7);
  for (std::int64_t k = a.offsets[11]; k < a.offsets[12]; ++k) a.values[k] = a.columns[k] == 11 ? value : 0.0;
  return a;
}

PCFailedReason failed_reason(KSP ksp) {
  PC pc = nullptr;
  PCFailedReason reason = PC_NOERROR;
  good(KSPGetPC(ksp, &pc));
  good(PCGetFailedReason(pc, &reason));
  return reason;
}

void expect_zero_pivot(KSP ksp, const Sparse& a, const std::vector<PetscInt>& rows) {
  const std::vector<PetscScalar> x = solved(ksp, right_hand_sides(a, 1, a.n, 3));
  EXPECT_EQ(reason_of(ksp), KSP_DIVERGED_PC_FAILED);
  EXPECT_EQ(failed_reason(ksp), PC_FACTOR_NUMERIC_ZEROPIVOT);
  EXPECT_EQ(factor_error(factors_of(ksp)), MAT_FACTOR_NUMERIC_ZEROPIVOT);
  EXPECT_THAT(rows, testing::Contains(zero_pivot_row(factors_of(ksp))));
  EXPECT_FALSE(std::isfinite(std::abs(x[0]))) << "no number that could be taken for a solution";
}

struct Case {
  const char* name;
  Sparse singular, regular;
  std::vector<PetscInt> rows;
};
std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"equal rows", with_equal_rows(0), with_equal_rows(2), {5, 20}});
  all.push_back({"zero row", with_zero_row(0), with_zero_row(3), {11}});
  Sparse not_finite = scalar_grid(8, 7);
  not_finite.values[not_finite.offsets[17] + 1] = std::numeric_limits<double>::quiet_NaN();
  all.push_back({"NaN", not_finite, scalar_grid(8, 7), {17}});
  not_finite.values[not_finite.offsets[17] + 1] = std::numeric_limits<double>::infinity();
  all.push_back({"infinity", not_finite, scalar_grid(8, 7), {17}});
  return all;
}

void expect_recovered(KSP ksp, Mat m, const Sparse& a) {
  set_values(m, a);
  PetscBool gmres = PETSC_FALSE;
  good(PetscObjectTypeCompare((PetscObject)ksp, KSPGMRES, &gmres));
  // GMRES of 3.18 forgets the infinities of a failure only in a solve, with each solver of PETSc.
  if (gmres) solved(ksp, right_hand_sides(a, 1, a.n, 3));
  expect_solved(ksp, a);
}

TEST(PetscFailure, MatrixThatCannotBeFactored) {
  for (const Case& given : cases()) {
    SCOPED_TRACE(given.name);
    for (const KSPType type : {KSPPREONLY, KSPGMRES}) {
      const Krylov ksp = direct_solver(type);
      const Matrix m = petsc_matrix(given.singular);
      good(KSPSetOperators(ksp, m, m));
      expect_zero_pivot(ksp, given.singular, given.rows);  // from the beginning
      expect_recovered(ksp, m, given.regular);
      set_values(m, given.singular);
      expect_zero_pivot(ksp, given.singular, given.rows);  // after a good one
      expect_zero_pivot(ksp, given.singular, given.rows);
      expect_recovered(ksp, m, given.regular);
    }
  }
}

TEST(PetscFailure, SingularIsSolvedOnRequest) {
  const Option option("-mat_mfs_solve_singular", "yes");
  const Sparse a = with_equal_rows(0);
  const Krylov ksp = direct_solver();
  const Matrix m = petsc_matrix(a);
  good(KSPSetOperators(ksp, m, m));
  expect_solved(ksp, a);
  EXPECT_EQ(factor_error(factors_of(ksp)), MAT_FACTOR_NOERROR);
}

/// An empty column can be seen in the pattern.
TEST(PetscFailure, StructurallySingular) {
  std::vector<BasicEntry<PetscScalar>> entries;
  for (const auto& e : mfs::test::entries_of(scalar_grid(8, 7)))
    if (e.column != 30) entries.push_back(e);
  const Sparse a = from_entries(56, entries);
  const Krylov ksp = direct_solver();
  const Matrix m = petsc_matrix(a);
  good(KSPSetOperators(ksp, m, m));
  solved(ksp, std::vector<PetscScalar>(56, 1.0));
  EXPECT_EQ(reason_of(ksp), KSP_DIVERGED_PC_FAILED);
  EXPECT_EQ(factor_error(factors_of(ksp)), MAT_FACTOR_NUMERIC_ZEROPIVOT);
}

TEST(PetscFailure, ErrorsWhereTheyAreAskedFor) {
  for (const Case& given : cases()) {
    SCOPED_TRACE(given.name);
    const Krylov ksp = direct_solver();
    good(KSPSetErrorIfNotConverged(ksp, PETSC_TRUE));
    const Matrix m = petsc_matrix(given.singular);
    good(KSPSetOperators(ksp, m, m));
    const PetscErrorCode code = KSPSetUp(ksp);
    EXPECT_TRUE(code == PETSC_ERR_MAT_LU_ZRPVT || code == PETSC_ERR_FP) << code;
    EXPECT_THAT(error_text(), AllOf(HasSubstr("MFS: "), HasSubstr("row " + std::to_string(given.rows[0]))));
  }
}

TEST(PetscFailure, ManyRightHandSidesOfASingularMatrix) {
  const Sparse a = with_equal_rows(0);
  const Krylov ksp = direct_solver();
  const Matrix m = petsc_matrix(a);
  good(KSPSetOperators(ksp, m, m));
  good(KSPSetUp(ksp));
  Matrix B, X;
  good(MatCreateSeqDense(PETSC_COMM_SELF, 56, 3, nullptr, B.place()));
  good(MatCreateSeqDense(PETSC_COMM_SELF, 56, 3, nullptr, X.place()));
  good(MatMatSolve(factors_of(ksp), B, X));
  const PetscScalar* x = nullptr;
  good(MatDenseGetArrayRead(X, &x));
  for (int k = 0; k < 3 * 56; ++k) EXPECT_FALSE(std::isfinite(std::abs(x[k]))) << k;
  good(MatDenseRestoreArrayRead(X, &x));
}

TEST(PetscFailure, RightHandSideThatIsNotANumber) {
  const Sparse a = scalar_grid(8, 7);
  const Matrix m = petsc_matrix(a);
  std::vector<PetscScalar> b = right_hand_sides(a, 1, a.n, 3);
  b[9] = std::numeric_limits<double>::quiet_NaN();
  const Krylov ksp = direct_solver(KSPGMRES);
  good(KSPSetOperators(ksp, m, m));
  solved(ksp, b);
  EXPECT_EQ(reason_of(ksp), KSP_DIVERGED_NANORINF);
  EXPECT_EQ(factor_error(factors_of(ksp)), MAT_FACTOR_NOERROR) << "the factors are good";
  const Vector rhs = petsc_vector(b), x = petsc_vector(b);
  good(MatSolve(factors_of(ksp), rhs, x));
  EXPECT_FALSE(std::isfinite(std::abs(entries_of(x)[0])));
  expect_solved(ksp, a);
}

TEST(PetscFailure, AccuracyThatIsNotReached) {
  const Option tolerance("-mat_mfs_tolerance", "1e-30");
  const Sparse a = scalar_grid(8, 7);
  const Matrix m = petsc_matrix(a);
  const std::vector<PetscScalar> b = right_hand_sides(a, 1, a.n, 3);
  for (const KSPType type : {KSPPREONLY, KSPGMRES}) {
    const Krylov ksp = direct_solver(type);
    good(KSPSetOperators(ksp, m, m));
    EXPECT_FALSE(std::isfinite(std::abs(solved(ksp, b)[0])) && reason_of(ksp) > 0);
    EXPECT_EQ(factor_error(factors_of(ksp)), MAT_FACTOR_NUMERIC_ZEROPIVOT);
  }
  const Krylov strict = direct_solver();
  good(KSPSetErrorIfNotConverged(strict, PETSC_TRUE));
  good(KSPSetOperators(strict, m, m));
  const Vector rhs = petsc_vector(b), x = petsc_vector(b);
  EXPECT_EQ(KSPSolve(strict, rhs, x), PETSC_ERR_CONV_FAILED);
  EXPECT_THAT(error_text(), HasSubstr("backward error"));
}

/// Bytes of address space that this process has now.
rlim_t address_space() {
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  statm >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

TEST(PetscFailure, OutOfMemory) {
  const Sparse a = scalar_grid(300, 300);
  const Matrix m = petsc_matrix(a);
  const Krylov ksp = direct_solver();
  good(KSPSetOperators(ksp, m, m));
  rlimit before{};
  getrlimit(RLIMIT_AS, &before);
  const rlimit little{address_space() + (std::uint64_t{24} << 20), before.rlim_max};
  setrlimit(RLIMIT_AS, &little);
  const PetscErrorCode code = KSPSetUp(ksp);
  setrlimit(RLIMIT_AS, &before);
  good(code);
  EXPECT_EQ(factor_error(factors_of(ksp)), MAT_FACTOR_OUTMEMORY);
  EXPECT_EQ(failed_reason(ksp), PC_FACTOR_OUTMEMORY);
}

TEST(PetscFailure, SystemsAreLeftInFiles) {
  char folder[] = "/tmp/mfs_petsc_XXXXXX";
  ASSERT_NE(mkdtemp(folder), nullptr);
  const std::string prefix = std::string(folder) + "/left";
  const Option dump("-mat_mfs_dump_prefix", prefix);
  const Krylov ksp = direct_solver();
  const Matrix m = petsc_matrix(with_equal_rows(0));
  good(KSPSetOperators(ksp, m, m));
  good(KSPSetUp(ksp));
  EXPECT_TRUE(std::ifstream(prefix + "_A.mtx").good());
  for (const char* end : {"_A.mtx", "_b.mtx"}) std::remove((prefix + end).c_str());
  std::remove(folder);
}

}  // namespace
}  // namespace mfs::test
