// mfs-dae: flexible multibody dynamics on the command line. This file is the command line; commands.hpp is
// what it leads to.
#include <csignal>
#include <cstdio>
#include <map>
#include <string>

#include <CLI/CLI.hpp>

#include <mfs/version.hpp>

#include "dae/program/commands.hpp"

namespace {

using mfs::dae::Command;
using mfs::program::ExitCode;

const std::map<std::string, mfs::Backend> kBackends{
    {"serial", mfs::Backend::serial}, {"openmp", mfs::Backend::openmp}, {"cuda", mfs::Backend::cuda}};

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 2 usage, 3 invalid input (or output that cannot be written), 4 singular,\n"
    "5 out of memory, 6 accuracy not reached, 7 backend, or the integration failed.";

void add_model(CLI::App& app, Command& command) {
  app.add_option("MODEL.json", command.model, "model file (docs/models.md)")->required();
}

void add_refine(CLI::App& app, Command& command) {
  app.add_option("--refine", command.refine, "divide the cells of generated meshes K times along each edge")
      ->type_name("K")
      ->check(CLI::Range(1, 100));
}

void add_run(CLI::App& app, Command& command) {
  CLI::App* run = app.add_subcommand("run", "Integrate a model; tables, ParaView files and plots go to DIR");
  add_model(*run, command);
  run->add_option("-o", command.folder, "folder of the results, made if need be")
      ->type_name("DIR")
      ->required();
  run->add_option_function<std::string>(
         "--backend", [&command](const std::string& name) { command.backend = kBackends.at(name); },
         "of the linear solver: serial, openmp (default) or cuda")
      ->type_name("NAME")
      ->check(CLI::IsMember({"serial", "openmp", "cuda"}).description(""));
  run->add_option("--threads", command.threads, "threads of every phase; by default all cores")
      ->type_name("T")
      ->check(CLI::Range(1, 512));
  run->add_option("--json", command.json,
                  "write a JSON object there ('-': standard output, and nothing else)")
      ->type_name("FILE|-");
  add_refine(*run, command);
}

void add_commands(CLI::App& app, Command& command) {
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("mfs-dae ") + mfs::version());
  app.footer(kExitCodes);
  add_run(app, command);
  CLI::App* models =
      app.add_subcommand("models", "List the models that come with the program, or write them");
  models->add_option("--write", command.folder, "write their files into DIR")->type_name("DIR");
  add_refine(*models, command);
  CLI::App* check = app.add_subcommand("check", "Read a model, put it together and say how large it is");
  add_model(*check, command);
  add_refine(*check, command);
}

int parse_and_run(int argc, char** argv) {
  CLI::App app{"mfs-dae: flexible multibody dynamics, integrated implicitly with MFS"};
  Command command;
  add_commands(app, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
    std::fprintf(stderr, "mfs-dae: %s (mfs-dae --help tells more)\n", e.what());
    return static_cast<int>(ExitCode::usage);
  }
  if (app.got_subcommand("run")) return static_cast<int>(mfs::dae::run_model(command));
  if (app.got_subcommand("check")) return static_cast<int>(mfs::dae::check_model(command));
  return static_cast<int>(mfs::dae::list_models(command));
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);  // a reader that went away is an error of writing, and reported as one
  try {
    return parse_and_run(argc, argv);
  } catch (...) {
    const mfs::program::Failure failure = mfs::program::describe_current_exception();
    std::fprintf(stderr, "mfs-dae: %s\n", failure.message.c_str());
    return static_cast<int>(failure.code);
  }
}
