// Ctrl-C, or SIGTERM from a batch system: the first asks the run to end, and what is there is written; the
// second ends the process at once, as it would have.
#pragma once

#include <stdexcept>
#include <string>

namespace mfs::program {

/// describe_current_exception() knows it.
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(int signal);
  int signal() const { return signal_; }

 private:
  int signal_;
};

/// From now on SIGINT and SIGTERM are requests.
void catch_interrupts();
/// Whether one has come.
bool is_interrupted();
/// Throws Interrupted where one has come.
void throw_if_interrupted();

}  // namespace mfs::program
