// mfs-dae: flexible multibody dynamics on the command line. This file is the command line; commands.hpp is
// what it leads to.
#include <cmath>
#include <string>

#include <CLI/CLI.hpp>

#include "dae/program/commands.hpp"
#include "parts/command_line.hpp"

namespace {

using mfs::dae::Command;
using mfs::program::ExitCode;

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 2 usage, 3 invalid input (or output that cannot be written), 4 singular,\n"
    "5 out of memory, 6 accuracy not reached, 7 backend, or the integration failed; 130 interrupted,\n"
    "143 terminated: what there is by then is written.";

void add_model(CLI::App& app, Command& command) {
  app.add_option("MODEL", command.model, "model file (docs/models.md), or the name of a model of the library")
      ->required();
}

void add_refine(CLI::App& app, Command& command) {
  app.add_option("--refine", command.refine, "divide the cells of generated meshes K times along each edge")
      ->type_name("K")
      ->check(CLI::Range(1, 100));
}

void add_set(CLI::App& app, Command& command) {
  app.add_option("--set", command.parameters, "give a parameter of the model another value (repeatable)")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
}

void add_report(CLI::App& app, Command& command) {
  mfs::program::add_json(app, command.json,
                         "write a JSON object there ('-': standard output, and nothing else)");
  app.add_flag("!--no-plots", command.plots, "draw none; 'mfs-dae plot DIR' does it later");
}

void add_executor(CLI::App& app, Command& command, const std::string& of) {
  mfs::program::add_backend(app, command.backend, of + ": serial, openmp (default), cuda or kokkos");
  mfs::program::add_threads(app, command.threads);
}

/// An empty name would be the root of all folders.
void add_folder(CLI::App& app, const char* option, const char* what, Command& command) {
  const auto named = [](const std::string& name) {
    return name.empty() ? std::string("the folder has no name") : std::string();
  };
  app.add_option(option, command.folder, what)->type_name("DIR")->check(CLI::Validator(named, ""));
}

CLI::App* add_about(CLI::App& app, Command& command, const char* name, const char* what) {
  CLI::App* about = app.add_subcommand(name, what);
  add_model(*about, command);
  add_folder(*about, "-o", "folder of the results, made if need be", command);
  add_executor(*about, command, "of the linear solver");
  add_refine(*about, command);
  add_set(*about, command);
  add_report(*about, command);
  return about;
}

/// What is wrong with `text` as a time, or nothing. CLI11's own check takes nan, and names the largest number
/// there is with its 309 digits.
std::string time_of_motion(const std::string& text) {
  double t = -1.0;
  const bool good = CLI::detail::lexical_cast(text, t) && std::isfinite(t) && t >= 0.0;
  return good ? "" : text + " is no time: must be 0 or later";
}

void add_statics(CLI::App& app, Command& command) {
  const auto add_at = [&](CLI::App& about) {
    about.add_option("--at", command.at, "of the motion at this time instead of the static equilibrium")
        ->type_name("T")
        ->check(CLI::Validator(time_of_motion, ""));
  };
  add_about(app, command, "static", "Find the static equilibrium; tables and ParaView files go to DIR")
      ->get_option("-o")
      ->required();
  CLI::App* modes = add_about(app, command, "modes",
                              "List frequencies and damping of small motions; their shapes go to DIR");
  modes->add_option("--modes", command.modes, "how many (10)")->type_name("N")->check(CLI::Range(1, 1000));
  modes->add_flag("--undamped", command.undamped, "leave out all that depends on velocities");
  add_at(*modes);
  CLI::App* matrices = add_about(app, command, "linearize",
                                 "Write mass, damping and stiffness matrices and constraints to DIR");
  matrices->get_option("-o")->required();
  add_at(*matrices);
}

void add_run(CLI::App& app, Command& command) {
  CLI::App* run = app.add_subcommand("run", "Integrate a model; tables, ParaView files and plots go to DIR");
  add_model(*run, command);
  add_folder(*run, "-o", "folder of the results, made if need be", command);
  run->get_option("-o")->required();
  add_executor(*run, command, "of the linear solver and of flexible bodies");
  add_refine(*run, command);
  add_set(*run, command);
  add_report(*run, command);
}

void add_commands(CLI::App& app, Command& command) {
  app.description("mfs-dae: flexible multibody dynamics, integrated implicitly with MFS");
  app.footer(kExitCodes);
  add_run(app, command);
  add_statics(app, command);
  CLI::App* models =
      app.add_subcommand("models", "List the models that come with the program, or write them");
  add_folder(*models, "--write", "write their files into DIR", command);
  add_refine(*models, command);
  CLI::App* plot = app.add_subcommand("plot", "Draw plots of the results in DIR");
  add_folder(*plot, "DIR", "folder of a run", command);
  plot->get_option("DIR")->required();
  CLI::App* check = app.add_subcommand("check", "Read a model, put it together and say how large it is");
  add_model(*check, command);
  add_refine(*check, command);
  add_set(*check, command);
}

ExitCode run(const CLI::App& app, const Command& command) {
  if (app.got_subcommand("run")) return mfs::dae::run_model(command);
  if (app.got_subcommand("plot")) return mfs::dae::plot_results(command);
  if (app.got_subcommand("check")) return mfs::dae::check_model(command);
  if (app.got_subcommand("static")) return mfs::dae::solve_static(command);
  if (app.got_subcommand("modes")) return mfs::dae::list_modes(command);
  if (app.got_subcommand("linearize")) return mfs::dae::linearize_model(command);
  return mfs::dae::list_models(command);
}

}  // namespace

int main(int argc, char** argv) {
  Command command;
  return mfs::program::run_program(
      "mfs-dae", argc, argv, [&](CLI::App& app) { add_commands(app, command); },
      [&](const CLI::App& app) { return run(app, command); });
}
