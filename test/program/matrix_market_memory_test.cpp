// No allocation for a lie: a header's promises cost nothing until the entries are there. Every allocation of
// this program is counted.
#include <zlib.h>

#include <string>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "solver/program/matrix_market.hpp"
#include "test/failure/counted_memory.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::io;
using mfs::test::largest_request;
using mfs::test::live_bytes;
using mfs::test::peak_bytes;
using mfs::test::restart_marks;
using testing::HasSubstr;

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

/// The message of the error that reading `text` ends with.
std::string fault(const std::string& text) {
  restart_marks();
  try {
    parse_matrix_market(text, "t");
  } catch (const mfs::Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(MatrixMarketMemory, CountersWork) {
  restart_marks();
  const std::size_t before = live_bytes();
  char* volatile memory = new char[3 * kMegabyte];
  EXPECT_GE(live_bytes(), before + 3 * kMegabyte);
  delete[] memory;
  EXPECT_EQ(live_bytes(), before);
  EXPECT_EQ(largest_request(), 3 * kMegabyte);
  EXPECT_GE(peak_bytes(), before + 3 * kMegabyte);
}

TEST(MatrixMarketMemory, HugeEntryCount) {
  for (const char* banner :
       {"coordinate real general", "coordinate real symmetric", "coordinate complex hermitian"}) {
    EXPECT_THAT(fault("%%MatrixMarket matrix " + std::string(banner) + "\n2 2 1000000000000\n1 1 1 0\n"),
                HasSubstr("line 3"));
    EXPECT_LE(largest_request(), 9 * kMegabyte) << banner;
  }
  EXPECT_THAT(fault("%%MatrixMarket matrix array real general\n1000000 1000000\n1\n"),
              HasSubstr("line 3: the file ends after 1 of 1000000000000 entries"));
  EXPECT_LE(largest_request(), 9 * kMegabyte);
}

TEST(MatrixMarketMemory, HugeShape) {
  EXPECT_THAT(
      fault("%%MatrixMarket matrix coordinate real general\n2000000000 3 1\n1 1 1\n"),
      HasSubstr("t: the header claims 2000000000 rows, but at least 1999999999 of them have no entry"));
  EXPECT_LE(largest_request(), 9 * kMegabyte);
}

// Legal by the definition, and singular; the row is the first one of the empty ones.
TEST(MatrixMarketMemory, HugeSquareShapeIsStructurallySingular) {
  const auto first_empty = [](const std::string& text) {
    restart_marks();
    try {
      parse_matrix_market("%%MatrixMarket matrix coordinate " + text, "t");
    } catch (const mfs::SingularMatrix& e) {
      EXPECT_EQ(e.kind(), mfs::SingularMatrix::Kind::structural);
      EXPECT_GE(e.dependent_rows(), 1999999996);
      EXPECT_LE(largest_request(), 9 * kMegabyte);
      return e.row();
    }
    return std::int64_t{-2};
  };
  const std::string size = "2000000000 2000000000 ";
  EXPECT_EQ(first_empty("real general\n" + size + "0\n"), 0);
  EXPECT_EQ(first_empty("real general\n" + size + "1\n2 1 1\n"), 0);
  EXPECT_EQ(first_empty("real general\n" + size + "2\n2 5 1\n1 1 1\n"), 2);
  EXPECT_EQ(first_empty("real general\n" + size + "2\n2 5 1\n2 1 1\n"), 0);
  EXPECT_EQ(first_empty("real symmetric\n" + size + "2\n3 1 1\n2 2 1\n"), 3);
  EXPECT_EQ(first_empty("pattern symmetric\n" + size + "2\n3 1\n4 4\n"), 1);
}

// A million empty rows and fewer are the solver's business.
TEST(MatrixMarketMemory, ModerateShapesAreRead) {
  EXPECT_EQ(fault("%%MatrixMarket matrix coordinate real general\n1000000 1000000 1\n1 1 1\n"), "accepted");
}

// A small gzip file of very many blank lines, a few entries among them: memory follows the entries.
TEST(MatrixMarketMemory, GzipOfNearlyNothing) {
  const TemporaryFolder folder;
  const std::string path = folder.path("blank.mtx.gz");
  gzFile file = gzopen(path.c_str(), "wb");
  gzputs(file, "%%MatrixMarket matrix coordinate real general\n1 1 64\n");
  const std::string blank = std::string(kMegabyte, '\n') + "1 1 7\n";
  for (int k = 0; k < 64; ++k) ASSERT_GT(gzwrite(file, blank.data(), static_cast<unsigned>(blank.size())), 0);
  ASSERT_EQ(gzclose(file), Z_OK);
  restart_marks();
  const std::size_t before = live_bytes();
  const auto a = std::get<CsrMatrix<double>>(read_square_matrix(path, 2));
  EXPECT_EQ(a.entries(), 64);
  EXPECT_LE(largest_request(), 9 * kMegabyte);
  // Three blocks of text and what two threads parse them into, at a time.
  EXPECT_LE(peak_bytes() - before, 80 * kMegabyte);
}

}  // namespace
