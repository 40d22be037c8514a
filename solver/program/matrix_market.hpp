// Matrix Market files: how matrices and vectors come into the program (mfs/matrix_market.hpp is how they
// leave it).
//
// A file is lines of text (the definition: Boisvert, Pozo, Remington, "The Matrix Market Exchange Formats:
// Initial Design", NISTIR 5935, 1996):
//
//   %%MatrixMarket matrix coordinate real symmetric     banner: object, format, field, symmetry
//   % any number of comment lines
//   3 3 4                                               size: rows columns entries   (array: rows columns)
//   1 1  4.0                                            one entry per line: row column value, 1-based
//   2 1 -1.0                                            (array: one value per line, column by column)
//   2 2  4.0
//   3 3  4.0
//
// What the definition says is kept to the letter where a guess could change the matrix: four words in the
// banner, no more and no less; exactly the promised number of entries, one per line with nothing after it;
// indices in range; a symmetric, skew-symmetric or Hermitian matrix is square and lists only entries on or
// below (skew: strictly below) the diagonal. An entry above the diagonal of such a file is refused: the other
// half might be listed as well, and mirroring would then double it. A Hermitian diagonal is real.
//
// More than the definition is accepted where no other reading is possible: lines of up to 1 MiB (1024
// characters there), tabs and carriage returns as blanks, blanks before a comment's percent sign, a plus
// sign, Fortran's D as exponent letter, a last line without its end. An entry listed twice stands for the
// sum, as finite element programs mean it; the entries are kept apart here. "nan" and "inf" are read as such:
// the solver refuses them with row and column.
//
// Memory follows the entries that a file really holds, never the numbers that its header promises. Text is
// read in blocks cut at line ends, and the blocks are parsed by several threads while the next one is read or
// inflated (the first bytes of a file decide whether it is gzip, not its name).
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <mfs/csr_view.hpp>

namespace mfs::io {

enum class Format { coordinate, array };
enum class Field { real, integer, complex, pattern };
enum class Symmetry { general, symmetric, skew_symmetric, hermitian };

/// What banner and size line say.
struct Header {
  Format format = Format::coordinate;
  Field field = Field::real;
  Symmetry symmetry = Symmetry::general;
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::int64_t listed = 0;  ///< data lines: of an array, as many as its shape and symmetry ask for
};

/// A sparse matrix with both triangles, entries of a row in the order of the file (mirrored ones as they
/// came).
template <class Scalar>
struct CsrMatrix {
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::vector<std::int64_t> offsets;         ///< rows + 1
  std::vector<std::int32_t> column_indices;  ///< offsets[rows], 0-based
  std::vector<Scalar> values;                ///< offsets[rows]; empty for a pattern file

  std::int64_t entries() const { return offsets.empty() ? 0 : offsets.back(); }
  CsrView<Scalar> view() const {
    return {rows, columns, offsets.data(), column_indices.data(), values.empty() ? nullptr : values.data()};
  }
};

/// A dense matrix, column-major, leading dimension rows.
template <class Scalar>
struct DenseMatrix {
  std::int64_t rows = 0;
  std::int64_t columns = 0;
  std::vector<Scalar> values;  ///< rows * columns
};

using Content = std::variant<CsrMatrix<double>, CsrMatrix<std::complex<double>>, DenseMatrix<double>,
                             DenseMatrix<std::complex<double>>>;

struct MatrixMarket {
  Header header;
  Content content;
};

struct ReadOptions {
  int threads = 0;                                 ///< that parse; 0 takes what the machine offers
  std::size_t block_bytes = std::size_t{4} << 20;  ///< text per block
  /// Looks at the header before any entry is read; a non-empty answer is the reason to refuse the file.
  std::function<std::string(const Header&)> refuse;
};

/// Reads a plain or gzip file, or standard input ("-"); a binary file of PETSc (petsc_binary.hpp), too.
/// Throws InvalidInput (its argument is the path, its text names the 1-based line), and SingularMatrix for a
/// square coordinate file whose header claims over a million rows more than it lists entries: the first of
/// its empty rows is named instead of storing them all.
MatrixMarket read_matrix_market(const std::string& path, const ReadOptions& options = {});
/// The same for text in memory; `name` stands for the path in messages.
MatrixMarket parse_matrix_market(std::string_view text, const std::string& name,
                                 const ReadOptions& options = {});

/// Real (or integer) and complex matrices.
using SquareMatrix = std::variant<CsrMatrix<double>, CsrMatrix<std::complex<double>>>;
/// Reads a square matrix, coordinate or array. Refuses others, and those without values, before their
/// entries.
SquareMatrix read_square_matrix(const std::string& path, int threads = 0);
/// The same where values are not needed: a pattern file is a real matrix with empty `values`.
SquareMatrix read_square_pattern(const std::string& path, int threads = 0);
/// Reads right-hand sides of a matrix of Scalar: an array file of `rows` rows. Real ones suit a complex
/// matrix, complex ones are refused for a real one.
template <class Scalar>
DenseMatrix<Scalar> read_right_hand_sides(const std::string& path, std::int64_t rows, int threads = 0);

}  // namespace mfs::io
