// Tables that the program left in a folder.
#pragma once

#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "test/program/temporary_folder.hpp"

using Table = std::map<std::string, std::vector<double>>;

/// Columns by name.
inline Table read_table(const std::string& path) {
  std::istringstream lines(text_of(path));
  std::string line, cell;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream cells(line); std::getline(cells, cell, ',');) names.push_back(cell);
  Table table;
  for (const std::string& name : names) table[name];
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i)
      table[names.at(i)].push_back(std::stod(cell));
  }
  return table;
}
