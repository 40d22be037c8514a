// A table in NumPy's format: by its bytes, and as NumPy reads it where it is.
#include <cstdio>
#include <cstring>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "dae/output/npy_table.hpp"
#include "test/dae/mechanics/expect_refused.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using mfs::dae::NpyField;
using mfs::dae::NpyTable;
using testing::HasSubstr;
using testing::StartsWith;

const std::vector<NpyField> kFields{{"t", {}}, {"bodies.arm.position", {3}}, {"m", {2, 1}}};

TEST(NpyTable, IsWholeAfterEachRow) {
  const TemporaryFolder folder;
  const std::string path = folder.path("r.npy");
  NpyTable table(path, kFields);
  for (int row = 0; row < 3; ++row) {
    const std::string file = text_of(path);
    ASSERT_THAT(file, StartsWith(std::string("\x93NUMPY\x02\0", 8)));
    std::uint32_t length = 0;
    std::memcpy(&length, &file[8], sizeof length);
    EXPECT_EQ((12 + length) % 64, 0U);
    const std::string header = file.substr(12, length);
    EXPECT_THAT(header, StartsWith("{'descr': [('t', '<f8'), ('bodies.arm.position', '<f8', (3,)), "
                                   "('m', '<f8', (2, 1,)), ], 'fortran_order': False, 'shape': ("));
    EXPECT_THAT(header, HasSubstr(" " + std::to_string(row) + ",), }"));
    EXPECT_EQ(header.back(), '\n');
    EXPECT_EQ(file.size(), 12 + length + 48U * static_cast<unsigned>(row));
    if (row > 0) {
      double last = 0;
      std::memcpy(&last, &file[file.size() - sizeof last], sizeof last);
      EXPECT_EQ(last, row - 1 + 1.0 / 3);
    }
    table.add_row({0.5 * row, 1, 2, 3, 4, row + 1.0 / 3});
  }
}

TEST(NpyTable, IsReadByNumpy) {
  const TemporaryFolder folder;
  const std::string path = folder.path("r.npy");
  NpyTable table(path, kFields);
  table.add_row({0.5, 1, 2, 3, 4, 5});
  table.add_row({1.5, 6, 7, 8, 9, 1e-300});
  const std::string command =
      "/usr/bin/python3 -c \"import numpy; r = numpy.load('" + path +
      "', mmap_mode='r'); assert r.shape == (2,); assert (r['bodies.arm.position'][1] == [6, 7, 8]).all(); "
      "assert r['m'].shape == (2, 2, 1); assert r['m'][1, 1, 0] == 1e-300; print(r['t'].sum())\" 2>&1";
  std::FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string text(4096, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), pipe));
  pclose(pipe);
  if (text.find("No module named") != std::string::npos) GTEST_SKIP() << text;
  EXPECT_EQ(text, "2.0\n");
}

TEST(NpyTable, RefusesWhatWouldNotBeATable) {
  const TemporaryFolder folder;
  const std::string path = folder.path("r.npy");
  const auto refused = [&](const std::vector<NpyField>& fields, const std::string& text) {
    mfs::test::expect_refused(path, text, [&] { NpyTable(path, fields); });
  };
  refused({{"it's", {}}}, "it's");
  refused({{"", {}}}, "''");
  refused({{"a", {}}, {"a", {3}}}, "'a'");
  NpyTable table(path, kFields);
  mfs::test::expect_refused("values", "2 for 6 columns", [&] { table.add_row({1, 2}); });
  mfs::test::expect_refused("/dev/full", "No space left", [] { NpyTable("/dev/full", kFields); });
}

}  // namespace
