// What the subcommands of mfs-dae do.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <mfs/options.hpp>

#include "dae/model/model.hpp"
#include "dae/output/plots.hpp"
#include "parts/exit_code.hpp"

namespace mfs::dae {

struct Command {
  std::string model;   ///< path of the model file
  std::string folder;  ///< of the results, or to write models to
  std::string json;    ///< path of the report, "-": standard output; empty: a table on standard output
  Backend backend = Backend::openmp;
  int threads = 0;                      ///< 0: all
  int refine = 0;                       ///< 0: as the model has it
  std::vector<std::string> parameters;  ///< "NAME=VALUE", in place of those of the model
  std::optional<double> at;             ///< s: of modes and matrices, the moment of the motion; none: at rest
  int modes = 10;                       ///< how many
  bool undamped = false;                ///< modes without damping
  bool plots = true;
};

/// Names the pictures that were drawn; on standard error, why there are none.
void show_plots(const PlotOutcome& plots);
/// The model of the command, for its backend and threads; `forces`: where flexible bodies are evaluated.
MultibodyModel load_model(const Command& command, Backend forces);
/// Refuses options of the model as InvalidInput("integrator").
Integrator make_integrator(const MultibodyModel& model);
/// Puts the model of the command to rest where the file asks for that ("start"). Returns what to know of
/// that.
std::vector<std::string> start_model(const Command& command, MultibodyModel& model);

/// All throw what describe_current_exception() knows.
program::ExitCode run_model(const Command& command);
/// Draws plots of the results or modes in the folder.
program::ExitCode plot_results(const Command& command);
/// Reads the model and puts it together, and says how large it is.
program::ExitCode check_model(const Command& command);
/// Finds the static equilibrium and writes it as a run's only output.
program::ExitCode solve_static(const Command& command);
/// Lists the modes about a state; where a folder is given, with their shapes there.
program::ExitCode list_modes(const Command& command);
/// Writes the matrices of a state to the folder.
program::ExitCode linearize_model(const Command& command);
/// Lists the models of the library, or writes them to a folder.
program::ExitCode list_models(const Command& command);

}  // namespace mfs::dae
