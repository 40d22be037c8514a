// Numbers in messages. std::to_string() writes six digits behind the point, so that 2e-7 s becomes 0.000000.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace mfs::dae {

/// Six significant digits: "0.25", "2e-07", "nan".
inline std::string number_text(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", number);
  return text.data();
}

}  // namespace mfs::dae
