// What the subcommands of mfs-dae do.
#pragma once

#include <string>

#include <mfs/options.hpp>

#include "solver/program/exit_code.hpp"

namespace mfs::dae {

struct Command {
  std::string model;   ///< path of the model file
  std::string folder;  ///< of the results, or to write models to
  std::string json;    ///< path of the report, "-": standard output; empty: a table on standard output
  Backend backend = Backend::openmp;
  int threads = 0;  ///< 0: all
  int refine = 0;   ///< 0: as the model has it
  bool plots = true;
};

/// All throw what describe_current_exception() knows.
program::ExitCode run_model(const Command& command);
/// Draws plots of the results in the folder.
program::ExitCode plot_results(const Command& command);
/// Reads the model and puts it together, and says how large it is.
program::ExitCode check_model(const Command& command);
/// Lists the models of the library, or writes them to a folder.
program::ExitCode list_models(const Command& command);

}  // namespace mfs::dae
