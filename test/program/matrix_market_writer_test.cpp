// What the library writes, its program reads back: every number the same. And what cannot be written is said.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <mfs/error.hpp>
#include <mfs/matrix_market.hpp>

#include "solver/program/matrix_market.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using mfs::write_matrix_market;
using mfs::io::CsrMatrix;
using mfs::io::DenseMatrix;
using mfs::io::Field;
using mfs::io::MatrixMarket;
using mfs::io::read_matrix_market;
using testing::ElementsAre;
using testing::ElementsAreArray;

using Limits = std::numeric_limits<double>;
using Complex = std::complex<double>;

const std::vector<double> kAwkward{0.1,   -0.0,   1.0 / 3, Limits::max(), Limits::min(), Limits::denorm_min(),
                                   -1e22, 5e-324, 7};

TEST(MatrixMarketWriter, EveryNumberOfAnArrayReadsBackTheSame) {
  const TemporaryFolder folder;
  const std::string path = folder.path("x.mtx");
  write_matrix_market(path, kAwkward.data(), 3, 3, 3, "a comment");
  const MatrixMarket file = read_matrix_market(path);
  const auto& b = std::get<DenseMatrix<double>>(file.content);
  EXPECT_EQ(b.rows, 3);
  EXPECT_EQ(b.columns, 3);
  EXPECT_THAT(b.values, ElementsAreArray(kAwkward));
  EXPECT_TRUE(std::signbit(b.values[1]));
  EXPECT_THAT(text_of(path), testing::HasSubstr("\n% a comment\n"));
}

TEST(MatrixMarketWriter, LeadingDimension) {
  const TemporaryFolder folder;
  write_matrix_market(folder.path("x.mtx"), kAwkward.data(), 2, 3, 3, "");
  const MatrixMarket file = read_matrix_market(folder.path("x.mtx"));
  EXPECT_THAT(std::get<DenseMatrix<double>>(file.content).values,
              ElementsAre(0.1, -0.0, Limits::max(), Limits::min(), -1e22, 5e-324));
}

TEST(MatrixMarketWriter, EveryEntryOfAMatrixReadsBackTheSame) {
  const std::vector<std::int32_t> offsets{0, 3, 3, 5}, columns{1, 0, 1, 2, 0};  // unsorted, one entry twice
  const auto written = [&](const auto* values) {
    const TemporaryFolder folder;
    const mfs::CsrView<std::decay_t<decltype(*values)>> view{3, 4, offsets.data(), columns.data(), values};
    write_matrix_market(folder.path("a.mtx"), view, "");
    return read_matrix_market(folder.path("a.mtx"));
  };
  const MatrixMarket real = written(kAwkward.data());
  const auto& a = std::get<CsrMatrix<double>>(real.content);
  EXPECT_EQ(a.rows, 3);
  EXPECT_EQ(a.columns, 4);
  EXPECT_THAT(a.offsets, ElementsAre(0, 3, 3, 5));
  EXPECT_THAT(a.column_indices, ElementsAre(1, 0, 1, 2, 0));
  EXPECT_THAT(a.values, ElementsAre(0.1, -0.0, 1.0 / 3, Limits::max(), Limits::min()));

  const std::vector<Complex> complex{{0.1, -2}, {0, 1e300}, {3, -0.0}, {1.0 / 3, 4}, {5, 6}};
  EXPECT_THAT(std::get<CsrMatrix<Complex>>(written(complex.data()).content).values,
              ElementsAreArray(complex));
  const std::vector<float> single{0.1F, 1.0F / 3, 3e38F, 1e-45F, 5};
  EXPECT_THAT(std::get<CsrMatrix<double>>(written(single.data()).content).values, ElementsAreArray(single));
  EXPECT_EQ(written(static_cast<const double*>(nullptr)).header.field, Field::pattern);
}

TEST(MatrixMarketWriter, ArraysThatAreNoMatrixAreRefusedBeforeAFileIsMade) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.mtx");
  const auto refused = [&](std::vector<std::int64_t> offsets, std::vector<std::int64_t> columns,
                           const std::string& argument) {
    try {
      write_matrix_market(path, mfs::CsrView<double>{2, 2, offsets.data(), columns.data(), kAwkward.data()},
                          "");
      ADD_FAILURE() << "written";
    } catch (const mfs::InvalidInput& e) {
      EXPECT_EQ(e.argument(), argument);
    }
    EXPECT_FALSE(std::filesystem::exists(path));
  };
  refused({1, 1, 1}, {0}, "row_offsets");
  refused({0, 2, 1}, {0, 1}, "row_offsets");
  refused({0, 1, 2}, {0, 2}, "column_indices");
  refused({0, 1, 2}, {-1, 0}, "column_indices");
}

TEST(MatrixMarketWriter, WhatCannotBeWrittenIsSaid) {
  const double one = 1;
  for (const char* path : {"/no/such/folder/x.mtx", "/dev/full"}) {
    EXPECT_THROW(write_matrix_market(path, &one, 1, 1, 1, ""), mfs::InvalidInput);
    const std::int32_t offsets[] = {0, 1}, column = 0;
    EXPECT_THROW(write_matrix_market(path, mfs::CsrView<double>{1, 1, offsets, &column, &one}, ""),
                 mfs::InvalidInput);
  }
}

TEST(MatrixMarketWriter, NoCommentBreaksTheFile) {
  const TemporaryFolder folder;
  const std::string path = folder.path("x.mtx");
  for (const char* comment : {"two\nlines", "3 3", "\n\n1 1\n", "a\r\nb\rc",
                              "%%MatrixMarket matrix array real general\n1 1\n5\n"}) {
    write_matrix_market(path, kAwkward.data(), 3, 3, 3, comment);
    const MatrixMarket file = read_matrix_market(path);
    EXPECT_THAT(std::get<DenseMatrix<double>>(file.content).values, ElementsAreArray(kAwkward)) << comment;
  }
  write_matrix_market(path, kAwkward.data(), 3, 3, 3, "two\nlines");
  EXPECT_THAT(text_of(path), testing::HasSubstr("\n% two\n% lines\n3 3\n"));
}

TEST(MatrixMarketWriter, ToAStreamThatStaysOpen) {
  const TemporaryFolder folder;
  const std::string path = folder.path("x.mtx");
  std::FILE* stream = std::fopen(path.c_str(), "w");
  const std::vector<std::int32_t> offsets{0, 1}, columns{0};
  const mfs::CsrView<double> a{1, 1, offsets.data(), columns.data(), kAwkward.data()};
  write_matrix_market(stream, a, "");
  std::fprintf(stream, "behind");
  std::fclose(stream);
  EXPECT_THAT(text_of(path), testing::EndsWith("1 1 1.0000000000000001e-01\nbehind"));
  stream = std::fopen("/dev/full", "w");
  EXPECT_THROW(write_matrix_market(stream, kAwkward.data(), 3, 3, 3, ""), mfs::InvalidInput);
  std::fclose(stream);
  EXPECT_THROW(write_matrix_market(static_cast<std::FILE*>(nullptr), a, ""), mfs::InvalidInput);
}

}  // namespace
