// A program of which no unit includes Amesos2_MFS.hpp; it only links the library, last.
#include <cstdio>

#include <Tpetra_Core.hpp>

#include "test/amesos2/other_unit.hpp"

int main(int argc, char** argv) {
  Tpetra::ScopeGuard scope(&argc, &argv);
  for (int form = 0; form < 3; ++form) {
    const auto made = mfs::test::create_in_other_unit("MFS", form);
    std::printf("form %d: %s, error %.1e, query %d\n", form, made.solver.c_str(), made.error, made.known);
    if (made.solver != "MFS" || !(made.error < 1e-11) || !made.known) return 1;
  }
  return 0;
}
