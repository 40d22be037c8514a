// Options::dump_prefix: a failing system is left in files that hold it to the last bit, the error says so,
// and whatever becomes of the files, it stays the error that it was.
#include <filesystem>

#include "solver/program/matrix_market.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/program/temporary_folder.hpp"

namespace mfs::test {
namespace {

using io::CsrMatrix;
using io::DenseMatrix;
using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

class FailingSystem : public testing::Test {
 protected:
  Options options() const {
    Options options = with_threads(1);
    options.dump_prefix = prefix();
    return options;
  }
  std::string prefix() const { return folder_.path("left"); }
  std::string matrix_file() const { return prefix() + "_A.mtx"; }
  std::string vector_file() const { return prefix() + "_b.mtx"; }
  template <class Scalar = double>
  CsrMatrix<Scalar> matrix() const {
    return std::get<CsrMatrix<Scalar>>(io::read_matrix_market(matrix_file()).content);
  }
  template <class Scalar = double>
  DenseMatrix<Scalar> vectors() const {
    return std::get<DenseMatrix<Scalar>>(io::read_matrix_market(vector_file()).content);
  }
  void expect_nothing_left() const {
    EXPECT_FALSE(std::filesystem::exists(matrix_file()));
    EXPECT_FALSE(std::filesystem::exists(vector_file()));
  }

 private:
  TemporaryFolder folder_;
};

// Rows 0 and 1 are the same; one entry comes in two parts, and a row is not sorted.
const SparseMatrix kSingular =
    from_entries(3, {{0, 1, 0.1}, {0, 0, 1}, {1, 0, 0.5}, {1, 1, 0.1}, {1, 0, 0.5}, {2, 2, 1.0 / 3}});

TEST_F(FailingSystem, OfASolve) {
  Solver solver(options());
  solver.factor(kSingular.view());
  const std::vector<double> b{1, 0.1, 1.0 / 3};
  std::vector<double> x(3, 5.0);
  const auto error = failure_of<SingularMatrix>([&] { solver.solve(b.data(), x.data()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), SingularMatrix::Kind::numerical);
  EXPECT_EQ(error->dependent_rows(), 1);
  EXPECT_THAT(error->what(),
              EndsWith("; the system was written to " + matrix_file() + " and " + vector_file()));
  EXPECT_THAT(matrix().offsets, ElementsAre(0, 2, 4, 5));
  EXPECT_THAT(matrix().column_indices, ElementsAre(0, 1, 0, 1, 2));
  EXPECT_THAT(matrix().values, ElementsAre(1, 0.1, 1, 0.1, 1.0 / 3));
  EXPECT_EQ(vectors().rows, 3);
  EXPECT_EQ(vectors().columns, 1);
  EXPECT_THAT(vectors().values, ElementsAreArray(b));
  EXPECT_THAT(text_of(vector_file()), HasSubstr("A x = b"));
  expect_usable(solver);
}

// The block that failed, with what its right-hand sides were, though those before it lie under their
// solutions.
TEST_F(FailingSystem, OfALaterBlockSolvedInPlaceAndTransposed) {
  const SparseMatrix a = grid_2d(6, 6);
  Options strict = options();
  strict.solve.tolerance = 1e-30;
  Solver solver(strict);
  solver.factor(a.view());
  const std::int64_t nrhs = 40, ld = a.n + 2;
  std::vector<double> b(static_cast<std::size_t>(ld * nrhs), 0.0), failed;
  for (std::int64_t i = 0; i < a.n; ++i) b[17 * ld + i] = std::sqrt(1.0 + static_cast<double>(i));
  for (std::int64_t j = 16; j < 32; ++j)
    for (std::int64_t i = 0; i < a.n; ++i) failed.push_back(b[j * ld + i]);
  failure_of<AccuracyNotReached>([&] { solver.solve_transpose(b.data(), b.data(), nrhs, ld, ld); });
  EXPECT_EQ(vectors().columns, 16);
  EXPECT_THAT(vectors().values, ElementsAreArray(failed));
  EXPECT_THAT(matrix().values, ElementsAreArray(a.values));
  EXPECT_THAT(text_of(vector_file()), HasSubstr("A^T x = b"));
}

TEST_F(FailingSystem, OfAnAnalysis) {
  const SparseMatrix a = from_entries(3, {{0, 0, 1}, {2, 2, 0.1}});
  Solver solver(options());
  auto error = failure_of<SingularMatrix>([&] { solver.analyze(a.view()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), SingularMatrix::Kind::structural);
  EXPECT_EQ(error->row(), 1);
  EXPECT_THAT(error->what(), EndsWith("; the system was written to " + matrix_file()));
  EXPECT_THAT(matrix().values, ElementsAre(1, 0.1));
  EXPECT_FALSE(std::filesystem::exists(vector_file()));

  CsrView<double> pattern = a.view();
  pattern.values = nullptr;
  failure_of<SingularMatrix>([&] { solver.analyze(pattern); });
  EXPECT_EQ(io::read_matrix_market(matrix_file()).header.field, io::Field::pattern);
}

TEST_F(FailingSystem, OfValuesThatAreNoNumbers) {
  SparseMatrix a = grid_2d(3, 3);
  Solver solver(options());
  solver.factor(a.view());
  a.values[5] = std::numeric_limits<double>::quiet_NaN();
  for (const int way : {0, 1, 2}) {
    const auto call = [&] {
      if (way == 0) solver.factor(a.view());
      if (way == 1) solver.refactor(a.view());
      if (way == 2) solver.refactor(a.values.data());
    };
    const auto error = failure_of<InvalidInput>(call);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->argument(), "values");
    EXPECT_GE(error->row(), 0);
    EXPECT_TRUE(std::isnan(matrix().values[5])) << way;
    EXPECT_EQ(matrix().values[6], a.values[6]);
    std::filesystem::remove(matrix_file());
  }
}

TEST_F(FailingSystem, OfComplexNumbers) {
  using Complex = std::complex<double>;
  const std::int32_t offsets[] = {0, 2, 4}, columns[] = {0, 1, 0, 1};
  const std::vector<Complex> values{{1, 1}, {0, 2}, {2, 2}, {0, 4}}, b{{0.1, 1}, {1, -3}};
  ComplexSolver solver(options());
  std::vector<Complex> x(2);
  failure_of<SingularMatrix>([&] {
    solver.factor({2, 2, offsets, columns, values.data()});
    solver.solve(b.data(), x.data());
  });
  EXPECT_THAT(matrix<Complex>().values, ElementsAreArray(values));
  EXPECT_THAT(vectors<Complex>().values, ElementsAreArray(b));
}

TEST_F(FailingSystem, ArraysThatAreNoMatrixAreNotFollowed) {
  SparseMatrix a = grid_2d(4, 4);
  a.columns[a.offsets[9] + 1] = 1 << 30;
  Solver solver(options());
  const auto error = failure_of<InvalidInput>([&] { solver.factor(a.view()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->argument(), "column_indices");
  EXPECT_EQ(error->row(), 9);
  EXPECT_THAT(error->what(), HasSubstr("; the system was not written: column_indices"));
  expect_nothing_left();
}

TEST_F(FailingSystem, FilesThatCannotBeWrittenHideNothing) {
  Options nowhere = options();
  nowhere.dump_prefix = "/no/such/folder/left";
  Solver solver(nowhere);
  solver.factor(kSingular.view());
  std::vector<double> b{1, 2, 3}, x(3);
  const auto error = failure_of<SingularMatrix>([&] { solver.solve(b.data(), x.data()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), SingularMatrix::Kind::numerical);
  EXPECT_THAT(error->what(),
              HasSubstr("; the system was not written: /no/such/folder/left_A.mtx: cannot be"));
  expect_usable(solver);
}

TEST_F(FailingSystem, NotForWhatIsNoFaultOfTheSystem) {
  const SparseMatrix a = grid_2d(3, 3);
  Solver solver(options());
  std::vector<double> b(9, std::numeric_limits<double>::infinity()), x(9);
  failure_of<StateError>([&] { solver.solve(b.data(), x.data()); });
  failure_of<StateError>([&] { solver.refactor(a.view()); });
  solver.factor(a.view());
  const auto error = failure_of<InvalidInput>([&] { solver.solve(b.data(), x.data()); });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), Not(HasSubstr("written")));
  expect_usable(solver);
  expect_nothing_left();
}

TEST_F(FailingSystem, NotWithoutBeingAsked) {
  Solver solver(with_threads(1));
  solver.factor(kSingular.view());
  std::vector<double> b{1, 2, 3}, x(3);
  const auto error = failure_of<SingularMatrix>([&] { solver.solve(b.data(), x.data()); });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), Not(HasSubstr("written")));
}

}  // namespace
}  // namespace mfs::test
