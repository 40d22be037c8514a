// Matrices and vectors as PETSc's binary viewer writes them (MatView, VecView): compressed rows that are read
// without parsing a number, for matrices that take minutes as text. All numbers are big-endian:
//
//   matrix   1211216   rows   columns   entries   row lengths (rows)   columns, 0-based (entries)   values
//   (entries) vector   1211214   rows   values (rows)
//
// Integers have 32 bits, or 64 in files of a PETSc with such indices; values are doubles, or pairs of them in
// files of a complex PETSc. The file does not say which: the length of an integer shows in the first one,
// that of a value in the length of the file.
#pragma once

#include <string_view>

#include "solver/program/matrix_market.hpp"
#include "solver/program/text_blocks.hpp"

namespace mfs::io {

/// As many bytes of a file as is_petsc_binary looks at.
constexpr std::size_t kPetscHead = 8;
/// Whether a file that begins with `head` is a matrix or a vector of this kind.
bool is_petsc_binary(std::string_view head);
/// Reads it: a coordinate matrix, or an array of one column. Throws TextError where the file is not one
/// matrix or vector from its first to its last byte, or where `refuse` (ReadOptions) gives a reason.
MatrixMarket read_petsc_binary(TextSource& source, const ReadOptions& options);

}  // namespace mfs::io
