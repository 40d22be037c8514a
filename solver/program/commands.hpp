// What the subcommands do, once the command line is understood.
#pragma once

#include <string>
#include <vector>

#include "parts/exit_code.hpp"
#include "solver/program/solve_case.hpp"

namespace mfs::program {

struct Command {
  SolveRequest request;
  std::string matrix;              ///< solve, analyze: the file
  std::vector<std::string> cases;  ///< bench: FAMILY:SIZE or a file
  bool measure = false;            ///< info: the rates of this machine, instead
  std::string json;                ///< file or "-"; empty: a summary instead
};

/// Each prints its result to standard output, a fault as one line "mfs: ..." to standard error, and gives the
/// exit code. They throw only what concerns no case: output that cannot be written.
ExitCode run_solve(const Command& command);
ExitCode run_bench(const Command& command);  ///< goes on after a case that failed; the first fault counts
ExitCode run_analyze(const Command& command);
ExitCode run_info(const Command& command);

}  // namespace mfs::program
