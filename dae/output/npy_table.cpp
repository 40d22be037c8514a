#include "dae/output/npy_table.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <mfs/error.hpp>

namespace mfs::dae {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the header says so");

constexpr const char* kMagic = "\x93NUMPY\x02";
constexpr std::size_t kBeforeHeader = 12;  // magic, two bytes of version, four of the header's length
constexpr int kDigits = 19;                // room for any number of rows

void check_names(const std::string& path, const std::vector<NpyField>& fields) {
  std::set<std::string> names;
  for (const NpyField& field : fields) {
    const bool plain = std::all_of(field.name.begin(), field.name.end(), [](char c) {
      return static_cast<unsigned char>(c) >= 0x20 && c != '\'' && c != '\\';
    });
    if (field.name.empty() || !plain || !names.insert(field.name).second)
      throw InvalidInput(path, "a field cannot be called '" + field.name + "'");
  }
}

std::string description(const NpyField& field) {
  if (field.shape.empty()) return fmt::format("('{}', '<f8'), ", field.name);
  return fmt::format("('{}', '<f8', ({},)), ", field.name, fmt::join(field.shape, ", "));
}

}  // namespace

NpyTable::NpyTable(const std::string& path, const std::vector<NpyField>& fields) : file_(path) {
  check_names(path, fields);
  std::string header = "{'descr': [";
  for (const NpyField& field : fields) {
    header += description(field);
    std::size_t count = 1;
    for (const int extent : field.shape) count *= static_cast<std::size_t>(extent);
    columns_ += count;
  }
  header += "], 'fortran_order': False, 'shape': (";
  rows_at_ = kBeforeHeader + header.size();
  header += fmt::format("{:>{}},), }}", 0, kDigits);
  constexpr std::size_t kAlignment = 64;  // of the first row
  header.append(kAlignment - 1 - (kBeforeHeader + header.size()) % kAlignment, ' ');
  header += '\n';
  const auto length = static_cast<std::uint32_t>(header.size());
  std::string begin(kMagic);
  begin += '\0';
  begin.append(reinterpret_cast<const char*>(&length), sizeof length);
  file_.write(begin + header);
}

void NpyTable::add_row(const std::vector<double>& values) {
  if (values.size() != columns_)
    throw InvalidInput("values", fmt::format("{} for {} columns", values.size(), columns_));
  file_.write({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)});
  file_.overwrite(rows_at_, fmt::format("{:>{}}", ++rows_, kDigits));
}

}  // namespace mfs::dae
