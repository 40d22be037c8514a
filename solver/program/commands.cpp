#include "solver/program/commands.hpp"

#include <cstdio>
#include <type_traits>
#include <variant>

#include <mfs/solver.hpp>

#include "parts/output_file.hpp"
#include "solver/program/bench_case.hpp"
#include "solver/program/json_report.hpp"
#include "solver/program/matrix_market.hpp"
#include "solver/program/measure_rates.hpp"
#include "solver/program/summary.hpp"

namespace mfs::program {
namespace {

void complain(const CaseResult& result) {
  if (result.code != ExitCode::solved) std::fprintf(stderr, "mfs: %s\n", result.message.c_str());
}

// Where results go: lines of JSON, or summaries. X on standard output leaves standard error to the summaries.
class Results {
 public:
  explicit Results(const Command& command)
      : json_(command.json), x_on_output_(command.request.output == "-") {
    if (!json_.empty()) io::check_writable(json_);
  }
  void put(const CaseResult& result) {
    complain(result);
    if (!json_.empty()) return put_json(json_line(result) + "\n");
    const std::string summary = (separate_ ? "\n" : "") + solve_summary(result);
    if (x_on_output_)
      std::fputs(summary.c_str(), stderr);
    else
      io::print(summary);
    separate_ = true;
  }

 private:
  // A file has the lines of all cases so far, whatever becomes of the next.
  void put_json(const std::string& line) {
    lines_ += line;
    io::write_file(json_, io::is_stream(json_) ? line : lines_);
  }

  std::string json_, lines_;
  bool x_on_output_, separate_ = false;
};

// Rates are those of real numbers in double precision.
void predict(CaseResult& result) {
  if (!result.report) return;
  const Report& report = *result.report;
  const bool by_file = report.partial && backend_info(report.backend).memory == MemorySpace::host;
  if (result.complex || report.single_precision || by_file) {
    result.no_prediction = result.complex            ? "rates are those of real matrices"
                           : report.single_precision ? "rates are those of double precision factors"
                                                     : "rates are those of factors that fit in memory";
    return;
  }
  const std::string path = rates_path();
  const RatesFile file = read_rates(path);
  const RatesKey key = rates_key(report.backend, report.threads);
  for (const MachineRates& rates : file.rates) {
    const bool serve = !report.partial || rates.link_bytes_per_second > 0;
    if (rates.key == key && serve) result.prediction = predict(rates, report, result.depths);
  }
  if (!result.prediction)
    result.no_prediction =
        file.damaged ? path + " is damaged or of another version; 'mfs info --measure' makes it anew"
                     : "'mfs info --measure' measures the rates of this machine, once for each "
                       "backend and number of threads";
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
  if (!command.json.empty()) io::check_writable(command.json);
  display.show("read", 0);
  const io::SquareMatrix matrix = io::read_square_pattern(command.matrix, command.request.options.threads);
  Options options = command.request.options;
  options.progress = display.callback();
  std::visit([&](const auto& a) { analyze(a, options, result); }, matrix);
  display.clear();
  predict(result);
  if (command.json.empty()) {
    io::print(analysis_summary(result));
  } else {
    io::write_file(command.json, json_line(result) + "\n");
  }
}

}  // namespace

ExitCode run_solve(const Command& command) {
  Results results(command);
  ProgressDisplay display;
  const auto load = [&] { return io::read_square_matrix(command.matrix, command.request.options.threads); };
  CaseResult result = solve_case(io::bench_case_name(command.matrix), load, command.request, display);
  predict(result);
  results.put(result);
  return result.code;
}

ExitCode run_bench(const Command& command) {
  Results results(command);
  ProgressDisplay display;
  ExitCode code = ExitCode::solved;
  for (const std::string& text : command.cases) {
    const auto load = [&] { return io::load_bench_case(text, command.request.options.threads); };
    CaseResult result = solve_case(io::bench_case_name(text), load, command.request, display);
    predict(result);
    results.put(result);
    if (code == ExitCode::solved) code = result.code;
  }
  return code;
}

ExitCode run_analyze(const Command& command) {
  CaseResult result;
  result.name = io::bench_case_name(command.matrix);
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

ExitCode run_info(const Command& command) {
  if (!command.measure) {
    io::print(library_summary());
    return ExitCode::solved;
  }
  const std::string path = rates_path();
  make_rates_folder(path);
  ProgressDisplay display;
  const MachineRates rates = measure_rates(command.request.options, kMeasuredEntries,
                                           [&](double done) { display.show("measure", done); });
  display.clear();
  keep_rates(path, rates);
  io::print(rates_summary(rates, path));
  return ExitCode::solved;
}

}  // namespace mfs::program
