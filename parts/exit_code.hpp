// What the program tells its caller when it ends, and how an exception becomes that.
#pragma once

#include <string>

namespace mfs::program {

enum class ExitCode {
  solved = 0,
  usage = 2,
  invalid_input = 3,  // also: an output file that cannot be written
  singular = 4,
  out_of_memory = 5,
  accuracy_not_reached = 6,
  backend = 7,        // a library or device failed, or the program itself
  interrupted = 130,  // by SIGINT: 128 + the signal, as shells have it
  terminated = 143,   // by SIGTERM
};

/// "solved", "invalid_input", ...: the status of the JSON report.
const char* status_word(ExitCode code);

struct Failure {
  ExitCode code;
  std::string message;  ///< one line
  /// Of the JSON report: the code's, or "failed" where a method found no result.
  const char* status = nullptr;
};

/// Inside a catch block: what the current exception means.
Failure describe_current_exception();

}  // namespace mfs::program
