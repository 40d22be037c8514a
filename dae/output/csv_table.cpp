#include "dae/output/csv_table.hpp"

#include <fmt/format.h>

#include <mfs/error.hpp>

namespace mfs::dae {

CsvTable::CsvTable(const std::string& path, const std::vector<std::string>& columns)
    : columns_(columns.size()), file_(path) {
  std::string header;
  for (const std::string& column : columns) {
    if (column.find_first_of(",\"\r\n") != std::string::npos)
      throw InvalidInput(path, "a column cannot be called '" + column + "'");
    header += (header.empty() ? "" : ",") + column;
  }
  file_.write(header + "\n");
}

void CsvTable::add_row(const std::vector<double>& values) {
  if (values.size() != columns_)
    throw InvalidInput("values", fmt::format("{} for {} columns", values.size(), columns_));
  std::string line;
  for (const double value : values) line += fmt::format("{}{}", line.empty() ? "" : ",", value);
  file_.write(line + "\n");
}

}  // namespace mfs::dae
