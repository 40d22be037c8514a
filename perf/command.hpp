// What the programs that measure solvers have in common: cases and counts on the command line, JSON lines on
// standard output, and exit statuses (0: all was solved, 1: not all, 2: nothing more could be run).
#pragma once

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "perf/chain.hpp"
#include "solver/program/bench_case.hpp"

namespace mfs::perf {

struct Runs {
  std::vector<std::string> cases;
  int threads, repeat, rounds;
};

/// With what `runs` holds as defaults; `threads_of`: whose threads, for the help.
inline void add_options(CLI::App& app, Runs& runs, const std::string& threads_of) {
  app.add_option("cases", runs.cases, "FAMILY:SIZE, chain:BODIES or a file, Matrix Market or PETSc binary")
      ->capture_default_str();
  app.add_option("--threads", runs.threads, threads_of)->check(CLI::PositiveNumber);
  app.add_option("--repeat", runs.repeat, "refactorizations and solves that are timed")
      ->check(CLI::PositiveNumber);
  app.add_option("--rounds", runs.rounds, "times that the solvers take turns")->check(CLI::PositiveNumber);
}

inline void print(const nlohmann::ordered_json& json) {
  std::printf("%s\n", json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  std::fflush(stdout);
}

/// Throws std::invalid_argument for the first that is no case.
inline void check_cases(const Runs& runs) {
  for (const std::string& name : runs.cases) {
    if (!is_chain(name)) io::check_bench_case(name);
  }
}

/// Calls run_case(name) for each case. Returns whether each said that it was solved.
template <class RunCase>
bool run_cases(const Runs& runs, const RunCase& run_case) {
  bool solved = true;
  for (const std::string& name : runs.cases) solved = run_case(name) && solved;
  return solved;
}

/// The exit status of the program after run(), which says whether all was solved.
template <class Run>
int exit_status(const char* program, const Run& run) {
  try {
    return run() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return 2;
  }
}

}  // namespace mfs::perf
