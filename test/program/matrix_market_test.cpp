// Matrix Market files: each rule of the definition by a file of a few lines, and files at random against the
// numbers that they were written from.
#include "solver/program/matrix_market.hpp"

#include <clocale>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::io;
using testing::ElementsAre;
using testing::ElementsAreArray;
using Complex = std::complex<double>;

constexpr char kReal[] = "%%MatrixMarket matrix coordinate real general\n";
constexpr char kSymmetric[] = "%%MatrixMarket matrix coordinate real symmetric\n";
constexpr char kSkew[] = "%%MatrixMarket matrix coordinate real skew-symmetric\n";
constexpr char kHermitian[] = "%%MatrixMarket matrix coordinate complex hermitian\n";
constexpr char kInteger[] = "%%MatrixMarket matrix coordinate integer general\n";
constexpr char kArray[] = "%%MatrixMarket matrix array real general\n";

MatrixMarket parse(const std::string& text) {
  return parse_matrix_market(text, "t");
}

template <class Scalar>
CsrMatrix<Scalar> sparse(const std::string& text) {
  return std::get<CsrMatrix<Scalar>>(parse(text).content);
}

template <class Scalar>
DenseMatrix<Scalar> dense(const std::string& text) {
  return std::get<DenseMatrix<Scalar>>(parse(text).content);
}

/// The message of the refusal, without the name of the file; "accepted" where there is none.
std::string refusal(const std::string& text, const ReadOptions& options = {}) {
  try {
    parse_matrix_market(text, "t", options);
  } catch (const mfs::InvalidInput& e) {
    EXPECT_EQ(e.argument(), "t");
    const std::string what = e.what();
    EXPECT_EQ(what.substr(0, 3), "t: ");
    return what.substr(3);
  }
  return "accepted";
}

/// The one value of a real file that holds the text `number`, read as an array and as a coordinate file.
double value_of(const std::string& number) {
  const double value = dense<double>(kArray + std::string("1 1\n") + number + "\n").values.at(0);
  const double same = sparse<double>(kReal + std::string("1 1 1\n1 1 ") + number).values.at(0);
  EXPECT_TRUE(value == same || (std::isnan(value) && std::isnan(same))) << number;
  return value;
}

std::string number_refusal(const std::string& number) {
  return refusal(kArray + std::string("1 1\n") + number);
}

// ---- what a file means ----

TEST(MatrixMarketMeaning, GeneralKeepsTheOrderOfTheFileInEachRow) {
  const auto a = sparse<double>(kReal + std::string("2 3 4\n2 3 6\n1 2 2\n2 1 4\n1 1 1\n"));
  EXPECT_EQ(a.rows, 2);
  EXPECT_EQ(a.columns, 3);
  EXPECT_THAT(a.offsets, ElementsAre(0, 2, 4));
  EXPECT_THAT(a.column_indices, ElementsAre(1, 0, 2, 0));
  EXPECT_THAT(a.values, ElementsAre(2, 1, 6, 4));
}

TEST(MatrixMarketMeaning, SymmetricMirrorsAllButTheDiagonal) {
  const auto a = sparse<double>(kSymmetric + std::string("3 3 4\n1 1 4\n2 1 -1\n3 2 -2\n3 3 5\n"));
  EXPECT_THAT(a.offsets, ElementsAre(0, 2, 4, 6));
  EXPECT_THAT(a.column_indices, ElementsAre(0, 1, 0, 2, 1, 2));
  EXPECT_THAT(a.values, ElementsAre(4, -1, -1, -2, -2, 5));
}

TEST(MatrixMarketMeaning, SkewSymmetricMirrorsWithTheOtherSign) {
  const auto a = sparse<double>(kSkew + std::string("2 2 1\n2 1 3\n"));
  EXPECT_THAT(a.offsets, ElementsAre(0, 1, 2));
  EXPECT_THAT(a.column_indices, ElementsAre(1, 0));
  EXPECT_THAT(a.values, ElementsAre(-3, 3));
}

TEST(MatrixMarketMeaning, HermitianMirrorsTheConjugate) {
  const auto a = sparse<Complex>(kHermitian + std::string("2 2 2\n1 1 1 0\n2 1 3 4\n"));
  EXPECT_THAT(a.column_indices, ElementsAre(0, 1, 0));
  EXPECT_THAT(a.values, ElementsAre(Complex(1, 0), Complex(3, -4), Complex(3, 4)));
}

TEST(MatrixMarketMeaning, ComplexSymmetricMirrorsTheSameValue) {
  const auto a = sparse<Complex>("%%MatrixMarket matrix coordinate complex symmetric\n2 2 1\n2 1 3 4\n");
  EXPECT_THAT(a.values, ElementsAre(Complex(3, 4), Complex(3, 4)));
}

TEST(MatrixMarketMeaning, ComplexSkewSymmetricMirrorsWithTheOtherSign) {
  const auto a = sparse<Complex>("%%MatrixMarket matrix coordinate complex skew-symmetric\n2 2 1\n2 1 3 4\n");
  EXPECT_THAT(a.values, ElementsAre(Complex(-3, -4), Complex(3, 4)));
}

TEST(MatrixMarketMeaning, PatternHasNoValues) {
  const auto a = sparse<double>("%%MatrixMarket matrix coordinate pattern symmetric\n2 2 2\n1 1\n2 1\n");
  EXPECT_THAT(a.column_indices, ElementsAre(0, 1, 0));
  EXPECT_TRUE(a.values.empty());
  EXPECT_EQ(a.view().values, nullptr);
}

TEST(MatrixMarketMeaning, DuplicatesStayApart) {
  const auto a = sparse<double>(kReal + std::string("1 1 2\n1 1 2\n1 1 3\n"));
  EXPECT_THAT(a.values, ElementsAre(2, 3));
}

TEST(MatrixMarketMeaning, ExplicitZerosStay) {
  EXPECT_THAT(sparse<double>(kReal + std::string("1 1 1\n1 1 0\n")).values, ElementsAre(0));
}

TEST(MatrixMarketMeaning, ArraysGoColumnByColumn) {
  const auto a = dense<double>(kArray + std::string("2 3\n1\n2\n3\n4\n5\n6\n"));
  EXPECT_EQ(a.rows, 2);
  EXPECT_EQ(a.columns, 3);
  EXPECT_THAT(a.values, ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(MatrixMarketMeaning, ArraysOfASymmetryListOneTriangle) {
  EXPECT_THAT(dense<double>("%%MatrixMarket matrix array real symmetric\n3 3\n1\n2\n3\n4\n5\n6\n").values,
              ElementsAre(1, 2, 3, 2, 4, 5, 3, 5, 6));
  EXPECT_THAT(dense<double>("%%MatrixMarket matrix array integer skew-symmetric\n3 3\n1\n2\n3\n").values,
              ElementsAre(0, 1, 2, -1, 0, 3, -2, -3, 0));
  EXPECT_THAT(dense<Complex>("%%MatrixMarket matrix array complex hermitian\n2 2\n1 0\n3 4\n2 0\n").values,
              ElementsAre(Complex(1, 0), Complex(3, 4), Complex(3, -4), Complex(2, 0)));
}

TEST(MatrixMarketMeaning, EmptyMatrices) {
  const auto a = sparse<double>(kReal + std::string("3 4 0\n"));
  EXPECT_THAT(a.offsets, ElementsAre(0, 0, 0, 0));
  EXPECT_EQ(sparse<double>(kReal + std::string("0 0 0")).entries(), 0);
  EXPECT_TRUE(dense<double>(kArray + std::string("0 5\n")).values.empty());
}

// ---- what is tolerated because it has one meaning only ----

TEST(MatrixMarketTolerance, LettersBlanksAndLineEnds) {
  EXPECT_THAT(
      sparse<double>("%%matrixmarket\tMATRIX  Coordinate Real  GENERAL \r\n"
                     "% a comment\r\n  % another\r\n\r\n%%third\n\n  1\t1 1  \r\n\n \t\n 1 1\t7\r\n\n\n")
          .values,
      ElementsAre(7));
}

TEST(MatrixMarketTolerance, LastLineWithoutEnd) {
  EXPECT_THAT(sparse<double>(kReal + std::string("1 1 1\n1 1 7")).values, ElementsAre(7));
}

TEST(MatrixMarketTolerance, LongLines) {
  const std::string comment = "%" + std::string(100000, 'x') + "\n", blanks(2000, ' ');
  EXPECT_THAT(sparse<double>(kReal + comment + "1 1 1\n" + blanks + "1 1" + blanks + "7\n").values,
              ElementsAre(7));
  EXPECT_EQ(refusal(kReal + std::string("1 1 1\n\n% ") + std::string(6 << 20, 'x')),
            "line 4: a line is longer than 1048576 characters");
}

TEST(MatrixMarketTolerance, Numbers) {
  EXPECT_EQ(value_of("1"), 1);
  EXPECT_EQ(value_of("+1.5"), 1.5);
  EXPECT_EQ(value_of("-.5"), -0.5);
  EXPECT_EQ(value_of("5."), 5);
  EXPECT_EQ(value_of("1.5E+02"), 150);
  EXPECT_EQ(value_of("1.5e-2"), 0.015);
  EXPECT_EQ(value_of("1.5D+02"), 150);  // Fortran
  EXPECT_EQ(value_of("+1.5d2"), 150);
  EXPECT_TRUE(std::signbit(value_of("-0")));
  EXPECT_EQ(value_of("0.1"), 0.1);
  EXPECT_EQ(value_of("0.1000000000000000055511151231257827021181583404541015625"), 0.1);
  EXPECT_EQ(value_of("9007199254740993"), 9007199254740992.0);  // a tie: to even
  EXPECT_EQ(value_of("9007199254740993.00000000000000000000000000000000001"), 9007199254740994.0);
  EXPECT_EQ(value_of("1.7976931348623157e308"), std::numeric_limits<double>::max());
  EXPECT_EQ(value_of("4.9406564584124654e-324"), std::numeric_limits<double>::denorm_min());
  EXPECT_EQ(value_of("2.2250738585072011e-308"), 2.2250738585072011e-308);  // subnormal
  EXPECT_EQ(value_of("1e-400"), 0);
  EXPECT_TRUE(std::signbit(value_of("-1e-400")));
  // For the solver to refuse, with row and column.
  EXPECT_TRUE(std::isnan(value_of("nan")));
  EXPECT_EQ(value_of("-Inf"), -std::numeric_limits<double>::infinity());
}

TEST(MatrixMarketTolerance, NumbersDoNotDependOnTheLocale) {
  if (!std::setlocale(LC_NUMERIC, "de_DE.UTF-8")) GTEST_SKIP() << "no locale with a decimal comma here";
  EXPECT_EQ(value_of("1.5D0"), 1.5);
  EXPECT_EQ(value_of("1e-400"), 0);
  std::setlocale(LC_NUMERIC, "C");
}

TEST(MatrixMarketTolerance, IntegersOf64Bits) {
  EXPECT_THAT(sparse<double>(kInteger + std::string("1 2 2\n1 1 +3\n1 2 -9223372036854775808\n")).values,
              ElementsAre(3, -0x1p63));
}

// ---- what is refused, and where ----

TEST(MatrixMarketRefusal, Banner) {
  const std::string none = "line 1: not a Matrix Market file: it must begin with %%MatrixMarket";
  EXPECT_EQ(refusal(""), "the file is empty");
  EXPECT_EQ(refusal("\n"), none);
  EXPECT_EQ(refusal("1 1 1\n1 1 1\n"), none);
  EXPECT_EQ(refusal("%MatrixMarket matrix coordinate real general\n1 1 0\n"), none);
  EXPECT_EQ(refusal("\n%%MatrixMarket matrix coordinate real general\n1 1 0\n"), none);
  EXPECT_EQ(refusal(" %%MatrixMarket matrix coordinate real general\n1 1 0\n"), none);
  EXPECT_EQ(refusal("%%MatrixMarket vector coordinate real general\n"),
            "line 1: the banner's object 'vector' is not known: only matrix is");
  EXPECT_EQ(refusal("%%MatrixMarket matrix dense real general\n"),
            "line 1: the banner's format 'dense' is none of: coordinate, array");
  EXPECT_EQ(refusal("%%MatrixMarket matrix coordinate float general\n"),
            "line 1: the banner's field 'float' is none of: real, integer, complex, pattern");
  EXPECT_EQ(
      refusal("%%MatrixMarket matrix coordinate real lower\n"),
      "line 1: the banner's symmetry 'lower' is none of: general, symmetric, skew-symmetric, hermitian");
  EXPECT_EQ(refusal("%%MatrixMarket matrix coordinate real\n"), "line 1: the banner names no symmetry");
  EXPECT_EQ(refusal("%%MatrixMarket matrix coordinate real general 0-base\n"),
            "line 1: unexpected '0-base' at the end of the line");
}

TEST(MatrixMarketRefusal, CombinationsThatMeanNothing) {
  EXPECT_EQ(refusal("%%MatrixMarket matrix array pattern general\n1 1\n"),
            "line 1: an array file cannot be a pattern: it has nothing but values");
  EXPECT_EQ(refusal("%%MatrixMarket matrix coordinate pattern skew-symmetric\n1 1 0\n"),
            "line 1: a pattern file cannot be skew-symmetric");
  for (const char* field : {"real", "integer", "pattern"})
    EXPECT_EQ(refusal("%%MatrixMarket matrix coordinate " + std::string(field) + " hermitian\n1 1 0\n"),
              "line 1: a hermitian file must be complex");
}

TEST(MatrixMarketRefusal, SizeLine) {
  EXPECT_EQ(refusal(kReal), "line 1: the file ends before its size line");
  EXPECT_EQ(refusal(kReal + std::string("% only\n\n% comments\n")),
            "line 4: the file ends before its size line");
  EXPECT_EQ(refusal(kReal + std::string("%\n3 3\n")), "line 3: the number of entries is missing");
  EXPECT_EQ(refusal(kReal + std::string("3\n")), "line 2: the number of columns is missing");
  EXPECT_EQ(refusal(kReal + std::string("3 3 1 1\n")), "line 2: unexpected '1' at the end of the line");
  EXPECT_EQ(refusal(kArray + std::string("3 3 1\n")), "line 2: unexpected '1' at the end of the line");
  EXPECT_EQ(refusal(kReal + std::string("3 x 1\n")), "line 2: the number of columns 'x' is not an integer");
  EXPECT_EQ(refusal(kReal + std::string("3.0 3 1\n")), "line 2: the number of rows '3.0' is not an integer");
  EXPECT_EQ(refusal(kReal + std::string("3 -3 0\n")), "line 2: a size is negative");
  EXPECT_EQ(refusal(kReal + std::string("3 3 -1\n")), "line 2: a size is negative");
  EXPECT_EQ(refusal(kReal + std::string("9223372036854775808 3 1\n")),
            "line 2: the number of rows '9223372036854775808' does not fit 64 bits");
  EXPECT_EQ(refusal(kReal + std::string("2147483648 1 1\n")), "line 2: more than 2147483647 rows or columns");
  EXPECT_EQ(refusal(kReal + std::string("1 9223372036854775807 1\n")),
            "line 2: more than 2147483647 rows or columns");
  EXPECT_EQ(refusal(kReal + std::string("0 1 1\n1 1 1\n")),
            "line 2: a matrix of 0 x 1 has no room for 1 entries");
  for (const char* banner : {kSymmetric, kSkew, kHermitian})
    EXPECT_EQ(refusal(banner + std::string("4 3 0\n")),
              "line 2: the symmetry asks for a square matrix, this one is 4 x 3");
}

TEST(MatrixMarketRefusal, NumberOfEntries) {
  EXPECT_EQ(refusal(kReal + std::string("2 2 2\n1 1 1\n")), "line 3: the file ends after 1 of 2 entries");
  EXPECT_EQ(refusal(kReal + std::string("2 2 2\n")), "line 2: the file ends after 0 of 2 entries");
  EXPECT_EQ(refusal(kReal + std::string("2 2 9223372036854775807\n1 1 1\n")),
            "line 3: the file ends after 1 of 9223372036854775807 entries");
  EXPECT_EQ(refusal(kReal + std::string("2 2 1\n\n1 1 1\n\n2 2 1\n2 1 1\n")),
            "line 6: more than the promised 1 entries");
  EXPECT_EQ(refusal(kReal + std::string("2 2 0\n1 1 1\n")), "line 3: more than the promised 0 entries");
  EXPECT_EQ(refusal(kArray + std::string("2 2\n1\n2\n3\n")), "line 5: the file ends after 3 of 4 entries");
  EXPECT_EQ(refusal(kArray + std::string("2 1\n1\n2\n3\n")), "line 5: more than the promised 2 entries");
  EXPECT_EQ(refusal("%%MatrixMarket matrix array real skew-symmetric\n2 2\n1\n2\n"),
            "line 4: more than the promised 1 entries");
  EXPECT_EQ(refusal(kArray + std::string("2147483647 2147483647\n1\n")),
            "line 3: the file ends after 1 of 4611686014132420609 entries");
}

TEST(MatrixMarketRefusal, Indices) {
  EXPECT_EQ(refusal(kReal + std::string("2 2 1\n0 1 1\n")), "line 3: row 0 is not in 1..2");
  EXPECT_EQ(refusal(kReal + std::string("2 3 2\n1 3 1\n3 1 1\n")), "line 4: row 3 is not in 1..2");
  EXPECT_EQ(refusal(kReal + std::string("2 3 1\n1 4 1\n")), "line 3: column 4 is not in 1..3");
  EXPECT_EQ(refusal(kReal + std::string("2 3 1\n1 -1 1\n")), "line 3: column -1 is not in 1..3");
  EXPECT_EQ(refusal(kReal + std::string("2 3 1\n4294967297 1 1\n")), "line 3: row 4294967297 is not in 1..2");
  EXPECT_EQ(refusal(kReal + std::string("2 3 1\n1e0 1 1\n")), "line 3: row '1e0' is not an integer");
  EXPECT_EQ(refusal(kReal + std::string("2 3 1\n1,1,1\n")), "line 3: row '1,1,1' is not an integer");
  EXPECT_EQ(refusal(kReal + std::string("2 3 1\n99999999999999999999 1 1\n")),
            "line 3: row '99999999999999999999' does not fit 64 bits");
  EXPECT_EQ(refusal(kReal + std::string("2 3 1\n1\n")), "line 3: column is missing");
}

TEST(MatrixMarketRefusal, Triangles) {
  const std::string only =
      " is above the diagonal: of a symmetric, skew-symmetric or hermitian matrix only the lower triangle is "
      "listed";
  EXPECT_EQ(refusal(kSymmetric + std::string("2 2 2\n1 1 1\n1 2 1\n")), "line 4: entry (1, 2)" + only);
  EXPECT_EQ(refusal(kSkew + std::string("2 2 1\n1 2 1\n")), "line 3: entry (1, 2)" + only);
  EXPECT_EQ(refusal(kHermitian + std::string("2 2 1\n1 2 1 1\n")), "line 3: entry (1, 2)" + only);
  EXPECT_EQ(refusal(kSkew + std::string("2 2 1\n2 2 0\n")),
            "line 3: entry (2, 2) is on the diagonal, which is zero in a skew-symmetric matrix");
  EXPECT_EQ(refusal(kHermitian + std::string("2 2 1\n2 2 1 1\n")),
            "line 3: the diagonal of a hermitian matrix is real");
  EXPECT_EQ(refusal("%%MatrixMarket matrix array complex hermitian\n2 2\n1 0\n3 4\n2 1\n"),
            "the diagonal of a hermitian matrix is real, not so in row 2");
}

TEST(MatrixMarketRefusal, Lines) {
  EXPECT_EQ(refusal(kReal + std::string("1 1 1\n1 1\n")), "line 3: the value is missing");
  EXPECT_EQ(refusal(kReal + std::string("1 1 1\n1 1 1 0\n")),
            "line 3: unexpected '0' at the end of the line");
  EXPECT_EQ(refusal(kArray + std::string("1 2\n1 2\n")), "line 3: unexpected '2' at the end of the line");
  EXPECT_EQ(refusal("%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1\n"),
            "line 3: the imaginary part is missing");
  EXPECT_EQ(refusal("%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1 1\n"),
            "line 3: unexpected '1' at the end of the line");
  const std::string comment = "a comment after the size line: comments belong between banner and size line";
  EXPECT_EQ(refusal(kReal + std::string("1 1 1\n% late\n1 1 1\n")), "line 3: " + comment);
  EXPECT_EQ(refusal(kReal + std::string("1 1 1\n1 1 1\n % late\n")), "line 4: " + comment);
}

TEST(MatrixMarketRefusal, Numbers) {
  EXPECT_EQ(number_refusal("pi"), "line 3: the value 'pi' is not a number");
  EXPECT_EQ(number_refusal("1.5.2"), "line 3: the value '1.5.2' is not a number");
  EXPECT_EQ(number_refusal("0x10"), "line 3: the value '0x10' is not a number");
  EXPECT_EQ(number_refusal("1,5"), "line 3: the value '1,5' is not a number");
  EXPECT_EQ(number_refusal("1e"), "line 3: the value '1e' is not a number");
  EXPECT_EQ(number_refusal("d5"), "line 3: the value 'd5' is not a number");
  EXPECT_EQ(number_refusal("1d2d3"), "line 3: the value '1d2d3' is not a number");
  EXPECT_EQ(number_refusal("nad"), "line 3: the value 'nad' is not a number");
  EXPECT_EQ(number_refusal("+"), "line 3: the value '+' is not a number");
  EXPECT_EQ(number_refusal("+-1"), "line 3: the value '+-1' is not a number");
  EXPECT_EQ(number_refusal("1e400"), "line 3: the value '1e400' is too large for a double");
  EXPECT_EQ(number_refusal("-1d400"), "line 3: the value '-1d400' is too large for a double");
  EXPECT_EQ(refusal(kInteger + std::string("1 1 1\n1 1 1.5\n")), "line 3: the value '1.5' is not an integer");
  EXPECT_EQ(refusal(kInteger + std::string("1 1 1\n1 1 9223372036854775808\n")),
            "line 3: the value '9223372036854775808' does not fit 64 bits");
  // Messages stay short and printable, whatever the file holds.
  EXPECT_EQ(number_refusal(std::string(100, 'x')),
            "line 3: the value '" + std::string(32, 'x') + "...' is not a number");
  EXPECT_EQ(number_refusal("\x1b[31m" + std::string(1, '\0')), "line 3: the value '?[31m?' is not a number");
}

TEST(MatrixMarketRefusal, ByTheHeaderAlone) {
  ReadOptions options;
  options.refuse = [](const Header& h) { return h.rows == 2 ? std::string("no") : std::string(); };
  EXPECT_EQ(refusal(kReal + std::string("%\n2 2 1\nrubbish\n"), options), "line 3: no");
  EXPECT_EQ(refusal(kReal + std::string("1 1 0\n"), options), "accepted");
}

TEST(MatrixMarketRefusal, TheFirstFaultIsReportedWhateverTheBlocks) {
  std::string text = kReal + std::string("9 9 90\n");
  for (int i = 0; i < 50; ++i) text += "1 1 1\n";
  text += "bad\n10 1 1\n% late\n";
  for (const std::size_t block : {1, 2, 7, 64, 1 << 20})
    for (const int threads : {1, 2, 5}) {
      ReadOptions options;
      options.threads = threads;
      options.block_bytes = block;
      EXPECT_EQ(refusal(text, options), "line 53: row 'bad' is not an integer");
    }
}

TEST(MatrixMarketRefusal, ASurplusEntryComesBeforeAFaultBehindIt) {
  for (const std::size_t block : {1, 1 << 20}) {
    ReadOptions options;
    options.block_bytes = block;
    EXPECT_EQ(refusal(kReal + std::string("2 2 1\n1 1 1\n2 2 1\nbad\n"), options),
              "line 4: more than the promised 1 entries");
    EXPECT_EQ(refusal(kReal + std::string("2 2 1\n1 1 1\nbad\n2 2 1\n"), options),
              "line 4: row 'bad' is not an integer");
  }
}

// ---- any file ----

// A general real matrix as text with every freedom that the format leaves, and its entries.
struct RandomFile {
  std::string text;
  std::int64_t rows, columns;
  std::vector<std::tuple<int, int, double>> entries;  // in the order of the file
};

RandomFile random_file(std::mt19937& random) {
  const auto below = [&](int limit) { return static_cast<int>(random() % static_cast<unsigned>(limit)); };
  const auto blanks = [&] {
    return std::string(static_cast<std::size_t>(1 + below(3)), below(4) ? ' ' : '\t');
  };
  const auto noise = [&] { return below(6) == 0 ? "\n" : below(6) == 0 ? "  \r\n" : ""; };
  RandomFile file{kReal, 1 + below(8), 1 + below(8), {}};
  for (int k = below(3); k > 0; --k) file.text += "% comment\n" + std::string(noise());
  const int entries = below(60);
  file.text += std::to_string(file.rows) + blanks() + std::to_string(file.columns) + blanks() +
               std::to_string(entries) + "\n";
  for (int k = 0; k < entries; ++k) {
    const int row = below(static_cast<int>(file.rows)), column = below(static_cast<int>(file.columns));
    const double value = std::ldexp(static_cast<double>(random()) - 0x1p31, below(200) - 100);
    char number[40];
    std::snprintf(number, sizeof number, below(2) ? "%.17g" : "%.16E", value);
    file.entries.push_back({row, column, value});
    file.text += noise() + (below(3) ? std::string() : blanks()) + std::to_string(row + 1) + blanks() +
                 std::to_string(column + 1) + blanks() + number + (below(3) ? "" : " \r") +
                 (k + 1 < entries || below(2) ? "\n" : "");
  }
  return file;
}

TEST(MatrixMarketAtRandom, ReadsWhatWasWrittenForAnyBlocksAndThreads) {
  const unsigned seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (int trial = 0; trial < 500; ++trial) {
    const RandomFile file = random_file(random);
    ReadOptions options;
    options.threads = 1 + trial % 3;
    options.block_bytes = 1 + random() % 50;
    SCOPED_TRACE(file.text);
    const auto a = std::get<CsrMatrix<double>>(parse_matrix_market(file.text, "t", options).content);
    ASSERT_EQ(a.rows, file.rows);
    ASSERT_EQ(a.columns, file.columns);
    std::vector<std::int32_t> columns;
    std::vector<double> values;
    for (int row = 0; row < file.rows; ++row) {
      for (const auto& [r, column, value] : file.entries)
        if (r == row) {
          columns.push_back(column);
          values.push_back(value);
        }
      ASSERT_EQ(a.offsets[static_cast<std::size_t>(row) + 1], static_cast<std::int64_t>(values.size()));
    }
    ASSERT_THAT(a.column_indices, ElementsAreArray(columns));
    ASSERT_THAT(a.values, ElementsAreArray(values));
  }
}

}  // namespace
