#include "parts/command_line.hpp"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <mfs/version.hpp>

#include "kernels/runtime/engine.hpp"
#include "parts/openblas_start.hpp"

namespace mfs::program {
namespace {

const std::vector<std::pair<std::string, Backend>> kBackends{{"serial", Backend::serial},
                                                             {"openmp", Backend::openmp},
                                                             {"cuda", Backend::cuda},
                                                             {"kokkos", Backend::kokkos}};

int parse_and_run(const char* name, int argc, char** argv, const std::function<void(CLI::App&)>& define,
                  const std::function<ExitCode(const CLI::App&)>& run) {
  CLI::App app;
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string(name) + " " + version());
  define(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
    std::fprintf(stderr, "%s: %s (%s --help tells more)\n", name, e.what(), name);
    return static_cast<int>(ExitCode::usage);
  }
  return static_cast<int>(run(app));
}

// The program begins once more where OpenBLAS should have found the kind of this processor in the environment
// when it was loaded. Goes on where that cannot be, or where the process was begun by another file than the
// program (the dynamic loader, an emulator), which has neither the program's name nor that of the command.
void begin_again_for_blas(const char* name, char** argv) {
  const std::string kernels = better_blas_kernels();
  if (kernels.empty()) return;
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path command = argv[0] ? argv[0] : name;
  if (error || (self.filename() != name && self.filename() != command.filename())) return;
  if (setenv("OPENBLAS_CORETYPE", kernels.c_str(), 0) == 0) execv(self.c_str(), argv);
}

}  // namespace

void add_backend(CLI::App& app, Backend& backend, const std::string& what) {
  const auto take = [&backend](const std::string& name) {
    for (const auto& [known, value] : kBackends)
      if (name == known) backend = value;
  };
  app.add_option_function<std::string>("--backend", take, what)
      ->type_name("NAME")
      ->check(CLI::IsMember(kBackends).description(""));
}

void add_threads(CLI::App& app, int& threads) {
  app.add_option("--threads", threads, "threads of every phase; by default all cores")
      ->type_name("T")
      ->check(CLI::Range(1, kMostThreads));
}

void add_json(CLI::App& app, std::string& path, const std::string& what) {
  app.add_option("--json", path, what)->type_name("FILE|-");
}

// Here, where every program of MFS takes it from.
[[gnu::used, gnu::section(".preinit_array")]] void (*const before_libraries)(int, char**,
                                                                             char**) = prepare_openblas;

int run_program(const char* name, int argc, char** argv, const std::function<void(CLI::App&)>& define,
                const std::function<ExitCode(const CLI::App&)>& run) {
  begin_again_for_blas(name, argv);
  // A reader that went away and a file that may not grow are errors of writing, and reported as such.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return parse_and_run(name, argc, argv, define, run);
  } catch (...) {
    const Failure failure = describe_current_exception();
    std::fprintf(stderr, "%s: %s\n", name, failure.message.c_str());
    return static_cast<int>(failure.code);
  }
}

}  // namespace mfs::program
