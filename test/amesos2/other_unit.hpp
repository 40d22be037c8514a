// A translation unit that uses Amesos2 and has never heard of MFS.
#pragma once

#include <string>

namespace mfs::test {

struct OtherUnit {
  std::string solver;  ///< name() of what create made
  double error = 0;    ///< of its solution
  bool known = false;  ///< what query says
};

/// Amesos2::create with that name, through each of its forms (0: string and A; 1: const char*; 2: string).
OtherUnit create_in_other_unit(const std::string& name, int form);

}  // namespace mfs::test
