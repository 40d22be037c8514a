// Any bytes as a Matrix Market file: read or refused, never worse; the same whatever the blocks; what is read
// is a matrix. Entry point of libFuzzer (preset fuzz) and of replay_corpus.cpp.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <variant>

#include <mfs/error.hpp>

#include "solver/program/matrix_market.hpp"

namespace {

using namespace mfs::io;

void require(bool condition) {
  if (!condition) std::abort();
}

template <class T>
bool same_bits(const std::vector<T>& x, const std::vector<T>& y) {
  return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(T)) == 0);
}

template <class Scalar>
bool same(const CsrMatrix<Scalar>& x, const CsrMatrix<Scalar>& y) {
  return x.rows == y.rows && x.columns == y.columns && same_bits(x.offsets, y.offsets) &&
         same_bits(x.column_indices, y.column_indices) && same_bits(x.values, y.values);
}

template <class Scalar>
bool same(const DenseMatrix<Scalar>& x, const DenseMatrix<Scalar>& y) {
  return x.rows == y.rows && x.columns == y.columns && same_bits(x.values, y.values);
}

template <class Scalar>
void check(const Header& header, const CsrMatrix<Scalar>& a) {
  require(a.offsets.size() == static_cast<std::size_t>(header.rows) + 1 && a.offsets.front() == 0);
  for (std::size_t row = 1; row < a.offsets.size(); ++row) require(a.offsets[row - 1] <= a.offsets[row]);
  require(static_cast<std::size_t>(a.entries()) == a.column_indices.size());
  for (const std::int32_t column : a.column_indices) require(column >= 0 && column < header.columns);
  require(a.values.size() == (header.field == Field::pattern ? 0 : a.column_indices.size()));
  const std::int64_t most = (header.symmetry == Symmetry::general ? 1 : 2) * header.listed;
  require(header.listed <= a.entries() && a.entries() <= most);
}

template <class Scalar>
void check(const Header& header, const DenseMatrix<Scalar>& a) {
  require(a.rows == header.rows && a.columns == header.columns);
  require(a.values.size() == static_cast<std::size_t>(a.rows * a.columns));
}

struct Outcome {
  std::string refusal;
  MatrixMarket file;
};

Outcome outcome(std::string_view text, std::size_t block_bytes) {
  ReadOptions options;
  options.threads = 1;
  options.block_bytes = block_bytes;
  Outcome result;
  try {
    result.file = parse_matrix_market(text, "fuzz", options);
  } catch (const mfs::Error& e) {
    result.refusal = e.what();
  }
  return result;
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const Outcome whole = outcome(text, std::size_t{1} << 16);
  const Outcome pieces = outcome(text, 1 + size % 17);
  require(whole.refusal == pieces.refusal);
  if (!whole.refusal.empty()) return 0;
  std::visit(
      [&](const auto& a) {
        check(whole.file.header, a);
        require(same(a, std::get<std::decay_t<decltype(a)>>(pieces.file.content)));
      },
      whole.file.content);
  return 0;
}
