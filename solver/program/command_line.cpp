#include "solver/program/command_line.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <mfs/version.hpp>

#include "kernels/engine.hpp"

namespace mfs::program {
namespace {

const std::vector<std::pair<std::string, Backend>> kBackends{
    {"serial", Backend::serial}, {"openmp", Backend::openmp}, {"cuda", Backend::cuda}};

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

/// What OpenBLAS should have found in the environment when it was loaded, before main.
std::vector<std::pair<const char*, std::string>> environment_for_blas() {
  std::vector<std::pair<const char*, std::string>> wanted;
  const std::string kernels = better_blas_kernels();
  if (!kernels.empty()) wanted.emplace_back("OPENBLAS_CORETYPE", kernels);
  // Each of its threads, which MFS never uses, takes 128 MiB of address space.
  rlimit space{};
  const bool limited = getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY;
  if (limited && !std::getenv("OPENBLAS_NUM_THREADS")) wanted.emplace_back("OPENBLAS_NUM_THREADS", "1");
  return wanted;
}

// The program begins once more where OpenBLAS should have been told something. Goes on where that cannot be,
// or where the process was begun by another file than the program (the dynamic loader, an emulator).
void begin_again_for_blas(const char* name, char** argv) {
  const auto wanted = environment_for_blas();
  if (wanted.empty()) return;
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error || self.filename() != name) return;
  for (const auto& [variable, value] : wanted)
    if (setenv(variable, value.c_str(), 0) != 0) return;
  execv(self.c_str(), argv);
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
