#include "solver/program/bench_case.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <utility>

#include <mfs/error.hpp>

#include "cases/families.hpp"
#include "parts/comma_list.hpp"

namespace mfs::io {
namespace {

struct FamilyCase {
  std::string family;
  std::int64_t size = 0;
};

/// Nothing where `name` does not begin with a family and a colon.
std::optional<FamilyCase> parse_family(const std::string& name) {
  const std::size_t colon = name.find(':');
  FamilyCase wanted{name.substr(0, colon), 0};
  const auto& names = cases::family_names();
  if (colon == std::string::npos || std::find(names.begin(), names.end(), wanted.family) == names.end())
    return {};
  const char* end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + colon + 1, end, wanted.size);
  if (error != std::errc() || stop != end || wanted.size < 1)
    throw InvalidInput(name, "the size after the colon must be a positive integer");
  return wanted;
}

}  // namespace

void check_bench_case(const std::string& name) {
  std::error_code error;
  if (parse_family(name) || name == "-" || std::filesystem::exists(name, error)) return;
  throw InvalidInput(name,
                     "neither a file nor FAMILY:SIZE with a family of: " + comma_list(cases::family_names()));
}

std::string bench_case_name(const std::string& name) {
  if (parse_family(name)) return name;
  if (name == "-") return "stdin";
  std::filesystem::path file = std::filesystem::path(name).filename();
  if (file.extension() == ".gz") file = file.stem();
  if (file.extension() == ".mtx") file = file.stem();
  return file.string();
}

SquareMatrix load_bench_case(const std::string& name, int threads) {
  const auto family = parse_family(name);
  if (!family) return read_square_matrix(name, threads);
  cases::FamilyMatrix made = cases::make_family(family->family, family->size);
  return CsrMatrix<double>{made.n, made.n, std::move(made.offsets), std::move(made.column_indices),
                           std::move(made.values)};
}

}  // namespace mfs::io
