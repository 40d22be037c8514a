// The data lines of a Matrix Market file: blocks of text become blocks of entries, in parallel.
#pragma once

#include <complex>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "solver/program/matrix_market.hpp"
#include "solver/program/text_blocks.hpp"

namespace mfs::io {

/// Entries in the order of the file, indices 0-based. An array file fills `values` alone, a pattern file all
/// but `values`.
template <class Scalar>
struct EntryBlock {
  std::vector<std::int32_t> rows, columns;
  std::vector<Scalar> values;
  std::int64_t entries = 0;
  std::int64_t lines = 0;
};

/// Reads what follows the size line: `text` is the rest of the block in which that line was, `lines` counts
/// the lines before it. Throws TextError (line known) for a line that breaks a rule of the definition, and
/// for more or fewer entries than the header promised.
template <class Scalar>
std::vector<EntryBlock<Scalar>> read_entries(const Header& header, BlockReader& blocks, std::string text,
                                             std::int64_t lines, int threads);

}  // namespace mfs::io
