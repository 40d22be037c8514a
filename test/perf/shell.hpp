// Runs a line of shell as a user of the benchmarks does, and reads the JSON lines that it prints.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "test/program/run_program.hpp"

inline ProgramRun shell(const std::string& command) {
  return run_program({"-c", command});
}

inline std::vector<nlohmann::json> json_lines(const std::string& text) {
  std::vector<nlohmann::json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}
