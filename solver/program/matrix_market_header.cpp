#include "solver/program/matrix_market_header.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "parts/comma_list.hpp"
#include "solver/program/line_scanner.hpp"

namespace mfs::io {
namespace {

std::string lower_case(std::string_view word) {
  std::string text(word);
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// The value that belongs to `word`, letters in either case.
template <class Value, std::size_t N>
Value choose(const char* what, std::string_view word,
             const std::array<std::pair<const char*, Value>, N>& choices) {
  if (word.empty()) throw TextError(std::string("the banner names no ") + what);
  const std::string wanted = lower_case(word);
  for (const auto& [name, value] : choices)
    if (wanted == name) return value;
  throw TextError(std::string("the banner's ") + what + " " + quoted(word) +
                  " is none of: " + comma_list(choices, key_of));
}

constexpr std::array kFormats{std::pair{"coordinate", Format::coordinate}, std::pair{"array", Format::array}};
constexpr std::array kFields{std::pair{"real", Field::real}, std::pair{"integer", Field::integer},
                             std::pair{"complex", Field::complex}, std::pair{"pattern", Field::pattern}};
constexpr std::array kSymmetries{
    std::pair{"general", Symmetry::general}, std::pair{"symmetric", Symmetry::symmetric},
    std::pair{"skew-symmetric", Symmetry::skew_symmetric}, std::pair{"hermitian", Symmetry::hermitian}};

void check_combination(const Header& h) {
  if (h.field == Field::pattern && h.format == Format::array)
    throw TextError("an array file cannot be a pattern: it has nothing but values");
  if (h.field == Field::pattern && h.symmetry == Symmetry::skew_symmetric)
    throw TextError("a pattern file cannot be skew-symmetric");
  if (h.symmetry == Symmetry::hermitian && h.field != Field::complex)
    throw TextError("a hermitian file must be complex");
}

// Values that an array file lists: all, or one triangle column by column.
std::int64_t listed_values(const Header& h) {
  std::int64_t count = 0;
  const std::int64_t n = h.rows;
  if (h.symmetry == Symmetry::general) {
    if (__builtin_mul_overflow(h.rows, h.columns, &count))
      throw TextError("more values than 64 bits can count");
    return count;
  }
  return h.symmetry == Symmetry::skew_symmetric ? n * (n - 1) / 2 : n * (n + 1) / 2;
}

}  // namespace

bool HeaderParser::take(std::string_view line) {
  ++lines_;
  try {
    if (lines_ == 1) {
      parse_banner(line);
      return false;
    }
    LineScanner scan(line);
    if (scan.at_end() || scan.word().front() == '%') return false;
    parse_size(line);
    return true;
  } catch (const TextError& e) {
    throw TextError(e.what(), lines_);
  }
}

void HeaderParser::parse_banner(std::string_view line) {
  LineScanner scan(line);
  if (line.empty() || is_blank(line.front()) || lower_case(scan.word()) != "%%matrixmarket")
    throw TextError("not a Matrix Market file: it must begin with %%MatrixMarket");
  const std::string_view object = scan.word();
  if (lower_case(object) != "matrix")
    throw TextError("the banner's object " + quoted(object) + " is not known: only matrix is");
  header_.format = choose("format", scan.word(), kFormats);
  header_.field = choose("field", scan.word(), kFields);
  header_.symmetry = choose("symmetry", scan.word(), kSymmetries);
  // A further qualifier may change the meaning of the entries ("0-base" was seen): never pass over it.
  scan.finish();
  check_combination(header_);
}

void HeaderParser::parse_size(std::string_view line) {
  LineScanner scan(line);
  Header& h = header_;
  h.rows = scan.integer("the number of rows");
  h.columns = scan.integer("the number of columns");
  if (h.format == Format::coordinate) h.listed = scan.integer("the number of entries");
  scan.finish();
  if (h.rows < 0 || h.columns < 0 || h.listed < 0) throw TextError("a size is negative");
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (h.rows > most || h.columns > most) throw TextError("more than 2147483647 rows or columns");
  if (h.symmetry != Symmetry::general && h.rows != h.columns)
    throw TextError("the symmetry asks for a square matrix, this one is " + std::to_string(h.rows) + " x " +
                    std::to_string(h.columns));
  if (h.format == Format::array) h.listed = listed_values(h);
  if (h.listed > 0 && (h.rows == 0 || h.columns == 0))
    throw TextError("a matrix of " + std::to_string(h.rows) + " x " + std::to_string(h.columns) +
                    " has no room for " + std::to_string(h.listed) + " entries");
}

void HeaderParser::ended() const {
  throw TextError(lines_ == 0 ? "the file is empty" : "the file ends before its size line", lines_);
}

}  // namespace mfs::io
