#include "solver/program/commands.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <type_traits>
#include <variant>

#include <mfs/error.hpp>
#include <mfs/solver.hpp>

#include "perf/families.hpp"
#include "solver/program/comma_list.hpp"
#include "solver/program/json_report.hpp"
#include "solver/program/matrix_market.hpp"
#include "solver/program/output_file.hpp"
#include "solver/program/summary.hpp"

namespace mfs::program {
namespace {

// "data/west0479.mtx.gz" -> "west0479"
std::string name_of(const std::string& path) {
  std::filesystem::path name = std::filesystem::path(path).filename();
  if (name.extension() == ".gz") name = name.stem();
  if (name.extension() == ".mtx") name = name.stem();
  return name.string();
}

void complain(const CaseResult& result) {
  if (result.code != ExitCode::solved) std::fprintf(stderr, "mfs: %s\n", result.message.c_str());
}

// Where results go: lines of JSON, or summaries.
class Results {
 public:
  explicit Results(const Command& command) {
    if (!command.json.empty()) json_.emplace(command.json);
  }
  void put(const CaseResult& result) {
    complain(result);
    if (json_) return json_->write(json_line(result) + "\n");
    if (separate_) io::print("\n");
    io::print(solve_summary(result));
    separate_ = true;
  }

 private:
  std::optional<io::OutputFile> json_;
  bool separate_ = false;
};

io::SquareMatrix load_family(const BenchCase& wanted) {
  perf::FamilyMatrix family = perf::make_family(wanted.family, wanted.size);
  return io::CsrMatrix<double>{family.n, family.n, std::move(family.offsets),
                               std::move(family.column_indices), std::move(family.values)};
}

template <class Scalar>
void analyze(const io::CsrMatrix<Scalar>& a, const Options& options, CaseResult& result) {
  result.n = a.rows;
  result.entries = a.entries();
  result.complex = !std::is_same_v<Scalar, double>;
  BasicSolver<Scalar> solver(options);
  solver.analyze(a.view());
  result.report = solver.report();
  result.depths = solver.depths();
}

void analyze(const Command& command, ProgressDisplay& display, CaseResult& result) {
  display.show("read", 0);
  const io::SquareMatrix matrix = io::read_square_pattern(command.matrix, command.request.options.threads);
  Options options = command.request.options;
  options.progress = display.callback();
  std::visit([&](const auto& a) { analyze(a, options, result); }, matrix);
  display.clear();
  io::print(analysis_summary(result));
}

}  // namespace

BenchCase parse_bench_case(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string family = text.substr(0, colon);
  const auto& names = perf::family_names();
  if (colon == std::string::npos || std::find(names.begin(), names.end(), family) == names.end())
    throw InvalidInput(text, "not FAMILY:SIZE with a family of: " + comma_list(names));
  BenchCase wanted{family, 0};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, wanted.size);
  if (error != std::errc() || stop != end || wanted.size < 1)
    throw InvalidInput(text, "the size after the colon must be a positive integer");
  return wanted;
}

ExitCode run_solve(const Command& command) {
  Results results(command);
  ProgressDisplay display;
  const auto load = [&] { return io::read_square_matrix(command.matrix, command.request.options.threads); };
  const CaseResult result = solve_case(name_of(command.matrix), load, command.request, display);
  results.put(result);
  return result.code;
}

ExitCode run_bench(const Command& command) {
  Results results(command);
  ProgressDisplay display;
  ExitCode code = ExitCode::solved;
  for (const std::string& text : command.cases) {
    const auto load = [&] { return load_family(parse_bench_case(text)); };
    const CaseResult result = solve_case(text, load, command.request, display);
    results.put(result);
    if (code == ExitCode::solved) code = result.code;
  }
  return code;
}

ExitCode run_analyze(const Command& command) {
  CaseResult result;
  result.name = name_of(command.matrix);
  result.backend = command.request.options.backend;
  ProgressDisplay display;
  try {
    analyze(command, display, result);
  } catch (...) {
    display.clear();
    const Failure failure = describe_current_exception();
    result.code = failure.code;
    result.message = failure.message;
    complain(result);
  }
  return result.code;
}

ExitCode run_info() {
  io::print(library_summary());
  return ExitCode::solved;
}

}  // namespace mfs::program
