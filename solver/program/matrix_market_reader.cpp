// From a file to a matrix: header, entries, assembly.
#include <algorithm>
#include <limits>
#include <utility>

#include <mfs/error.hpp>
#include <mfs/threads.hpp>

#include "solver/program/matrix_market.hpp"
#include "solver/program/matrix_market_entries.hpp"
#include "solver/program/matrix_market_header.hpp"
#include "solver/program/petsc_binary.hpp"
#include "solver/program/text_blocks.hpp"

namespace mfs::io {
namespace {

using Complex = std::complex<double>;

constexpr std::int64_t kToleratedEmptyRows = 1 << 20;
constexpr int kMostThreads = 16;  // more only hold blocks that wait for the one that reads

double mirrored(Symmetry symmetry, double value) {
  return symmetry == Symmetry::skew_symmetric ? -value : value;
}
Complex mirrored(Symmetry symmetry, const Complex& value) {
  if (symmetry == Symmetry::hermitian) return std::conj(value);
  return symmetry == Symmetry::skew_symmetric ? -value : value;
}

template <class Scalar>
std::int64_t first_empty_row(const std::vector<EntryBlock<Scalar>>& blocks, bool mirror,
                             std::int64_t stored) {
  std::vector<bool> seen(static_cast<std::size_t>(stored) + 1, false);
  const auto mark = [&](std::int32_t row) {
    if (row <= stored) seen[static_cast<std::size_t>(row)] = true;
  };
  for (const EntryBlock<Scalar>& block : blocks) {
    std::for_each(block.rows.begin(), block.rows.end(), mark);
    if (mirror) std::for_each(block.columns.begin(), block.columns.end(), mark);
  }
  return std::find(seen.begin(), seen.end(), false) - seen.begin();
}

// Row offsets take memory by the header's word: refuse a header that has little to do with the entries.
template <class Scalar>
void check_empty_rows(const Header& header, const std::vector<EntryBlock<Scalar>>& blocks,
                      const std::string& name) {
  const bool mirror = header.symmetry != Symmetry::general;
  const std::int64_t stored = (mirror ? 2 : 1) * header.listed;
  const std::int64_t empty = header.rows - stored;
  if (empty <= kToleratedEmptyRows) return;
  const std::string what = "the header claims " + std::to_string(header.rows) + " rows, but at least " +
                           std::to_string(empty) + " of them have no entry";
  if (header.rows != header.columns) throw InvalidInput(name, what);
  throw SingularMatrix(SingularMatrix::Kind::structural, first_empty_row(blocks, mirror, stored), -1, empty,
                       name + ": " + what);
}

template <class Scalar>
CsrMatrix<Scalar> assemble_csr(const Header& header, std::vector<EntryBlock<Scalar>> blocks) {
  const bool mirror = header.symmetry != Symmetry::general;
  CsrMatrix<Scalar> a;
  a.rows = header.rows;
  a.columns = header.columns;
  a.offsets.assign(static_cast<std::size_t>(header.rows) + 1, 0);
  for (const EntryBlock<Scalar>& block : blocks)
    for (std::size_t k = 0; k < block.rows.size(); ++k) {
      ++a.offsets[static_cast<std::size_t>(block.rows[k]) + 1];
      if (mirror && block.rows[k] != block.columns[k])
        ++a.offsets[static_cast<std::size_t>(block.columns[k]) + 1];
    }
  for (std::size_t row = 1; row < a.offsets.size(); ++row) a.offsets[row] += a.offsets[row - 1];

  const std::size_t entries = static_cast<std::size_t>(a.entries());
  a.column_indices.resize(entries);
  if (header.field != Field::pattern) a.values.resize(entries);
  std::vector<std::int64_t> next(a.offsets.begin(), a.offsets.end() - 1);
  const auto put = [&](std::int32_t row, std::int32_t column) {
    const std::size_t slot = static_cast<std::size_t>(next[static_cast<std::size_t>(row)]++);
    a.column_indices[slot] = column;
    return slot;
  };
  for (EntryBlock<Scalar>& block : blocks) {
    for (std::size_t k = 0; k < block.rows.size(); ++k) {
      const std::int32_t row = block.rows[k], column = block.columns[k];
      const std::size_t slot = put(row, column);
      if (!a.values.empty()) a.values[slot] = block.values[k];
      if (!mirror || row == column) continue;
      const std::size_t other = put(column, row);
      if (!a.values.empty()) a.values[other] = mirrored(header.symmetry, block.values[k]);
    }
    block = {};
  }
  return a;
}

template <class Scalar>
DenseMatrix<Scalar> assemble_dense(const Header& header, const std::vector<EntryBlock<Scalar>>& blocks) {
  DenseMatrix<Scalar> a{header.rows, header.columns, {}};
  a.values.resize(static_cast<std::size_t>(header.rows) * static_cast<std::size_t>(header.columns));
  const bool mirror = header.symmetry != Symmetry::general;
  const std::int64_t below = header.symmetry == Symmetry::skew_symmetric ? 1 : 0;
  const std::size_t ld = static_cast<std::size_t>(header.rows);
  std::size_t row = static_cast<std::size_t>(below), column = 0;
  for (const EntryBlock<Scalar>& block : blocks)
    for (const Scalar& value : block.values) {
      a.values[column * ld + row] = value;
      if (mirror && row != column) a.values[row * ld + column] = mirrored(header.symmetry, value);
      if (++row < ld) continue;
      ++column;
      row = mirror ? column + static_cast<std::size_t>(below) : 0;
    }
  return a;
}

void check_hermitian_diagonal(const Header& header, const DenseMatrix<Complex>& a) {
  if (header.symmetry != Symmetry::hermitian) return;
  for (std::int64_t i = 0; i < a.rows; ++i)
    if (a.values[static_cast<std::size_t>(i * a.rows + i)].imag() != 0)
      throw TextError("the diagonal of a hermitian matrix is real, not so in row " + std::to_string(i + 1));
}
void check_hermitian_diagonal(const Header&, const DenseMatrix<double>&) {}

struct HeaderAndRest {
  Header header;
  std::int64_t lines = 0;
  std::string rest;  // of the block that holds the size line
};

HeaderAndRest read_header(BlockReader& blocks) {
  HeaderParser parser;
  std::string block;
  while (blocks.next(block)) {
    for (std::size_t begin = 0; begin < block.size();) {
      const std::size_t end = std::min(block.find('\n', begin), block.size());
      const bool complete = parser.take(std::string_view(block).substr(begin, end - begin));
      begin = std::min(end + 1, block.size());
      if (complete) return {parser.header(), parser.lines(), block.substr(begin)};
    }
  }
  parser.ended();
}

template <class Scalar>
Content read_content(const HeaderAndRest& top, BlockReader& blocks, const std::string& name, int threads) {
  std::vector<EntryBlock<Scalar>> entries =
      read_entries<Scalar>(top.header, blocks, top.rest, top.lines, threads);
  if (top.header.format == Format::coordinate) {
    check_empty_rows(top.header, entries, name);
    return assemble_csr(top.header, std::move(entries));
  }
  DenseMatrix<Scalar> dense = assemble_dense(top.header, entries);
  check_hermitian_diagonal(top.header, dense);
  return dense;
}

int threads_to_use(int asked) {
  return std::clamp(asked > 0 ? asked : default_threads(), 1, kMostThreads);
}

template <class Open>
MatrixMarket read(const Open& open, const std::string& name, const ReadOptions& options) {
  try {
    const std::unique_ptr<TextSource> opened = open();
    PeekedSource source(*opened, kPetscHead);
    if (is_petsc_binary(source.head())) return read_petsc_binary(source, options);
    BlockReader blocks(source, std::max<std::size_t>(options.block_bytes, 1));
    const HeaderAndRest top = read_header(blocks);
    const std::string reason = options.refuse ? options.refuse(top.header) : "";
    if (!reason.empty()) throw TextError(reason, top.lines);
    const int threads = threads_to_use(options.threads);
    if (top.header.field == Field::complex)
      return {top.header, read_content<Complex>(top, blocks, name, threads)};
    return {top.header, read_content<double>(top, blocks, name, threads)};
  } catch (const TextError& e) {
    const std::string line = e.line() > 0 ? "line " + std::to_string(e.line()) + ": " : "";
    throw InvalidInput(name, line + e.what());
  }
}

std::string not_square(const Header& h) {
  if (h.rows == h.columns) return "";
  return "the matrix is not square: " + std::to_string(h.rows) + " x " + std::to_string(h.columns);
}

std::string no_values(const Header& h) {
  return h.field == Field::pattern ? "the file is a pattern: it has no values" : "";
}

// Every value of a dense matrix is an entry of the sparse one, zeros too.
template <class Scalar>
CsrMatrix<Scalar> sparse(const DenseMatrix<Scalar>& dense) {
  CsrMatrix<Scalar> a;
  a.rows = dense.rows;
  a.columns = dense.columns;
  for (std::int64_t i = 0; i <= a.rows; ++i) a.offsets.push_back(i * a.columns);
  a.column_indices.reserve(dense.values.size());
  a.values.reserve(dense.values.size());
  for (std::int64_t i = 0; i < a.rows; ++i)
    for (std::int64_t j = 0; j < a.columns; ++j) {
      a.column_indices.push_back(static_cast<std::int32_t>(j));
      a.values.push_back(dense.values[static_cast<std::size_t>(j * a.rows + i)]);
    }
  return a;
}

template <class Scalar>
CsrMatrix<Scalar> sparse(CsrMatrix<Scalar> a) {
  return a;
}

SquareMatrix read_square(const std::string& path, int threads, bool pattern_suffices) {
  ReadOptions strict;
  strict.threads = threads;
  strict.refuse = [pattern_suffices](const Header& h) {
    const std::string reason = pattern_suffices ? "" : no_values(h);
    return reason.empty() ? not_square(h) : reason;
  };
  MatrixMarket file = read_matrix_market(path, strict);
  return std::visit([](auto& content) { return SquareMatrix(sparse(std::move(content))); }, file.content);
}

}  // namespace

MatrixMarket read_matrix_market(const std::string& path, const ReadOptions& options) {
  return read([&] { return open_file(path); }, path == "-" ? "standard input" : path, options);
}

MatrixMarket parse_matrix_market(std::string_view text, const std::string& name, const ReadOptions& options) {
  return read([&] { return open_memory(text); }, name, options);
}

SquareMatrix read_square_matrix(const std::string& path, int threads) {
  return read_square(path, threads, false);
}

SquareMatrix read_square_pattern(const std::string& path, int threads) {
  return read_square(path, threads, true);
}

template <class Scalar>
DenseMatrix<Scalar> read_right_hand_sides(const std::string& path, std::int64_t rows, int threads) {
  ReadOptions strict;
  strict.threads = threads;
  strict.refuse = [rows](const Header& h) {
    if (h.format != Format::array) return std::string("right-hand sides are read from an array file");
    if (h.rows != rows || h.columns == 0)
      return "right-hand sides of " + std::to_string(rows) + " rows are needed, the file holds " +
             std::to_string(h.rows) + " x " + std::to_string(h.columns);
    if (h.field == Field::complex && std::is_same_v<Scalar, double>)
      return std::string("the right-hand sides are complex, the matrix is real");
    return std::string();
  };
  MatrixMarket file = read_matrix_market(path, strict);
  if (auto* same = std::get_if<DenseMatrix<Scalar>>(&file.content)) return std::move(*same);
  const auto& real = std::get<DenseMatrix<double>>(file.content);
  return {real.rows, real.columns, std::vector<Scalar>(real.values.begin(), real.values.end())};
}

template DenseMatrix<double> read_right_hand_sides(const std::string&, std::int64_t, int);
template DenseMatrix<Complex> read_right_hand_sides(const std::string&, std::int64_t, int);

}  // namespace mfs::io
