// What the command lines of mfs and mfs-dae have in common: options that both take, and the way from main()'s
// arguments to its exit code. A line that cannot be parsed and an exception both become one line on standard
// error, "NAME: what happened", and the exit code that exit_code.hpp gives it.
#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include <mfs/options.hpp>

#include "parts/exit_code.hpp"

namespace mfs::program {

/// --backend NAME; `what` is its line of the help.
void add_backend(CLI::App& app, Backend& backend, const std::string& what);
/// --threads T.
void add_threads(CLI::App& app, int& threads);
/// --json FILE|-; `what` is its line of the help.
void add_json(CLI::App& app, std::string& path, const std::string& what);

/// Parses the command line of the program `name` and calls `run`, unless --help or --version was asked for.
/// `define` gives the parser its description and subcommands, of which one is needed. Never throws; ignores
/// SIGPIPE from here on.
int run_program(const char* name, int argc, char** argv, const std::function<void(CLI::App&)>& define,
                const std::function<ExitCode(const CLI::App&)>& run);

}  // namespace mfs::program
