#include "dae/output/plots.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "plot_script.hpp"

extern char** environ;

namespace mfs::dae {
namespace {

struct Outcome {
  int code;  // exit code; -1: could not be started, or killed
  std::string text;
};

// Runs a program with both its streams in one pipe.
Outcome run(const std::vector<std::string>& words) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return {-1, std::strerror(errno)};
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  Outcome outcome{-1, error == 0 ? "" : words[0] + ": " + std::strerror(error)};
  std::array<char, 4096> buffer{};
  for (ssize_t got = 0; error == 0 && (got = read(ends[0], buffer.data(), buffer.size())) > 0;)
    outcome.text.append(buffer.data(), static_cast<std::size_t>(got));
  close(ends[0]);
  int status = 0;
  if (error == 0 && waitpid(child, &status, 0) == child && WIFEXITED(status))
    outcome.code = WEXITSTATUS(status);
  return outcome;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t from = 0, to = 0; from < text.size(); from = to + 1) {
    to = std::min(text.find('\n', from), text.size());
    lines.push_back(text.substr(from, to - from));
  }
  return lines;
}

PlotOutcome draw(const std::string& folder, const char* program_name) {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return {{}, "/proc/self/exe: " + error.message()};
  const std::filesystem::path plot_results = program.parent_path() / kPlotScript;
  const std::string script = (plot_results.parent_path() / program_name).string();
  // Debian's Python is the one that has Debian's matplotlib; another may come first on the PATH.
  const Outcome outcome = run({"/usr/bin/python3", script, folder});
  std::vector<std::string> lines = lines_of(outcome.text);
  if (outcome.code == 0) return {std::move(lines), ""};
  return {{}, lines.empty() ? std::string(program_name) + " failed" : lines.back()};
}

}  // namespace

PlotOutcome draw_plots(const std::string& folder) {
  return draw(folder, "plot_results");
}

PlotOutcome draw_modes(const std::string& folder) {
  return draw(folder, "plot_modes");
}

}  // namespace mfs::dae
