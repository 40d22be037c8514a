// Banner, comments and size line of a Matrix Market file.
#pragma once

#include <cstdint>
#include <string_view>

#include "solver/program/matrix_market.hpp"

namespace mfs::io {

/// Takes the lines of a file one by one until the size line is through.
class HeaderParser {
 public:
  /// True once the header is complete. Throws TextError with the line.
  bool take(std::string_view line);
  /// Lines taken so far.
  std::int64_t lines() const { return lines_; }
  const Header& header() const { return header_; }
  /// Throws TextError: the text ended before the size line.
  [[noreturn]] void ended() const;

 private:
  void parse_banner(std::string_view line);
  void parse_size(std::string_view line);

  Header header_;
  std::int64_t lines_ = 0;
};

}  // namespace mfs::io
