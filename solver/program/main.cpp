// mfs: the solver on the command line. This file is the command line; commands.hpp is what it leads to.
#include <string>

#include <CLI/CLI.hpp>

#include <mfs/error.hpp>

#include "parts/command_line.hpp"
#include "solver/program/bench_case.hpp"
#include "solver/program/commands.hpp"

namespace {

using mfs::program::Command;
using mfs::program::ExitCode;

constexpr const char* kExitCodes =
    "Exit codes: 0 solved, 2 usage, 3 invalid input (or output that cannot be written), 4 singular,\n"
    "5 out of memory, 6 accuracy not reached, 7 backend.\n"
    "Messages count the lines of a file, and rows and columns in them, from 1; messages about the matrix\n"
    "itself count rows and columns from 0, as the library does, and say so.";

CLI::Validator open_interval() {
  return CLI::Validator(
      [](std::string& text) {
        double value = 0;
        const bool number = CLI::detail::lexical_cast(text, value);
        return number && value > 0 && value < 1 ? std::string() : "'" + text + "' is not between 0 and 1";
      },
      "0..1");
}

CLI::Validator bench_case() {
  return CLI::Validator(
      [](std::string& text) {
        try {
          mfs::io::check_bench_case(text);
          return std::string();
        } catch (const mfs::InvalidInput& e) {
          return std::string(e.what());
        }
      },
      "");
}

void add_analysis_options(CLI::App& app, Command& command) {
  mfs::program::add_threads(app, command.request.options.threads);
  app.add_option("--max-block", command.request.options.analysis.max_block_size,
                 "widest block of a pivot block")
      ->type_name("B")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  mfs::program::add_backend(app, command.request.options.backend, "serial, openmp (default), cuda or kokkos");
  app.add_option(
         "--memory-limit", command.request.options.memory_limit,
         "of a GPU's memory, beyond which factors go to the memory of the host, or with serial and openmp "
         "that of the host, beyond which they go to a file; in bytes or with a unit (8GB, 500MiB; default: "
         "all that is free)")
      ->type_name("SIZE")
      ->transform(CLI::AsSizeValue(true).description(""))
      ->check(CLI::PositiveNumber.description(""));
  app.add_option("--out-of-core-dir", command.request.options.out_of_core_dir,
                 "with serial and openmp: where a file may be made for factors that memory has no room for "
                 "(default: none is)")
      ->type_name("DIR");
}

void add_solve_options(CLI::App& app, Command& command) {
  mfs::program::SolveRequest& request = command.request;
  app.add_option("--rhs", request.rhs,
                 "right-hand sides b: 'ones' (every component 1), 'random' (uniform in [-1, 1), seed " +
                     std::to_string(mfs::program::kRandomSeed) +
                     "), or a Matrix Market array file ('-': standard input)")
      ->type_name("ones|random|FILE")
      ->capture_default_str();
  app.add_option("--nrhs", request.nrhs, "number of right-hand sides; 1, or what the file holds")
      ->type_name("K")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{2147483647}));
  app.add_flag("--transpose", request.transpose, "solve A^T x = b");
  app.add_flag("--singular", request.options.solve.solve_singular,
               "return a solution that reaches the tolerance also where A is singular to working precision");
  add_analysis_options(app, command);
  app.add_option("--refactor", request.refactor,
                 "factor again and solve again K times and report the least times")
      ->type_name("K")
      ->check(CLI::Range(0, 1000000));
  app.add_option("--tol", request.tolerance,
                 "componentwise backward error max |b - Ax| / (|A||x| + |b|) that x must reach")
      ->type_name("TOL")
      ->check(open_interval().description(""))
      ->capture_default_str();
  app.add_option_function<std::string>(
         "--precision",
         [&request](const std::string& name) {
           request.options.factor.precision =
               name == "single" ? mfs::Precision::single : mfs::Precision::full;
         },
         "of the factors, double or single (default: single on a GPU that is slow in double precision, "
         "which info tells, else double); x is as accurate either way")
      ->type_name("NAME")
      ->check(CLI::IsMember({"double", "single"}).description(""));
  app.add_flag("--condition", request.condition, "estimate the condition number |A| |A^-1| in the 1-norm");
  app.add_flag("--determinant", request.determinant, "of A, as sign or phase and logarithm");
  app.add_option("--dump", request.options.dump_prefix,
                 "leave a system that fails in PREFIX_A.mtx and PREFIX_b.mtx")
      ->type_name("PREFIX");
  mfs::program::add_json(app, command.json, "write a JSON object per matrix there ('-': standard output)");
  app.add_option(
         "-o", request.output,
         "write X as a Matrix Market array file ('-': standard output; the summary goes to standard error)")
      ->type_name("X.mtx");
}

// Standard output has one use.
void check_streams(const Command& command) {
  if (command.request.output == "-" && command.json == "-")
    throw CLI::ValidationError("-o", "standard output cannot be both X and JSON");
}

void add_info(CLI::App& app, Command& command) {
  CLI::App* info = app.add_subcommand("info", "Show version, backends and libraries, or measure the machine");
  CLI::Option* measure = info->add_flag(
      "--measure", command.measure,
      "measure how fast fronts are factored and solved by their size, and keep that for predictions in "
      "$XDG_CACHE_HOME/mfs/rates.json (~/.cache/mfs/rates.json); leave the machine alone meanwhile");
  mfs::program::add_threads(*info, command.request.options.threads);
  mfs::program::add_backend(*info, command.request.options.backend,
                            "serial, openmp (default), cuda or kokkos");
  for (const char* of_measure : {"--threads", "--backend"}) info->get_option(of_measure)->needs(measure);
}

void add_commands(CLI::App& app, Command& command) {
  app.description("MFS: sparse direct solver, multifrontal LU over breadth-first nested dissection");
  app.footer(kExitCodes);

  CLI::App* solve = app.add_subcommand("solve", "Solve A x = b for a Matrix Market file, plain or gzip");
  solve
      ->add_option("A.mtx", command.matrix,
                   "square, real, integer or complex, any symmetry ('-': standard input)")
      ->required();
  add_solve_options(*solve, command);
  solve->final_callback([&command] {
    check_streams(command);
    if (command.matrix == "-" && command.request.rhs == "-")
      throw CLI::ValidationError("--rhs", "standard input cannot be both A and b");
  });

  CLI::App* analyze = app.add_subcommand("analyze", "Order the matrix and predict fronts, flops and memory");
  analyze
      ->add_option("A.mtx", command.matrix,
                   "square, any field and symmetry; a pattern will do ('-': standard input)")
      ->required();
  add_analysis_options(*analyze, command);
  mfs::program::add_json(*analyze, command.json, "write a JSON object there ('-': standard output)");

  CLI::App* bench = app.add_subcommand("bench", "Solve benchmark matrices and files one after another");
  bench
      ->add_option(
          "CASE", command.cases,
          "FAMILY:SIZE of elas3d, beam3d, kkt, convdiff3d, poisson2d, circuit (elas3d:20 say), or a file")
      ->required()
      ->check(bench_case());
  add_solve_options(*bench, command);
  bench->final_callback([&command] {
    check_streams(command);
    if (command.cases.size() > 1 && !command.request.output.empty())
      throw CLI::ValidationError("-o", "takes the X of one case only");
  });

  add_info(app, command);
}

ExitCode run(const CLI::App& app, const Command& command) {
  if (app.got_subcommand("solve")) return mfs::program::run_solve(command);
  if (app.got_subcommand("bench")) return mfs::program::run_bench(command);
  if (app.got_subcommand("analyze")) return mfs::program::run_analyze(command);
  return mfs::program::run_info(command);
}

}  // namespace

int main(int argc, char** argv) {
  Command command;
  return mfs::program::run_program(
      "mfs", argc, argv, [&](CLI::App& app) { add_commands(app, command); },
      [&](const CLI::App& app) { return run(app, command); });
}
