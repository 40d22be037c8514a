// The program's ways into Matrix Market files: square matrices and right-hand sides, real and complex.
#include <complex>
#include <string>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "solver/program/matrix_market.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::io;
using testing::ElementsAre;
using Complex = std::complex<double>;

constexpr const char* kReal = "%%MatrixMarket matrix coordinate real general\n";
constexpr const char* kArray = "%%MatrixMarket matrix array real general\n";

TEST(MatrixMarketForTheSolver, SquareMatrices) {
  const TemporaryFolder folder;
  const std::string path = folder.write("a.mtx", kArray + std::string("2 2\n1\n2\n0\n4\n"));
  const auto a = std::get<CsrMatrix<double>>(read_square_matrix(path));
  EXPECT_THAT(a.offsets, ElementsAre(0, 2, 4));
  EXPECT_THAT(a.column_indices, ElementsAre(0, 1, 0, 1));
  EXPECT_THAT(a.values, ElementsAre(1, 0, 2, 4));
}

std::string file_refusal(const std::string& text, SquareMatrix (*read)(const std::string&, int)) {
  const TemporaryFolder folder;
  const std::string path = folder.write("a.mtx", text);
  try {
    read(path, 1);
  } catch (const mfs::InvalidInput& e) {
    return std::string(e.what()).substr(path.size() + 2);
  }
  return "accepted";
}

TEST(MatrixMarketForTheSolver, OthersAreRefusedByTheirHeader) {
  const std::string complex = "%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1 1\n";
  const std::string pattern = "%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n";
  const std::string wide = kReal + std::string("2 3 0\n");
  EXPECT_EQ(file_refusal(complex, read_square_matrix), "accepted");
  EXPECT_EQ(file_refusal(pattern, read_square_matrix), "line 2: the file is a pattern: it has no values");
  EXPECT_EQ(file_refusal(wide, read_square_matrix), "line 2: the matrix is not square: 2 x 3");
  EXPECT_EQ(file_refusal(wide, read_square_pattern), "line 2: the matrix is not square: 2 x 3");
  EXPECT_EQ(file_refusal(complex, read_square_pattern), "accepted");
  EXPECT_EQ(file_refusal(pattern, read_square_pattern), "accepted");
}

TEST(MatrixMarketForTheSolver, ComplexMatrices) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    return std::get<CsrMatrix<Complex>>(read_square_matrix(folder.write("a.mtx", text)));
  };
  const CsrMatrix<Complex> sparse =
      read("%%MatrixMarket matrix coordinate complex symmetric\n2 2 2\n1 1 1 2\n2 1 3 4\n");
  EXPECT_THAT(sparse.offsets, ElementsAre(0, 2, 3));
  EXPECT_THAT(sparse.column_indices, ElementsAre(0, 1, 0));
  EXPECT_THAT(sparse.values, ElementsAre(Complex(1, 2), Complex(3, 4), Complex(3, 4)));
  const CsrMatrix<Complex> dense =
      read("%%MatrixMarket matrix array complex general\n2 2\n1 0\n2 0\n0 3\n4 0\n");
  EXPECT_THAT(dense.column_indices, ElementsAre(0, 1, 0, 1));
  EXPECT_THAT(dense.values, ElementsAre(Complex(1, 0), Complex(0, 3), Complex(2, 0), Complex(4, 0)));
}

TEST(MatrixMarketForTheSolver, APatternIsARealMatrixWithoutValues) {
  const TemporaryFolder folder;
  const auto a = std::get<CsrMatrix<double>>(read_square_pattern(
      folder.write("a.mtx", "%%MatrixMarket matrix coordinate pattern symmetric\n2 2 2\n1 1\n2 1\n")));
  EXPECT_THAT(a.offsets, ElementsAre(0, 2, 3));
  EXPECT_TRUE(a.values.empty());
}

TEST(MatrixMarketForTheSolver, RightHandSides) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text) {
    const std::string path = folder.write("b.mtx", text);
    try {
      read_right_hand_sides<double>(path, 2);
    } catch (const mfs::InvalidInput& e) {
      return std::string(e.what()).substr(path.size() + 2);
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused(kArray + std::string("2 1\n1\n2\n")), "accepted");
  EXPECT_EQ(refused(kArray + std::string("3 1\n1\n2\n3\n")),
            "line 2: right-hand sides of 2 rows are needed, the file holds 3 x 1");
  EXPECT_EQ(refused(kArray + std::string("2 0\n")),
            "line 2: right-hand sides of 2 rows are needed, the file holds 2 x 0");
  EXPECT_EQ(refused(kReal + std::string("2 1 0\n")), "line 2: right-hand sides are read from an array file");
  EXPECT_EQ(refused("%%MatrixMarket matrix array complex general\n2 1\n1 1\n2 2\n"),
            "line 2: the right-hand sides are complex, the matrix is real");
}

TEST(MatrixMarketForTheSolver, RightHandSidesOfAComplexMatrix) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    return read_right_hand_sides<Complex>(folder.write("b.mtx", text), 2).values;
  };
  EXPECT_THAT(read(kArray + std::string("2 1\n1\n-2\n")), ElementsAre(Complex(1, 0), Complex(-2, 0)));
  EXPECT_THAT(read("%%MatrixMarket matrix array complex general\n2 1\n1 2\n3 4\n"),
              ElementsAre(Complex(1, 2), Complex(3, 4)));
}

}  // namespace
