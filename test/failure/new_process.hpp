// Work in a process of its own, forked from that of the test.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include <gtest/gtest.h>

namespace mfs::test {

/// What `work` returns there; 1000 and the signal that ended it, SIGALRM after so many seconds; -1 where
/// there was no process to be had.
template <class Work>
int in_new_process(const Work& work, unsigned seconds = 20) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(seconds);  // a process that hangs ends by a signal
    std::_Exit(work());
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

/// No check may fail there.
template <class Work>
void check_in_new_process(const Work& work) {
  const auto checked = [&] {
    work();
    return testing::Test::HasFailure() ? 1 : 0;
  };
  EXPECT_EQ(in_new_process(checked, 60), 0);
}

}  // namespace mfs::test
