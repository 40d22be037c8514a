// What comes out of MatSolve and its kin, and when a pattern is analysed.
#include <set>

#include <gmock/gmock.h>

#include "test/petsc/factored.hpp"

namespace mfs::test {
namespace {

using testing::HasSubstr;

Matrix factored(Mat a) {
  MatFactorInfo info;
  Matrix F;
  good(MatFactorInfoInitialize(&info));
  good(MatGetFactor(a, "mfs", MAT_FACTOR_LU, F.place()));
  good(MatLUFactorSymbolic(F, a, nullptr, nullptr, &info));
  good(MatLUFactorNumeric(F, a, &info));
  EXPECT_EQ(factor_error(F), MAT_FACTOR_NOERROR);
  return F;
}

std::vector<Sparse> systems() {
  return {scalar_grid(13, 9), in_scalar<PetscScalar>(random_diagonally_dominant(300, 5, 4)),
          in_scalar<PetscScalar>(arrow(80, 2)), from_entries<PetscScalar>(2, {{0, 1, 3.0}, {1, 0, -2.0}})};
}

TEST(PetscSolve, PlainAndTransposed) {
  for (const Sparse& a : systems()) {
    const Matrix m = petsc_matrix(a), F = factored(m);
    for (const bool transpose : {false, true}) {
      const Sparse& matrix = transpose ? transposed(a) : a;
      const std::vector<PetscScalar> b = right_hand_sides(matrix, 1, a.n, 5);
      const Vector rhs = petsc_vector(b), x = petsc_vector(std::vector<PetscScalar>(b.size()));
      good(transpose ? MatSolveTranspose(F, rhs, x) : MatSolve(F, rhs, x));
      EXPECT_LE(backward_error(matrix, b, entries_of(x)), kGood) << a.n << " " << transpose;
      const Vector y = petsc_vector(b), sum = petsc_vector(std::vector<PetscScalar>(b.size()));
      if (transpose) continue;
      good(MatSolveAdd(F, rhs, y, sum));
      good(VecAXPY(sum, -1.0, y));
      good(VecAXPY(sum, -1.0, x));
      PetscReal norm = 1, size = 0;
      good(VecNorm(sum, NORM_INFINITY, &norm));
      good(VecNorm(x, NORM_INFINITY, &size));
      EXPECT_LE(norm, 1e-14 * (1 + size));
    }
  }
}

/// Columns with a distance of their own, in `storage`, which stays the caller's.
Matrix dense(std::int64_t n, std::int64_t columns, std::int64_t ld, std::vector<PetscScalar>& storage) {
  Matrix m;
  good(MatCreateSeqDense(PETSC_COMM_SELF, static_cast<PetscInt>(n), static_cast<PetscInt>(columns),
                         storage.data(), m.place()));
  good(MatDenseSetLDA(m, static_cast<PetscInt>(ld)));
  return m;
}

TEST(PetscSolve, ManyRightHandSides) {
  for (const Sparse& a : systems()) {
    const Matrix m = petsc_matrix(a), F = factored(m);
    const std::int64_t columns = 19, ldb = a.n + 3, ldx = a.n + 1;
    for (const bool transpose : {false, true}) {
      const Sparse& matrix = transpose ? transposed(a) : a;
      std::vector<PetscScalar> b = right_hand_sides(matrix, columns, ldb, 6);
      const std::vector<PetscScalar> before = b;
      std::vector<PetscScalar> x(static_cast<std::size_t>(ldx * columns), PetscScalar(7));
      const Matrix B = dense(a.n, columns, ldb, b), X = dense(a.n, columns, ldx, x);
      good(transpose ? MatMatSolveTranspose(F, B, X) : MatMatSolve(F, B, X));
      EXPECT_LE(worst_error(matrix, before, ldb, x, ldx, columns), kGood) << a.n << " " << transpose;
      EXPECT_EQ(x[static_cast<std::size_t>(a.n)], PetscScalar(7)) << "between the columns";
      if (transpose) continue;
      good(MatMatSolve(F, B, B));  // in place
      EXPECT_LE(worst_error(matrix, before, ldb, b, ldb, columns), kGood) << a.n;
    }
  }
}

TEST(PetscSolve, EmptyMatrix) {
  const Matrix m = petsc_matrix(Sparse{0, {0}, {}, {}}), F = factored(m);
  const Vector b = petsc_vector({}), x = petsc_vector({});
  good(MatSolve(F, b, x));
  good(MatSolveTranspose(F, b, x));
  EXPECT_THAT(view_of(F), HasSubstr("nothing analysed"));
  const Krylov ksp = direct_solver();
  good(KSPSetOperators(ksp, m, m));
  EXPECT_TRUE(solved(ksp, {}).empty());
  EXPECT_GT(reason_of(ksp), 0);
}

/// PETSc hands them to the solver of MATSEQAIJ, from which they are derived.
TEST(PetscSolve, OtherFormsOfCompressedRows) {
  const Sparse a = scalar_grid(13, 9);
  for (const MatType type : {MATSEQAIJPERM, MATSEQAIJSELL, MATSEQAIJCRL}) {
    const Matrix rows = petsc_matrix(a);
    Matrix m;
    good(MatConvert(rows, type, MAT_INITIAL_MATRIX, m.place()));
    const Krylov ksp = direct_solver();
    good(KSPSetOperators(ksp, m, m));
    expect_solved(ksp, a);
    EXPECT_THAT(view_of(factors_of(ksp)), HasSubstr("MFS")) << type;
  }
}

TEST(PetscSolve, OtherShapesAndKindsAreRefused) {
  Matrix wide, F;
  good(MatCreateSeqAIJ(PETSC_COMM_SELF, 3, 4, 2, nullptr, wide.place()));
  good(MatAssemblyBegin(wide, MAT_FINAL_ASSEMBLY));
  good(MatAssemblyEnd(wide, MAT_FINAL_ASSEMBLY));
  EXPECT_EQ(MatGetFactor(wide, "mfs", MAT_FACTOR_LU, F.place()), PETSC_ERR_ARG_SIZ);
  const Matrix square = petsc_matrix(scalar_grid(4, 3));
  EXPECT_EQ(MatGetFactor(square, "mfs", MAT_FACTOR_ILU, F.place()), PETSC_ERR_MISSING_FACTOR);
  Matrix blocks;
  good(MatConvert(square, MATSEQBAIJ, MAT_INITIAL_MATRIX, blocks.place()));
  EXPECT_EQ(MatGetFactor(blocks, "mfs", MAT_FACTOR_LU, F.place()), PETSC_ERR_MISSING_FACTOR);
  PetscBool there = PETSC_FALSE;
  good(MatGetFactorAvailable(square, "petsc", MAT_FACTOR_LU, &there));
  EXPECT_TRUE(there) << "the other solvers are still known";
}

// ---- patterns ----

TEST(PetscPattern, NewValuesNeedNoAnalysis) {
  const Krylov ksp = direct_solver();
  Sparse a = scalar_grid(13, 9);
  const Matrix m = petsc_matrix(a);
  good(KSPSetOperators(ksp, m, m));
  for (int k = 1; k <= 4; ++k) {
    for (PetscScalar& value : a.values) value *= 1.25;
    set_values(m, a);
    expect_solved(ksp, a);
    expect_solved(ksp, a);  // nothing new: nothing is factored
    EXPECT_THAT(view_of(factors_of(ksp)), HasSubstr("analyses 1, factorizations " + std::to_string(k) + ","));
  }
}

TEST(PetscPattern, AnotherOneIsAnalysed) {
  const Krylov ksp = direct_solver();
  Sparse a = scalar_grid(13, 9);
  const Matrix m = petsc_matrix(a);
  good(KSPSetOperators(ksp, m, m));
  expect_solved(ksp, a);
  // The same matrix grows an entry.
  good(MatSetOption(m, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  std::vector<BasicEntry<PetscScalar>> entries = mfs::test::entries_of(a);
  entries.push_back({3, 80, PetscScalar(0.5)});
  a = from_entries_summed(a.n, entries);
  set_values(m, a);
  expect_solved(ksp, a);
  // A matrix of another pattern, of the same number of entries.
  entries.back().column = 81;
  const Sparse other = from_entries_summed(a.n, entries);
  const Matrix another = petsc_matrix(other);
  good(KSPSetOperators(ksp, another, another));
  expect_solved(ksp, other);
}

TEST(PetscPattern, ReusedOrderingKeepsTheAnalysisWhereItServes) {
  const Option reuse("-pc_factor_reuse_ordering", "1");
  const Krylov ksp = direct_solver();
  Sparse a = scalar_grid(13, 9);
  std::vector<Matrix> matrices;
  std::set<PetscObjectId> factors;
  for (int k = 0; k < 3; ++k) {
    for (PetscScalar& value : a.values) value *= 1.25;
    matrices.push_back(petsc_matrix(a));
    good(KSPSetOperators(ksp, matrices.back(), matrices.back()));
    expect_solved(ksp, a);
    PetscObjectId id = 0;
    good(PetscObjectGetId((PetscObject)factors_of(ksp), &id));
    factors.insert(id);
  }
  if (factors.size() > 1)
    GTEST_SKIP() << "this PETSc makes a new factor object for each matrix, as 3.25 does";
  EXPECT_THAT(view_of(factors_of(ksp)), HasSubstr("analyses 1, factorizations 3,"));
  const Sparse other = in_scalar<PetscScalar>(random_diagonally_dominant(a.n, 3, 1));
  const Matrix another = petsc_matrix(other);
  good(KSPSetOperators(ksp, another, another));
  expect_solved(ksp, other);
  EXPECT_THAT(view_of(factors_of(ksp)), HasSubstr("analyses 2, factorizations 4,"));
}

TEST(PetscPattern, WithoutASymbolicPhaseAnotherOneIsRefused) {
  MatFactorInfo info;
  good(MatFactorInfoInitialize(&info));
  const Sparse a = scalar_grid(13, 9);
  const Matrix m = petsc_matrix(a), F = factored(m);
  std::vector<BasicEntry<PetscScalar>> entries = mfs::test::entries_of(a);
  entries.push_back({77, 3, PetscScalar(0.5)});
  const Matrix other = petsc_matrix(from_entries_summed(a.n, entries));
  EXPECT_EQ(MatLUFactorNumeric(F, other, &info), PETSC_ERR_ARG_WRONGSTATE);
  EXPECT_THAT(error_text(), testing::AllOf(HasSubstr("MFS"), HasSubstr("row 77")));
  // Who does not look gets no solution of the matrix before.
  const Vector b = petsc_vector(right_hand_sides(a, 1, a.n, 5)),
               x = petsc_vector(std::vector<PetscScalar>(a.n));
  good(MatSolve(F, b, x));
  EXPECT_FALSE(std::isfinite(std::abs(entries_of(x)[0])));
  good(MatLUFactorNumeric(F, m, &info));
  good(MatSolve(F, b, x));
  EXPECT_LE(backward_error(a, entries_of(b), entries_of(x)), kGood);
}

// ---- what is told ----

TEST(PetscView, ParametersAndFigures) {
  const Krylov ksp = direct_solver();
  const Sparse a = scalar_grid(13, 9);
  const Matrix m = petsc_matrix(a);
  good(KSPSetOperators(ksp, m, m));
  expect_solved(ksp, a);
  const std::string text = text_of(PETSC_COMM_SELF, [&](PetscViewer viewer) { return KSPView(ksp, viewer); });
  for (const char* part : {"package used to perform factorization: mfs", "MFS 0.", "backend openmp, threads ",
                           "precision of the factors automatic", "nonzeros of L and U", "backward error "})
    EXPECT_THAT(text, HasSubstr(part));
  MatInfo info;
  good(MatGetInfo(factors_of(ksp), MAT_LOCAL, &info));
  EXPECT_GE(info.nz_used, static_cast<double>(a.entries()));
  EXPECT_GE(info.fill_ratio_needed, 1.0);
  EXPECT_GT(info.memory, info.nz_used * sizeof(PetscScalar));
}

TEST(PetscView, LogsAmongTheInfoOfPetsc) {
  char folder[] = "/tmp/mfs_petsc_XXXXXX";
  ASSERT_NE(mkdtemp(folder), nullptr);
  const std::string path = std::string(folder) + "/info";
  good(PetscInfoAllow(PETSC_TRUE));
  good(PetscInfoSetFile(path.c_str(), "w"));
  {
    const Krylov ksp = direct_solver();
    const Sparse a = scalar_grid(13, 9);
    const Matrix m = petsc_matrix(a);
    good(KSPSetOperators(ksp, m, m));
    expect_solved(ksp, a);
  }
  good(PetscInfoAllow(PETSC_FALSE));
  good(PetscInfoSetFile(nullptr, nullptr));
  std::string text;
  for (const std::string& name : {path, path + ".0"})
    if (std::FILE* file = std::fopen(name.c_str(), "r")) {
      for (int c = 0; (c = std::fgetc(file)) != EOF;) text.push_back(static_cast<char>(c));
      std::fclose(file);
      std::remove(name.c_str());
    }
  std::remove(folder);
  EXPECT_THAT(text, HasSubstr("MFS: plan: "));
}

}  // namespace
}  // namespace mfs::test
