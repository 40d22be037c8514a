// Plain and gzip files, and the real and malformed files of MFS_MATRIX_DIR where that folder is there.
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "solver/program/matrix_market.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::io;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr char kSmall[] = "%%MatrixMarket matrix coordinate real general\n2 2 2\n1 1 3\n2 2 4\n";

std::string gzip(const std::string& path, const std::string& text) {
  gzFile file = gzopen(path.c_str(), "wb");
  EXPECT_EQ(gzwrite(file, text.data(), static_cast<unsigned>(text.size())), static_cast<int>(text.size()));
  EXPECT_EQ(gzclose(file), Z_OK);
  return path;
}

std::vector<double> values_of(const std::string& path) {
  return std::get<CsrMatrix<double>>(read_square_matrix(path)).values;
}

/// "accepted", or the message without the path.
std::string refusal(const std::string& path) {
  try {
    read_matrix_market(path);
  } catch (const mfs::InvalidInput& e) {
    EXPECT_EQ(e.argument(), path);
    return std::string(e.what()).substr(path.size() + 2);
  }
  return "accepted";
}

std::string matrix_folder() {
  const char* folder = std::getenv("MFS_MATRIX_DIR");
  return folder && std::filesystem::is_directory(folder) ? folder : "";
}

TEST(MatrixMarketFiles, GzipIsKnownByItsContentNotByItsName) {
  const TemporaryFolder folder;
  for (const char* name : {"a.mtx", "a.mtx.gz"}) {
    EXPECT_THAT(values_of(folder.write(name, kSmall)), ElementsAre(3, 4));
    EXPECT_THAT(values_of(gzip(folder.path(name), kSmall)), ElementsAre(3, 4));
  }
}

TEST(MatrixMarketFiles, WhatIsNoReadableFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(refusal(folder.path("none.mtx")), "cannot be opened: No such file or directory");
  EXPECT_EQ(refusal(folder.path("")), "cannot be read: Is a directory");
  EXPECT_EQ(refusal(folder.write("empty.mtx", "")), "the file is empty");
  EXPECT_EQ(refusal(gzip(folder.path("empty.mtx.gz"), "")), "the file is empty");
}

TEST(MatrixMarketFiles, DamagedGzip) {
  const TemporaryFolder folder;
  std::string text = kSmall;
  text += std::string(5000, '\n');
  const std::string path = folder.path("a.mtx.gz");
  const std::string whole = text_of(gzip(path, text));
  for (std::size_t length = 3; length < whole.size(); ++length) {
    folder.write("a.mtx.gz", whole.substr(0, length));
    EXPECT_NE(refusal(path), "accepted") << length << " of " << whole.size() << " bytes";
  }
  std::string damaged = whole;
  damaged[damaged.size() - 6] ^= 1;  // checksum
  folder.write("a.mtx.gz", damaged);
  EXPECT_THAT(refusal(path), HasSubstr("the gzip stream is damaged"));
  folder.write("a.mtx.gz", whole.substr(0, whole.size() - 1));
  EXPECT_THAT(refusal(path), HasSubstr("the gzip stream is cut off"));
}

// Members one after another are one text (RFC 1952); anything else behind the last one is no part of the
// file.
TEST(MatrixMarketFiles, WhatFollowsAGzipStream) {
  const TemporaryFolder folder;
  const std::string text = kSmall, path = folder.path("a.mtx.gz");
  const std::string first = text_of(gzip(path, text.substr(0, 50))),
                    second = text_of(gzip(path, text.substr(50))), whole = text_of(gzip(path, text));
  folder.write("a.mtx.gz", first + second);
  EXPECT_THAT(values_of(path), ElementsAre(3, 4));
  for (const std::string& tail : {std::string("x"), std::string(1, '\0'), std::string(600000, '\0'), text,
                                  std::string("\x1f\x8b junk"), second.substr(0, 12)}) {
    folder.write("a.mtx.gz", whole + tail);
    EXPECT_THAT(refusal(path), testing::HasSubstr("gzip stream")) << tail.substr(0, 20);
  }
}

// What the format's definition says about files that other projects test their readers with: "accepted", or
// how the message begins.
const std::map<std::string, std::string> kVerdicts{
    // four words in the banner where five are needed (the fourth is no field)
    {"resolve_missing_field_and_truncated.mtx", "line 1: the banner's field 'general'"},
    {"russell_bad_many_lines.mtx", "line 5: more than the promised 2 entries"},
    {"russell_bad_missing_data.mtx", "line 3: the file ends after 0 of 1 entries"},
    {"russell_bad_not_complex_hermitian.mtx", "line 1: a hermitian file must be complex"},
    {"russell_bad_symmetric_rectangular_complex.mtx", "line 2: the symmetry asks for a square matrix"},
    {"russell_bad_wrong_dims_complex.mtx", "line 2: a matrix of 0 x 1 has no room"},
    // its name says ok, but comments end where the sizes begin
    {"russell_ok_complex_general.mtx", "line 19: a comment after the size line"},
    {"russell_ok_complex_symmetric_small.mtx", "accepted"},
    // its name says ok, but indices begin at 1
    {"russell_ok_rectangular.mtx", "line 4: row 0 is not in 1..2"},
    {"russell_ok_simple_general.mtx", "accepted"},
    {"russell_ok_symmetric.mtx", "accepted"},
    // a sixth word, which changes the meaning of all indices
    {"sprs_real_upper_0base.mtx", "line 1: unexpected '0-base'"},
    {"ss_chol_1e99", "accepted"},
    {"ss_chol_c30lo_singular", "line 1: not a Matrix Market file"},
    {"ss_chol_crud2", "line 1: not a Matrix Market file"},
    {"ss_chol_int_overflow.tri", "line 1: not a Matrix Market file"},
    {"ss_chol_mangle2.mtx", "line 1: the banner's format 'junk'"},
    {"ss_chol_mangle4.mtx", "line 1: the banner's symmetry 'junk'"},
    {"ss_chol_mangle6.tri", "line 1: not a Matrix Market file"},
    {"ss_chol_mangle8.tri", "line 1: not a Matrix Market file"},
    // the second line is a comment like any other; the value nan is for the solver to refuse, with its place
    {"ss_lag_comments_west0067.mtx", "accepted"},
    {"ss_lag_empty.mtx", "accepted"},
    {"ss_lag_full_noheader.mtx", "line 1: not a Matrix Market file"},
    {"ss_lag_mangled1.mtx", "line 1: the banner's object 'mangled'"},
    {"ss_lag_mangled11.mtx", "line 5: column 'zero' is not an integer"},
    {"ss_lag_mangled13.mtx", "line 7: column 9999 is not in 1..4"},
    // a real array has one value per line, here are two
    {"ss_lag_mangled15.mtx", "line 5: unexpected '.959'"},
    {"ss_lag_mangled2.mtx", "line 1: the banner's format 'mangled'"},
    {"ss_lag_mangled4.mtx", "line 1: the banner's symmetry 'mangled'"},
    {"ss_lag_mangled6.mtx", "line 1: a hermitian file must be complex"},
    {"ss_lag_mangled8.mtx", "line 4: the number of columns is missing"},
    // beyond the range of a type that only a comment names: integers all the same
    {"ss_lag_mangled_bool.mtx", "accepted"},
    {"ss_lag_mangled_int16.mtx", "accepted"},
    {"ss_lag_mangled_int8.mtx", "accepted"},
    {"ss_lag_mangled_uint16.mtx", "accepted"},
    {"ss_lag_mangled_uint8.mtx", "accepted"},
    {"ss_lag_structure.mtx", "accepted"},
    {"ss_lag_west0067_noheader.mtx", "line 1: not a Matrix Market file"},
};

TEST(MatrixMarketFiles, MalformedFilesByTheDefinition) {
  const std::string folder = matrix_folder() + "/malformed";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "MFS_MATRIX_DIR has no folder malformed";
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    const std::string name = file.path().filename().string();
    if (name == "manifest.csv") continue;
    const auto verdict = kVerdicts.find(name);
    ASSERT_NE(verdict, kVerdicts.end()) << name << " is new here: add what is expected";
    EXPECT_EQ(refusal(file.path().string()).substr(0, verdict->second.size()), verdict->second) << name;
  }
}

// One line of comma-separated values, quotes around what holds commas.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

TEST(MatrixMarketFiles, RealMatricesHaveTheShapeOfTheirManifest) {
  if (matrix_folder().empty()) GTEST_SKIP() << "MFS_MATRIX_DIR is not set";
  std::ifstream manifest(matrix_folder() + "/manifest.csv");
  std::string line;
  std::getline(manifest, line);
  ASSERT_EQ(line.substr(0, 44), "name,family,kind,n,m,nnz,stored_entries,fiel");
  int files = 0;
  for (; std::getline(manifest, line); ++files) {
    const std::vector<std::string> fields = fields_of(line);
    const MatrixMarket file = read_matrix_market(matrix_folder() + "/" + fields.at(0) + ".mtx.gz");
    SCOPED_TRACE(fields.at(0));
    EXPECT_EQ(std::to_string(file.header.rows), fields.at(3));
    EXPECT_EQ(std::to_string(file.header.columns), fields.at(4));
    EXPECT_EQ(std::to_string(file.header.listed), fields.at(6));
    const bool complex = std::holds_alternative<CsrMatrix<std::complex<double>>>(file.content);
    EXPECT_EQ(complex, fields.at(7) == "complex");
    const std::int64_t entries = complex ? std::get<CsrMatrix<std::complex<double>>>(file.content).entries()
                                         : std::get<CsrMatrix<double>>(file.content).entries();
    EXPECT_EQ(std::to_string(entries), fields.at(5));
  }
  EXPECT_GT(files, 0);
}

}  // namespace
