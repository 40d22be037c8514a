// Writes systems as Matrix Market files (Boisvert, Pozo, Remington, NISTIR 5935, 1996), which other tools
// read. Numbers have 17 significant digits, so that reading returns the same ones. NaN and infinity are
// written as "nan" and "inf".
#pragma once

#include <complex>
#include <cstdint>
#include <cstdio>
#include <string>

#include <mfs/csr_view.hpp>
#include <mfs/export.hpp>

namespace mfs {

/// Writes `a` as a coordinate file, or as a pattern file where it has no values. Entries keep their order,
/// and repeated entries are not summed. Each line of `comment` becomes a comment line. Throws InvalidInput
/// where offsets or columns are invalid, or where `path` cannot be written to its end. The file that was
/// there before is then unchanged, because the text goes to a temporary file that replaces it at the end.
template <class Scalar>
MFS_API void write_matrix_market(const std::string& path, const CsrView<Scalar>& a,
                                 const std::string& comment);
/// The same to a stream, which stays open. What was written before an error stays written.
template <class Scalar>
MFS_API void write_matrix_market(std::FILE* stream, const CsrView<Scalar>& a, const std::string& comment);

/// Writes rows x columns numbers, column-major with leading dimension `ld` of at least rows, as an array
/// file. Comment and errors are as above.
template <class Scalar>
MFS_API void write_matrix_market(const std::string& path, const Scalar* values, std::int64_t rows,
                                 std::int64_t columns, std::int64_t ld, const std::string& comment);
template <class Scalar>
MFS_API void write_matrix_market(std::FILE* stream, const Scalar* values, std::int64_t rows,
                                 std::int64_t columns, std::int64_t ld, const std::string& comment);

}  // namespace mfs
