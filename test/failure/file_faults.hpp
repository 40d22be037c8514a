// The system's calls for files as a process of these tests makes them: one of a kind can be let fail, give
// less than was asked for, or be interrupted. What is defined here stands before the C library.
#pragma once

#include <string>

namespace mfs::test {

enum class FileCall { open, reserve, write, read };

struct FileFault {
  FileCall call{};
  long at = 0;            // 0: the first such call
  int error = 0;          // its error number; 0: it moves half of the bytes only
  bool for_good = false;  // and all calls of the kind from there on
};

/// One at a time. Counts calls from here on.
void plan_fault(const FileFault& fault);
/// Ends it, and says whether it has come to pass.
bool end_fault();
/// Calls of a kind since the last plan_fault.
long file_calls(FileCall call);
/// The descriptor of the factor file that was made last.
int factor_file();

}  // namespace mfs::test
