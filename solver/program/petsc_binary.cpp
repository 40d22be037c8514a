#include "solver/program/petsc_binary.hpp"

#include <cstring>
#include <limits>
#include <string>
#include <utility>

namespace mfs::io {
namespace {

constexpr std::uint32_t kMatrix = 1211216, kVector = 1211214;  // MAT_FILE_CLASSID, VEC_FILE_CLASSID
constexpr std::size_t kBlock = std::size_t{4} << 20;

std::uint64_t big_endian(const char* at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < bytes; ++k) value = value << 8 | static_cast<unsigned char>(at[k]);
  return value;
}

/// Bytes of an integer of the file; 0 where it is no such file.
std::size_t integer_bytes(std::string_view head) {
  const auto known = [](std::uint64_t number) { return number == kMatrix || number == kVector; };
  if (head.size() >= 4 && known(big_endian(head.data(), 4))) return 4;
  if (head.size() >= 8 && known(big_endian(head.data(), 8))) return 8;
  return 0;
}

/// The bytes of the whole file, taken one after another.
class Bytes {
 public:
  explicit Bytes(TextSource& source) {
    // Memory follows what the file holds, not what its header promises.
    std::size_t filled = 0, got = 0;
    do {
      filled += got;
      if (text_.size() - filled < kBlock) text_.resize(text_.size() + text_.size() / 2 + 2 * kBlock);
      got = source.read(text_.data() + filled, text_.size() - filled);
    } while (got > 0);
    text_.resize(filled);
    integer_bytes_ = integer_bytes(text_);
  }
  std::uint64_t left() const { return text_.size() - at_; }
  std::uint64_t integer_bytes_of(std::uint64_t count) const { return count * integer_bytes_; }
  std::int64_t integer() {
    if (left() < integer_bytes_) throw TextError("the file is cut off");
    const std::uint64_t value = big_endian(text_.data() + at_, integer_bytes_);
    at_ += integer_bytes_;
    return integer_bytes_ == 4 ? static_cast<std::int32_t>(value) : static_cast<std::int64_t>(value);
  }
  double real() {
    const std::uint64_t bits = big_endian(text_.data() + at_, 8);
    at_ += 8;
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  void take(double& value) { value = real(); }
  void take(std::complex<double>& value) {
    const double real_part = real();
    value = {real_part, real()};
  }

 private:
  std::string text_;
  std::size_t at_ = 0, integer_bytes_ = 0;
};

std::int64_t size(Bytes& bytes, const char* what) {
  const std::int64_t value = bytes.integer();
  if (value < 0 || value > std::numeric_limits<std::int32_t>::max())
    throw TextError(std::string(what) + ": " + std::to_string(value) + " is not from 0 to 2^31 - 1");
  return value;
}

/// Field of `count` values that end the file behind `before` bytes.
Field field_of(const Bytes& bytes, std::uint64_t before, std::uint64_t count) {
  const std::uint64_t left = bytes.left();
  if (left == before + 8 * count) return Field::real;
  if (left == before + 16 * count) return Field::complex;
  throw TextError(left < before + 8 * count ? "the file is cut off"
                                            : "the file is longer than what its header promises");
}

void check(const Header& header, const ReadOptions& options) {
  const std::string reason = options.refuse ? options.refuse(header) : "";
  if (!reason.empty()) throw TextError(reason);
}

template <class Scalar>
CsrMatrix<Scalar> take_matrix(Bytes& bytes, const Header& header) {
  CsrMatrix<Scalar> a;
  a.rows = header.rows;
  a.columns = header.columns;
  a.offsets.assign(static_cast<std::size_t>(a.rows) + 1, 0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.rows); ++i) {
    const std::int64_t length = bytes.integer();
    if (length < 0 || length > header.listed - a.offsets[i])
      throw TextError("row " + std::to_string(i + 1) + " has " + std::to_string(length) + " entries of " +
                      std::to_string(header.listed));
    a.offsets[i + 1] = a.offsets[i] + length;
  }
  if (a.entries() != header.listed)
    throw TextError("the rows have " + std::to_string(a.entries()) + " entries, not " +
                    std::to_string(header.listed));
  a.column_indices.resize(static_cast<std::size_t>(header.listed));
  for (std::int32_t& column : a.column_indices) {
    const std::int64_t value = bytes.integer();
    if (value < 0 || value >= a.columns)
      throw TextError("column " + std::to_string(value) + " is not in 0.." + std::to_string(a.columns - 1));
    column = static_cast<std::int32_t>(value);
  }
  a.values.resize(static_cast<std::size_t>(header.listed));
  for (Scalar& value : a.values) bytes.take(value);
  return a;
}

MatrixMarket read_matrix(Bytes& bytes, const ReadOptions& options) {
  Header header;
  header.rows = size(bytes, "rows");
  header.columns = size(bytes, "columns");
  header.listed = bytes.integer();
  if (header.listed == -1) throw TextError("a dense matrix is read from a Matrix Market file");
  if (header.listed < 0 || header.listed > std::numeric_limits<std::int64_t>::max() / 64)
    throw TextError("entries: " + std::to_string(header.listed) + " is no number of entries");
  const auto entries = static_cast<std::uint64_t>(header.listed);
  header.field =
      field_of(bytes, bytes.integer_bytes_of(static_cast<std::uint64_t>(header.rows) + entries), entries);
  check(header, options);
  if (header.field == Field::complex) return {header, take_matrix<std::complex<double>>(bytes, header)};
  return {header, take_matrix<double>(bytes, header)};
}

template <class Scalar>
DenseMatrix<Scalar> take_vector(Bytes& bytes, std::int64_t rows) {
  DenseMatrix<Scalar> vector{rows, 1, std::vector<Scalar>(static_cast<std::size_t>(rows))};
  for (Scalar& value : vector.values) bytes.take(value);
  return vector;
}

MatrixMarket read_vector(Bytes& bytes, const ReadOptions& options) {
  Header header;
  header.format = Format::array;
  header.rows = header.listed = size(bytes, "rows");
  header.columns = 1;
  header.field = field_of(bytes, 0, static_cast<std::uint64_t>(header.rows));
  check(header, options);
  if (header.field == Field::complex) return {header, take_vector<std::complex<double>>(bytes, header.rows)};
  return {header, take_vector<double>(bytes, header.rows)};
}

}  // namespace

bool is_petsc_binary(std::string_view head) {
  return integer_bytes(head) > 0;
}

MatrixMarket read_petsc_binary(TextSource& source, const ReadOptions& options) {
  Bytes bytes(source);
  return bytes.integer() == kMatrix ? read_matrix(bytes, options) : read_vector(bytes, options);
}

}  // namespace mfs::io
