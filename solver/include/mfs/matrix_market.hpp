// Systems as Matrix Market files (Boisvert, Pozo, Remington, NISTIR 5935, 1996), for whoever wants to look at
// them with other tools. Numbers are written with 17 significant digits, so that reading gives the same ones
// back; NaN and infinity as "nan" and "inf".
#pragma once

#include <complex>
#include <cstdint>
#include <cstdio>
#include <string>

#include <mfs/csr_view.hpp>
#include <mfs/export.hpp>

namespace mfs {

/// Writes `a` as a coordinate file, entries in their order, repeated ones apart; a pattern file if it has no
/// values. Each line of `comment` becomes a comment line. Throws InvalidInput: offsets or columns that are
/// none (before a file is made), or `path` cannot be written to its end; then what was there before is still
/// there, because the text goes to a file beside `path` that takes its place at the end.
template <class Scalar>
MFS_API void write_matrix_market(const std::string& path, const CsrView<Scalar>& a,
                                 const std::string& comment);
/// The same to a stream, which stays open: what was written before an error has left.
template <class Scalar>
MFS_API void write_matrix_market(std::FILE* stream, const CsrView<Scalar>& a, const std::string& comment);

/// Writes rows x columns numbers, column-major with leading dimension `ld`, as an array file. Comment and
/// errors as above.
template <class Scalar>
MFS_API void write_matrix_market(const std::string& path, const Scalar* values, std::int64_t rows,
                                 std::int64_t columns, std::int64_t ld, const std::string& comment);
template <class Scalar>
MFS_API void write_matrix_market(std::FILE* stream, const Scalar* values, std::int64_t rows,
                                 std::int64_t columns, std::int64_t ld, const std::string& comment);

}  // namespace mfs
