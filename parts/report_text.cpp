#include "parts/report_text.hpp"

#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace mfs::program {

std::string labelled(const std::string& label, const std::string& what) {
  return fmt::format("{:<15} {}\n", label, what);
}

std::string with_unit(double value, const char* unit) {
  static constexpr const char* prefixes[] = {"", "k", "M", "G", "T", "P", "E"};
  std::size_t k = 0;
  for (; value >= 999.5 && k + 1 < std::size(prefixes); ++k) value /= 1000;
  const int digits = k == 0 || value >= 99.95 ? 0 : value >= 9.995 ? 1 : 2;
  return fmt::format("{:.{}f} {}{}", value, digits, prefixes[k], unit);
}

std::string one_line(const nlohmann::ordered_json& json) {
  // A path need not be UTF-8; JSON must be.
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace mfs::program
