// Each kind of error: what it carries and what it says.
#include <mfs/error.hpp>

#include <gmock/gmock.h>

namespace mfs::test {
namespace {

using ::testing::HasSubstr;

TEST(Error, InvalidInputSaysWhichArgumentAndWhere) {
  const InvalidInput placed("values", "not a finite number", 3, 5);
  EXPECT_EQ(placed.argument(), "values");
  EXPECT_EQ(placed.row(), 3);
  EXPECT_EQ(placed.column(), 5);
  EXPECT_STREQ(placed.what(), "values: not a finite number (row 3, column 5)");
  EXPECT_STREQ(InvalidInput("rows", "negative").what(), "rows: negative");
  EXPECT_STREQ(InvalidInput("row_offsets", "offsets decrease", 7).what(),
               "row_offsets: offsets decrease (row 7)");
}

TEST(Error, PatternChangedSaysTheRow) {
  const PatternChanged error("its entries are not those that were analysed", 4);
  EXPECT_EQ(error.row(), 4);
  EXPECT_THAT(error.what(), HasSubstr("(row 4)"));
}

TEST(Error, SingularMatrixSaysItsKind) {
  const SingularMatrix structural(SingularMatrix::Kind::structural, 1, 2, 3, "three dependent rows");
  EXPECT_EQ(structural.kind(), SingularMatrix::Kind::structural);
  EXPECT_EQ(structural.row(), 1);
  EXPECT_EQ(structural.column(), 2);
  EXPECT_EQ(structural.dependent_rows(), 3);
  EXPECT_STREQ(structural.what(), "structurally singular: three dependent rows (row 1, column 2)");
  EXPECT_THAT(SingularMatrix(SingularMatrix::Kind::numerical, 1, 2, 3, "").what(),
              HasSubstr("numerically singular"));
}

TEST(Error, AccuracyNotReachedSaysBothNumbers) {
  const AccuracyNotReached error(3e-9, 1e-12);
  EXPECT_EQ(error.reached(), 3e-9);
  EXPECT_EQ(error.asked(), 1e-12);
  EXPECT_STREQ(error.what(), "backward error 3.000e-09 reached, 1.000e-12 asked");
}

TEST(Error, OutOfMemorySaysHowMuchAndWhere) {
  const OutOfMemory error(MemorySpace::device, 4096, 1024);
  EXPECT_EQ(error.space(), MemorySpace::device);
  EXPECT_EQ(error.needed(), 4096u);
  EXPECT_EQ(error.available(), 1024u);
  EXPECT_STREQ(error.what(), "out of device memory: 4096 bytes needed, 1024 available");
  EXPECT_STREQ(OutOfMemory(MemorySpace::host, 8, 0).what(), "out of host memory: 8 bytes needed");
}

TEST(Error, BackendErrorSaysLibraryAndCode) {
  const BackendError error("METIS", -4, "vertex separator");
  EXPECT_EQ(error.library(), "METIS");
  EXPECT_EQ(error.code(), -4);
  EXPECT_STREQ(error.what(), "METIS failed with code -4: vertex separator");
  EXPECT_STREQ(BackendError("CUDA", 0, "no device").what(), "CUDA: no device");  // nothing of it was called
}

TEST(Error, AllAreErrors) {
  EXPECT_THROW(throw InvalidInput("rows", ""), Error);
  EXPECT_THROW(throw StateError(""), Error);
  EXPECT_THROW(throw PatternChanged("", 0), Error);
  EXPECT_THROW(throw SingularMatrix(SingularMatrix::Kind::structural, 0, 0, 1, ""), Error);
  EXPECT_THROW(throw AccuracyNotReached(1, 0), Error);
  EXPECT_THROW(throw OutOfMemory(MemorySpace::host, 1, 0), Error);
  EXPECT_THROW(throw BackendError("METIS", 1, ""), Error);
}

}  // namespace
}  // namespace mfs::test
