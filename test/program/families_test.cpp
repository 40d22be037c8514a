// The benchmark families never change. The checksums are those of the families' definition, on which the
// project's first measurements were made.
#include "cases/families.hpp"

#include <cstring>
#include <ostream>

#include <gmock/gmock.h>

#include <mfs/error.hpp>

namespace {

using mfs::cases::FamilyMatrix;
using mfs::cases::make_family;

struct Checksums {
  const char* family;
  int size;
  std::int64_t n;
  std::size_t entries;
  double sum;             // of the values, first to last
  std::uint64_t pattern;  // FNV-1a of offsets and columns, each as eight bytes
  std::uint64_t values;   // FNV-1a of the values' bits
};

std::ostream& operator<<(std::ostream& out, const Checksums& c) {
  return out << c.family << ":" << c.size;
}

class Hash {
 public:
  void add(std::uint64_t word) {
    for (int byte = 0; byte < 8; ++byte) value_ = (value_ ^ (word >> (8 * byte) & 255)) * 0x100000001b3ULL;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

std::uint64_t pattern_hash(const FamilyMatrix& a) {
  Hash hash;
  for (const std::int64_t offset : a.offsets) hash.add(static_cast<std::uint64_t>(offset));
  for (const std::int32_t column : a.column_indices) hash.add(static_cast<std::uint64_t>(column));
  return hash.value();
}

std::uint64_t value_hash(const FamilyMatrix& a) {
  Hash hash;
  for (const double value : a.values) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    hash.add(bits);
  }
  return hash.value();
}

class Families : public testing::TestWithParam<Checksums> {};

TEST_P(Families, AreTheSameToTheLastBit) {
  const Checksums& expected = GetParam();
  const FamilyMatrix a = make_family(expected.family, expected.size);
  EXPECT_EQ(a.n, expected.n);
  EXPECT_EQ(a.offsets.size(), static_cast<std::size_t>(expected.n) + 1);
  EXPECT_EQ(a.values.size(), expected.entries);
  EXPECT_EQ(a.column_indices.size(), expected.entries);
  double sum = 0;
  for (const double value : a.values) sum += value;
  EXPECT_EQ(sum, expected.sum);
  EXPECT_EQ(pattern_hash(a), expected.pattern);
  EXPECT_EQ(value_hash(a), expected.values);
}

// kkt:5 ties every unknown to a constraint, some twice; kkt:14 leaves some free. circuit:99 swaps two pairs
// of rows, the second at its end.
INSTANTIATE_TEST_SUITE_P(
    , Families,
    testing::Values(
        Checksums{"elas3d", 1, 3, 3, 0x1.e0013a92a3055p+4, 0x689e5033e92ddd86, 0x52a2a6ec40894fad},
        Checksums{"elas3d", 2, 24, 576, 0x1.e0027525460acp+6, 0x14fe8a5bdd935394, 0xf91c93d719e4658c},
        Checksums{"elas3d", 7, 1029, 61731, 0x1.6f8695e9e181fp+10, 0xec36097907ac68a5, 0xf7d70a0affe64dc9},
        Checksums{"beam3d", 3, 648, 30870, 0x1.0e1096bb98be9p+8, 0x55f549be4e574e07, 0xe569a11f044dfcc4},
        Checksums{"kkt", 1, 6, 12, 0x1.b030eb55516cfp+4, 0xaa756c2bed9f27cb, 0xf53f8af975877f7d},
        Checksums{"kkt", 5, 450, 20598, 0x1.7e7244705bfap+9, 0x115cacbf34ff8fdf, 0x9b533eb070fd76ec},
        Checksums{"kkt", 14, 8820, 590700, 0x1.7551c42301b4cp+12, 0x10c36e5ef90952f6, 0x6e137cea8efab70c},
        Checksums{"convdiff3d", 1, 1, 1, 0x1.44p+6, 0x32d42a0eed270ac4, 0x7d4c0030ed287251},
        Checksums{"convdiff3d", 12, 1728, 11232, 0x1.e534e70b4c07ep+10, 0xc3f66db97975a4e0,
                  0x5adfcac08e5c6305},
        Checksums{"poisson2d", 1, 1, 1, 0x1p+2, 0x32d42a0eed270ac4, 0xa891583227eb9a75},
        Checksums{"poisson2d", 30, 900, 4380, 0x1.ep+6, 0x1df586c8ffcb538c, 0x14b979bc7b87ae65},
        Checksums{"circuit", 1, 1, 1, 0x1.0624dd2f1a9fcp-10, 0x32d42a0eed270ac4, 0xf1db32c1d0618ccf},
        Checksums{"circuit", 99, 99, 441, 0x1.95810624dd3p-4, 0xab3cfd93f1ce235d, 0x7395a66e54dbcbc3},
        Checksums{"circuit", 3000, 3000, 15589, 0x1.7fffffffff81p+1, 0x736fdbb478f6ecc2, 0x91cf480f9f40383e}),
    [](const auto& info) { return std::string(info.param.family) + "_" + std::to_string(info.param.size); });

TEST(FamilyErrors, UnknownNameAndImpossibleSizes) {
  EXPECT_THROW(make_family("elas2d", 3), mfs::InvalidInput);
  for (const std::string& name : mfs::cases::family_names()) {
    EXPECT_THROW(make_family(name, 0), mfs::InvalidInput) << name;
    EXPECT_THROW(make_family(name, -1), mfs::InvalidInput) << name;
    EXPECT_THROW(make_family(name, std::int64_t{1} << 32), mfs::InvalidInput) << name;
  }
  EXPECT_THROW(make_family("elas3d", 895), mfs::InvalidInput);  // 3 * 895^3 > 2^31 - 1 >= 3 * 894^3
}

}  // namespace
