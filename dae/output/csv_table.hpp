// A table in a file of comma separated values: one line of column names, then a line per row, each written as
// soon as it is known, so that a run can be watched and an interrupted one leaves what it had.
#pragma once

#include <string>
#include <vector>

#include "parts/output_file.hpp"

namespace mfs::dae {

class CsvTable {
 public:
  /// `columns`: names, with units in brackets where they have one: "t [s]". Throws InvalidInput where the
  /// file cannot be written or a name has a comma, a quote or a line end in it.
  CsvTable(const std::string& path, const std::vector<std::string>& columns);
  /// As many values as columns. Numbers are written so that reading gives back the same bits; integers
  /// without a point. Throws InvalidInput.
  void add_row(const std::vector<double>& values);

 private:
  std::size_t columns_;
  io::OutputFile file_;
};

}  // namespace mfs::dae
