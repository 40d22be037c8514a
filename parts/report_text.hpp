// Pieces of the reports for people and for other programs.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace mfs::program {

/// A line of a summary: `label` in a column of its own, `what` beside it.
std::string labelled(const std::string& label, const std::string& what);

/// A number with its unit's prefix: 1234567, "flop" -> "1.23 Mflop".
std::string with_unit(double value, const char* unit);

/// The text of any object, without line breaks.
std::string one_line(const nlohmann::ordered_json& json);

}  // namespace mfs::program
