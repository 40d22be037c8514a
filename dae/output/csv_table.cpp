#include "dae/output/csv_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <mfs/error.hpp>

namespace mfs::dae {

CsvTable::CsvTable(const std::string& path, const std::vector<std::string>& columns)
    : columns_(columns.size()), file_(path) {
  for (const std::string& column : columns)
    if (column.find_first_of(",\"\r\n") != std::string::npos)
      throw InvalidInput(path, "a column cannot be called '" + column + "'");
  file_.write(fmt::format("{}\n", fmt::join(columns, ",")));
}

void CsvTable::add_row(const std::vector<double>& values) {
  if (values.size() != columns_)
    throw InvalidInput("values", fmt::format("{} for {} columns", values.size(), columns_));
  file_.write(fmt::format("{}\n", fmt::join(values, ",")));
}

}  // namespace mfs::dae
