// Reads the words and numbers of one line; inline, since every entry of a file passes here.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>

#include "solver/program/text_blocks.hpp"

namespace mfs::io {

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

/// A word of the file for a message: printable and short.
std::string quoted(std::string_view word);
/// The double nearest to `word`, for what std::from_chars leaves: exponent letter D, and values beyond the
/// range (below it they round to zero or a subnormal number, above it TextError).
double unusual_real(std::string_view word);

class LineScanner {
 public:
  explicit LineScanner(std::string_view line) : at_(line.data()), end_(line.data() + line.size()) {}

  bool at_end() {
    while (at_ != end_ && is_blank(*at_)) ++at_;
    return at_ == end_;
  }

  /// The next word; empty at the end of the line.
  std::string_view word() {
    at_end();
    const char* begin = at_;
    while (at_ != end_ && !is_blank(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }

  /// Throws TextError, which names `what`, if there is none, or no integer, or none of 64 bits.
  std::int64_t integer(const char* what) {
    start(what);
    std::int64_t value = 0;
    const auto [stop, error] = std::from_chars(digits(), end_, value);
    if (error == std::errc::result_out_of_range)
      throw TextError(std::string(what) + " " + quoted(word()) + " does not fit 64 bits");
    if (error != std::errc() || (stop != end_ && !is_blank(*stop)))
      throw TextError(std::string(what) + " " + quoted(word()) + " is not an integer");
    at_ = stop;
    return value;
  }

  /// Throws TextError, which names `what`, if there is none, or no number, or none of double's range.
  double real(const char* what) {
    start(what);
    double value = 0;
    const auto [stop, error] = std::from_chars(digits(), end_, value);
    if (error == std::errc() && (stop == end_ || is_blank(*stop))) {
      at_ = stop;
      return value;
    }
    const std::string_view text = word();
    try {
      return unusual_real(text);
    } catch (const TextError& e) {
      throw TextError(std::string(what) + " " + quoted(text) + " " + e.what());
    }
  }

  /// Throws TextError if anything is left on the line.
  void finish() {
    if (!at_end()) throw TextError("unexpected " + quoted(word()) + " at the end of the line");
  }

 private:
  void start(const char* what) {
    if (at_end()) throw TextError(std::string(what) + " is missing");
  }
  // std::from_chars takes no plus sign; "+-1" stays wrong.
  const char* digits() const { return *at_ == '+' && at_ + 1 != end_ && at_[1] != '-' ? at_ + 1 : at_; }

  const char* at_;
  const char* end_;
};

}  // namespace mfs::io
