// Runs the program mfs as a user does, and sees what a user sees.
#pragma once

#include <fcntl.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "test/program/temporary_folder.hpp"
#include "test_paths.hpp"

struct ProgramRun {
  int code = -1;  ///< exit code; 1000 + signal if it was killed
  std::string out, err;
};

/// Where the program's output goes: into ProgramRun, or to a file such as /dev/full; what it reads; its
/// limits.
struct Streams {
  std::string out;           ///< a path; empty: ProgramRun::out
  bool terminal = false;     ///< standard error is a terminal
  bool closed_pipe = false;  ///< standard output is a pipe that nobody reads
  std::string in{};          ///< path of standard input; empty: /dev/null
  rlim_t address_space = RLIM_INFINITY, file_size = RLIM_INFINITY;  ///< bytes
  std::vector<std::pair<std::string, std::string>> environment{};   ///< added to the test's own
  std::string program = MFS_PROGRAM;                                ///< or another one
};

// What takes longer hangs: the program is then killed by SIGALRM.
constexpr unsigned kHangs = 300;

inline void limit_program(const Streams& streams) {
  const std::string in = streams.in.empty() ? "/dev/null" : streams.in;
  dup2(open(in.c_str(), O_RDONLY), STDIN_FILENO);
  for (const auto& [variable, value] : streams.environment) setenv(variable.c_str(), value.c_str(), 1);
  const rlimit space{streams.address_space, streams.address_space},
      size{streams.file_size, streams.file_size};
  if (streams.address_space != RLIM_INFINITY) setrlimit(RLIMIT_AS, &space);
  if (streams.file_size != RLIM_INFINITY) setrlimit(RLIMIT_FSIZE, &size);
  alarm(kHangs);
}

inline void exec_program(const std::vector<std::string>& arguments,
                         const std::string& program = MFS_PROGRAM) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  _exit(127);
}

// A terminal must be read while the program runs; the end comes as an error once the program is gone.
inline std::string read_terminal(int terminal) {
  std::string text;
  char buffer[4096];
  for (ssize_t got; (got = read(terminal, buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(got));
  close(terminal);
  return text;
}

inline ProgramRun run_program(const std::vector<std::string>& arguments, const Streams& streams = {}) {
  const TemporaryFolder folder;
  const std::string out = streams.out.empty() ? folder.path("out") : streams.out, err = folder.path("err");
  int terminal = -1, program_side = -1, pipe_ends[2] = {-1, -1};
  if (streams.terminal && openpty(&terminal, &program_side, nullptr, nullptr, nullptr) != 0)
    throw std::runtime_error("no pseudo-terminal");
  if (streams.closed_pipe && pipe(pipe_ends) != 0) throw std::runtime_error("no pipe");
  if (streams.closed_pipe) close(pipe_ends[0]);
  const pid_t child = fork();
  if (child == 0) {
    const int out_file =
        streams.closed_pipe ? pipe_ends[1] : open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int err_file =
        streams.terminal ? program_side : open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(out_file, STDOUT_FILENO);
    dup2(err_file, STDERR_FILENO);
    limit_program(streams);
    exec_program(arguments, streams.program);
  }
  if (streams.closed_pipe) close(pipe_ends[1]);
  ProgramRun run;
  if (streams.terminal) {
    close(program_side);
    run.err = read_terminal(terminal);
  }
  int status = 0;
  waitpid(child, &status, 0);
  run.code = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  if (streams.out.empty() && !streams.closed_pipe) run.out = text_of(out);
  if (!streams.terminal) run.err = text_of(err);
  return run;
}
