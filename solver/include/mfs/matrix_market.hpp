// Systems as Matrix Market files (Boisvert, Pozo, Remington, NISTIR 5935, 1996), for whoever wants to look at
// them with other tools. Numbers are written with 17 significant digits, so that reading gives the same ones
// back; NaN and infinity as "nan" and "inf".
#pragma once

#include <complex>
#include <cstdint>
#include <string>

#include <mfs/csr_view.hpp>
#include <mfs/export.hpp>

namespace mfs {

/// Writes `a` as a coordinate file, entries in their order, repeated ones apart; a pattern file if it has no
/// values. `comment` is one line. Throws InvalidInput: offsets or columns that are none (before a file is
/// made), or `path` cannot be written to its end (then a part of it may be there; no reader takes that for a
/// whole file).
template <class Scalar>
MFS_API void write_matrix_market(const std::string& path, const CsrView<Scalar>& a,
                                 const std::string& comment);

/// Writes rows x columns numbers, column-major with leading dimension `ld`, as an array file.
/// Throws InvalidInput if `path` cannot be written to its end.
template <class Scalar>
MFS_API void write_matrix_market(const std::string& path, const Scalar* values, std::int64_t rows,
                                 std::int64_t columns, std::int64_t ld, const std::string& comment);

}  // namespace mfs
