// Files of PETSc's binary viewer, put together here byte by byte.
#include <complex>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "solver/program/matrix_market.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::io;
using testing::ElementsAre;

constexpr std::int64_t kMatrix = 1211216, kVector = 1211214;

std::string big_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int k = bytes - 1; k >= 0; --k) text += static_cast<char>(value >> (8 * k) & 255);
  return text;
}
std::string integers(const std::vector<std::int64_t>& values, int bytes) {
  std::string text;
  for (const std::int64_t value : values) text += big_endian(static_cast<std::uint64_t>(value), bytes);
  return text;
}
std::string reals(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    text += big_endian(bits, 8);
  }
  return text;
}

// [ 2 1 ]
// [ 0 4 ]
std::string matrix(int bytes) {
  return integers({kMatrix, 2, 2, 3, 2, 1, 0, 1, 1}, bytes) + reals({2, 1, 4});
}

std::string refusal(const std::string& text) {
  const TemporaryFolder folder;
  try {
    read_square_matrix(folder.write("a", text));
  } catch (const mfs::InvalidInput& e) {
    return std::string(e.what()).substr(folder.path("a").size() + 2);
  }
  return "accepted";
}

TEST(PetscBinary, MatricesWithIntegersOfEitherLength) {
  const TemporaryFolder folder;
  for (const int bytes : {4, 8}) {
    const SquareMatrix read = read_square_matrix(folder.write("a", matrix(bytes)));
    const auto& a = std::get<CsrMatrix<double>>(read);
    EXPECT_EQ(a.rows, 2);
    EXPECT_EQ(a.columns, 2);
    EXPECT_THAT(a.offsets, ElementsAre(0, 2, 3));
    EXPECT_THAT(a.column_indices, ElementsAre(0, 1, 1));
    EXPECT_THAT(a.values, ElementsAre(2, 1, 4));
  }
}

TEST(PetscBinary, ComplexValues) {
  const TemporaryFolder folder;
  const std::string text = integers({kMatrix, 1, 1, 1, 1, 0}, 4) + reals({2, -3});
  const SquareMatrix read = read_square_matrix(folder.write("a", text));
  EXPECT_THAT(std::get<CsrMatrix<std::complex<double>>>(read).values,
              ElementsAre(std::complex<double>(2, -3)));
}

TEST(PetscBinary, VectorsAreRightHandSides) {
  const TemporaryFolder folder;
  for (const int bytes : {4, 8}) {
    const std::string text = integers({kVector, 3}, bytes) + reals({1, 0.5, -2});
    const DenseMatrix<double> b = read_right_hand_sides<double>(folder.write("b", text), 3);
    EXPECT_EQ(b.columns, 1);
    EXPECT_THAT(b.values, ElementsAre(1, 0.5, -2));
  }
}

// Every file that ends too early, and one byte too late.
TEST(PetscBinary, NoOtherLengthIsTaken) {
  for (const int bytes : {4, 8}) {
    const std::string whole = matrix(bytes);
    ASSERT_EQ(refusal(whole), "accepted");
    for (std::size_t length = 0; length < whole.size(); ++length)
      EXPECT_NE(refusal(whole.substr(0, length)), "accepted") << length;
    EXPECT_EQ(refusal(whole + '\0'), "the file is longer than what its header promises");
  }
}

TEST(PetscBinary, HeadersThatCannotBe) {
  const std::string values = reals({2, 1, 4});
  EXPECT_EQ(refusal(integers({kMatrix, 2, 3, 3, 2, 1, 0, 1, 1}, 4) + values),
            "the matrix is not square: 2 x 3");
  EXPECT_EQ(refusal(integers({kMatrix, -2, 2, 3, 2, 1, 0, 1, 1}, 4) + values),
            "rows: -2 is not from 0 to 2^31 - 1");
  EXPECT_EQ(refusal(integers({kMatrix, 2, 2, -1, 2, 1, 0, 1, 1}, 4) + values),
            "a dense matrix is read from a Matrix Market file");
  EXPECT_EQ(refusal(integers({kMatrix, 2, 2, 3, 4, -1, 0, 1, 1}, 4) + values), "row 1 has 4 entries of 3");
  EXPECT_EQ(refusal(integers({kMatrix, 2, 2, 3, 1, 1, 0, 1, 1}, 4) + values),
            "the rows have 2 entries, not 3");
  EXPECT_EQ(refusal(integers({kMatrix, 2, 2, 3, 2, 1, 0, 2, 1}, 4) + values), "column 2 is not in 0..1");
  EXPECT_EQ(refusal(integers({kMatrix, 2147483647, 2147483647, 2147483647}, 4)), "the file is cut off");
  EXPECT_EQ(refusal(integers({kVector, 1}, 4) + reals({1})), "accepted");  // as an array of 1 x 1
}

}  // namespace
