// mfs/mfs.h against the C++ class: the same bits for all four kinds of numbers and both widths of indices,
// the last error of each thread, and options and figures by name.
#include <gmock/gmock.h>

#include <string>
#include <thread>
#include <vector>

#include <mfs/mfs.h>

#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

template <class Scalar>
constexpr int kKind = std::is_same_v<Scalar, float>                 ? MFS_FLOAT
                      : std::is_same_v<Scalar, double>              ? MFS_DOUBLE
                      : std::is_same_v<Scalar, std::complex<float>> ? MFS_COMPLEX_FLOAT
                                                                    : MFS_COMPLEX_DOUBLE;

template <class Scalar>
class FromC : public testing::Test {};
using Scalars = testing::Types<float, double, std::complex<float>, std::complex<double>>;
TYPED_TEST_SUITE(FromC, Scalars);

template <class Scalar, class Index>
void compare_with_class(const BasicSparseMatrix<Scalar>& a) {
  const std::vector<Index> offsets(a.offsets.begin(), a.offsets.end()),
      columns(a.columns.begin(), a.columns.end());
  constexpr std::int64_t kColumns = 3;
  const std::int64_t ldb = a.n + 2, ldx = a.n + 1;
  const std::vector<Scalar> b = right_hand_sides(a, kColumns, ldb, 5);
  Options options;
  options.threads = 2;
  BasicSolver<Scalar> solver(options);
  solver.factor({a.n, a.n, offsets.data(), columns.data(), a.values.data()});
  mfs_solver* handle = nullptr;
  ASSERT_EQ(mfs_create(kKind<Scalar>, 8 * sizeof(Index), &handle), MFS_OK);
  ASSERT_EQ(mfs_set_option(handle, "threads", "2"), MFS_OK);
  ASSERT_EQ(mfs_factor(handle, a.n, offsets.data(), columns.data(), a.values.data()), MFS_OK);
  for (const bool transposed : {false, true}) {
    std::vector<Scalar> x(static_cast<std::size_t>(kColumns * ldx)), expected = x;
    const auto call = transposed ? &BasicSolver<Scalar>::solve_transpose : &BasicSolver<Scalar>::solve;
    (solver.*call)(b.data(), expected.data(), kColumns, ldb, ldx);
    ASSERT_EQ((transposed ? mfs_solve_transpose : mfs_solve)(handle, b.data(), x.data(), kColumns, ldb, ldx),
              MFS_OK);
    EXPECT_EQ(x, expected);
  }
  double condition = 0, phase[2], log_abs = 0;
  EXPECT_EQ(mfs_condition_estimate(handle, &condition), MFS_OK);
  EXPECT_EQ(condition, solver.condition_estimate());
  EXPECT_EQ(mfs_determinant(handle, phase, &log_abs), MFS_OK);
  const Determinant<Scalar> determinant = solver.determinant();
  EXPECT_EQ(phase[0], std::real(determinant.phase));
  EXPECT_EQ(phase[1], std::imag(determinant.phase));
  EXPECT_EQ(log_abs, determinant.log_abs);
  mfs_destroy(handle);
}

TYPED_TEST(FromC, IsTheClass) {
  const BasicSparseMatrix<TypeParam> a = in_scalar<TypeParam>(grid_2d(13, 11));
  compare_with_class<TypeParam, std::int32_t>(a);
  compare_with_class<TypeParam, std::int64_t>(a);
}

TEST(LastError, IsEachThreadsOwn) {
  ASSERT_EQ(mfs_create(MFS_DOUBLE, 7, nullptr), MFS_INVALID_INPUT);
  std::thread([] {
    const char* text = nullptr;
    EXPECT_EQ(mfs_last_error(&text, nullptr, nullptr), MFS_OK);
    EXPECT_STREQ(text, "");
    EXPECT_EQ(mfs_set_default_threads(1000), MFS_INVALID_INPUT);
  }).join();
  const char* text = nullptr;
  EXPECT_EQ(mfs_last_error(&text, nullptr, nullptr), MFS_INVALID_INPUT);
  EXPECT_STREQ(text, "solver: is NULL");
}

TEST(ByName, EveryOptionIsSetFromText) {
  const std::vector<std::pair<std::string, std::string>> texts = {{"backend", "serial"},
                                                                  {"memory_limit", "8000000000"},
                                                                  {"threads", "3"},
                                                                  {"analysis_threads", "2"},
                                                                  {"matching", "never"},
                                                                  {"scaling", "no"},
                                                                  {"max_block_size", "64"},
                                                                  {"leaf_size", "7"},
                                                                  {"separator_trials", "2"},
                                                                  {"separator_refinement", "3"},
                                                                  {"dense_row", "4.5"},
                                                                  {"seed", "-6"},
                                                                  {"precision", "single"},
                                                                  {"pivot_tolerance", "1e-3"},
                                                                  {"max_reanalyses", "1"},
                                                                  {"tolerance", "1e-9"},
                                                                  {"max_refinement_steps", "4"},
                                                                  {"row_floor", "0.5"},
                                                                  {"solve_singular", "yes"},
                                                                  {"out_of_core_dir", "/tmp/c d"},
                                                                  {"dump_prefix", "/tmp/a b"}};
  Options o;
  std::vector<std::string> names;
  for (const auto& [name, text] : texts) {
    names.push_back(name);
    set_option(o, name, text);
  }
  EXPECT_EQ(names, option_names());
  EXPECT_TRUE(o.backend == Backend::serial && o.threads == 3 && o.analysis.threads == 2);
  EXPECT_EQ(o.memory_limit, 8000000000);
  EXPECT_EQ(o.out_of_core_dir, "/tmp/c d");
  EXPECT_TRUE(o.analysis.matching == Matching::never && !o.analysis.scaling &&
              o.analysis.max_block_size == 64);
  EXPECT_TRUE(o.analysis.leaf_size == 7 && o.analysis.separator_trials == 2);
  EXPECT_TRUE(o.analysis.separator_refinement == 3 && o.analysis.dense_row == 4.5 && o.analysis.seed == -6);
  EXPECT_TRUE(o.factor.precision == Precision::single && o.factor.pivot_tolerance == 1e-3);
  EXPECT_TRUE(o.factor.max_reanalyses == 1 && o.solve.tolerance == 1e-9 && o.solve.row_floor == 0.5);
  EXPECT_TRUE(o.solve.max_refinement_steps == 4 && o.solve.solve_singular && o.dump_prefix == "/tmp/a b");
}

TEST(ByName, AWrongTextChangesNothing) {
  Options o;
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{{"threads", ""},
                                                                                   {"threads", " 1"},
                                                                                   {"threads", "99999999999"},
                                                                                   {"tolerance", "1e-9 "},
                                                                                   {"tolerance", "1,5"},
                                                                                   {"scaling", "maybe"},
                                                                                   {"precision", "Single"},
                                                                                   {"", "1"}}) {
    try {
      set_option(o, name, text);
      ADD_FAILURE() << name << " = " << text;
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.argument(), name);
    }
  }
  EXPECT_TRUE(o.threads == 0 && o.solve.tolerance == 0 && o.analysis.scaling);
}

TEST(ByName, FiguresAreThoseOfTheReport) {
  Report r;
  r.n = 3, r.nnz_factor = 11, r.flops = {1, 2, 4}, r.flops_used = {8, 0, 0}, r.rung = Rung::krylov;
  r.backward_error = 0.5, r.time_solve = 0.25, r.matched = true, r.partial = true, r.bytes_out = 17;
  std::map<std::string, double> by_name;
  for (const Figure& figure : figures(r)) by_name[figure.name] = figure.value;
  EXPECT_EQ(by_name.size(), figures(r).size()) << "a name of its own for each";
  EXPECT_EQ(by_name["n"], 3);
  EXPECT_EQ(by_name["nnz_factor"], 11);
  EXPECT_EQ(by_name["flops"], 7);
  EXPECT_EQ(by_name["flops_trsm"], 2);
  EXPECT_EQ(by_name["flops_used"], 8);
  EXPECT_EQ(by_name["rung"], static_cast<double>(Rung::krylov));
  EXPECT_EQ(by_name["matched"], 1);
  EXPECT_EQ(by_name["backward_error"], 0.5);
  EXPECT_EQ(by_name["partial"], 1);
  EXPECT_EQ(by_name["bytes_out"], 17);
  EXPECT_EQ(by_name["time_solve"], 0.25);
}

TEST(FromC, OptionsThatDoNotGoTogetherAreRefusedByTheFirstPhase) {
  mfs_solver* solver = nullptr;
  ASSERT_EQ(mfs_create(MFS_DOUBLE, 32, &solver), MFS_OK);
  ASSERT_EQ(mfs_set_option(solver, "max_block_size", "64"), MFS_OK);
  ASSERT_EQ(mfs_set_option(solver, "backend", "kokkos"), MFS_OK);
  const std::int32_t offsets[] = {0, 1}, columns[] = {0};
  const double values[] = {1};
  EXPECT_EQ(mfs_factor(solver, 1, offsets, columns, values), MFS_INVALID_INPUT);
  mfs_destroy(solver);
}

}  // namespace
}  // namespace mfs::test
