#include "solver/program/line_scanner.hpp"

#include <cmath>
#include <cstdlib>

#include <locale.h>

namespace mfs::io {

std::string quoted(std::string_view word) {
  constexpr std::size_t longest = 32;
  std::string text = "'";
  for (const char c : word.substr(0, longest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > longest ? "...'" : "'");
}

double unusual_real(std::string_view word) {
  std::string text(word.substr(word.size() > 1 && word[0] == '+' && word[1] != '-' ? 1 : 0));
  const std::size_t letter = text.find_first_of("dD");
  if (letter != std::string::npos) text[letter] = 'e';
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc::invalid_argument || stop != end) throw TextError("is not a number");
  if (error == std::errc()) return value;
  // Out of range, above or below: strtod tells which, in the "C" locale, whatever the program runs in.
  const locale_t plain = newlocale(LC_ALL_MASK, "C", nullptr);
  value = strtod_l(text.c_str(), nullptr, plain);
  freelocale(plain);
  if (std::isinf(value)) throw TextError("is too large for a double");
  return value;
}

}  // namespace mfs::io
