// The options -mat_mfs_...: what they ask for is done, and what makes no sense is refused.
#include <gmock/gmock.h>

#include <algorithm>

#include "mfs_petsc.h"
#include "test/petsc/factored.hpp"

namespace mfs::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// The view of factors that were made with the present options.
std::string view_with_options(const char* prefix = nullptr) {
  const Krylov ksp = direct_solver(KSPPREONLY, prefix);
  const Sparse a = scalar_grid(13, 9);
  const Matrix m = petsc_matrix(a);
  good(KSPSetOperators(ksp, m, m));
  expect_solved(ksp, a);
  return view_of(factors_of(ksp));
}

TEST(PetscOptions, EachIsTaken) {
  const struct {
    const char *name, *value, *seen;
  } all[] = {{"backend", "serial", "backend serial, threads 1"},
             {"threads", "3", "threads 3"},
             {"analysis_threads", "2", "threads of the analysis 2"},
             {"matching", "always", "matching always"},
             {"scaling", "no", "scaling no"},
             {"max_block_size", "64", "max block size 64"},
             {"leaf_size", "17", "leaf size 17"},
             {"precision", "single", "precision of the factors single"},
             {"pivot_tolerance", "1e-9", "pivot tolerance 1e-09"},
             {"max_reanalyses", "2", "max reanalyses 2"},
             {"tolerance", "1e-13", "tolerance 1e-13"},
             {"max_refinement_steps", "7", "max refinement steps 7"},
             {"row_floor", "0.25", "row floor 0.25"},
             {"solve_singular", "yes", "solve singular yes"},
             {"dump_prefix", "/tmp/none", "dump prefix /tmp/none"}};
  const std::string without = view_with_options();
  for (const auto& option : all) {
    const Option given(std::string("-mat_mfs_") + option.name, option.value);
    EXPECT_THAT(view_with_options(), HasSubstr(option.seen)) << option.name;
    EXPECT_THAT(without, testing::Not(HasSubstr(option.seen))) << option.name;
  }
}

TEST(PetscOptions, PrefixesAreKept) {
  const Option mine("-inner_mat_mfs_threads", "3"), other("-mat_mfs_threads", "2");
  EXPECT_THAT(view_with_options("inner_"), HasSubstr("threads 3"));
  EXPECT_THAT(view_with_options(), HasSubstr("threads 2"));
}

TEST(PetscOptions, ThreadsThatNobodyChose) {
  mfs::set_default_threads(3);
  EXPECT_THAT(view_with_options(), HasSubstr("threads 3"));
  mfs::set_default_threads(0);
}

/// What KSPSetUp answers.
PetscErrorCode set_up(const char* prefix = nullptr) {
  const Krylov ksp = direct_solver(KSPPREONLY, prefix);
  const Matrix m = petsc_matrix(scalar_grid(4, 3));
  good(KSPSetOperators(ksp, m, m));
  return KSPSetUp(ksp);
}

TEST(PetscOptions, WrongValuesAreRefused) {
  const std::pair<const char*, const char*> wrong[] = {
      {"backend", "gpu"},         {"threads", "-1"},
      {"threads", "513"},         {"threads", "many"},
      {"threads", "2.5"},         {"analysis_threads", "-1"},
      {"matching", "perhaps"},    {"scaling", "maybe"},
      {"max_block_size", "0"},    {"leaf_size", "0"},
      {"precision", "double"},    {"pivot_tolerance", "-1"},
      {"pivot_tolerance", "1"},   {"max_reanalyses", "-1"},
      {"tolerance", "-1e-12"},    {"tolerance", "2"},
      {"tolerance", "nan"},       {"tolerance", "small"},
      {"row_floor", "1.5"},       {"max_refinement_steps", "-1"},
      {"solve_singular", "maybe"}};
  for (const auto& [name, value] : wrong) {
    const Option option(std::string("-mat_mfs_") + name, value);
    EXPECT_NE(set_up(), 0) << name << " " << value;
    // What is no number PETSc itself refuses, without the name.
    EXPECT_THAT(error_text(), testing::AnyOf(HasSubstr(name), HasSubstr(value))) << name << " " << value;
  }
  EXPECT_EQ(set_up(), 0);
  const std::vector<Backend> there = backends();
  if (std::find(there.begin(), there.end(), Backend::cuda) != there.end()) return;
  const Option device("-mat_mfs_backend", "cuda");
  EXPECT_EQ(set_up(), PETSC_ERR_LIB) << "no device, or a library without that backend";
}

TEST(PetscOptions, WithoutASymbolicPhaseThereIsNoNumericOne) {
  const Option option("-mat_mfs_threads", "-1");
  MatFactorInfo info;
  Matrix F;
  const Matrix m = petsc_matrix(scalar_grid(4, 3));
  good(MatFactorInfoInitialize(&info));
  good(MatGetFactor(m, "mfs", MAT_FACTOR_LU, F.place()));
  EXPECT_EQ(MatLUFactorNumeric(F, m, &info), PETSC_ERR_SUP);
  EXPECT_EQ(MatLUFactorSymbolic(F, m, nullptr, nullptr, &info), PETSC_ERR_ARG_OUTOFRANGE);
  EXPECT_EQ(MatLUFactorNumeric(F, m, &info), PETSC_ERR_SUP);
}

TEST(PetscOptions, UnknownNamesAreRefused) {
  const Option misspelt("-mat_mfs_treads", "2");
  EXPECT_EQ(set_up(), PETSC_ERR_ARG_UNKNOWN_TYPE);
  EXPECT_THAT(error_text(), HasSubstr("-mat_mfs_treads"));
  EXPECT_EQ(set_up("inner_"), 0) << "it is not of this solver";
  const Option inner("-inner_mat_mfs_treads", "2");
  EXPECT_EQ(set_up("inner_"), PETSC_ERR_ARG_UNKNOWN_TYPE);
  EXPECT_THAT(error_text(), HasSubstr("-inner_mat_mfs_treads"));
}

TEST(PetscOptions, RegisteringAgainIsNoHarm) {
  good(MatSolverTypeRegister_MFS());
  EXPECT_THAT(view_with_options(), HasSubstr("MFS"));
}

}  // namespace
}  // namespace mfs::test
