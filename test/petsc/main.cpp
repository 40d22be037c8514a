// GoogleTest inside a PETSc session that loads the plug-in as its users do. Errors of PETSc are returned, not
// printed.
#include <gtest/gtest.h>
#include <petscsys.h>

#include "test_paths.hpp"

namespace {

/// PETSc's own that does so has another name in newer versions.
PetscErrorCode return_error(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType,
                            const char*, void*) {
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  char name[] = "test_petsc", append[] = "-dll_append", plugin[] = MFS_PETSC_PLUGIN;
  char* arguments[] = {name, append, plugin, nullptr};
  int count = 3;
  char** given = arguments;
  if (PetscInitialize(&count, &given, nullptr, nullptr) != 0) return 1;
  PetscPushErrorHandler(return_error, nullptr);
  const int result = RUN_ALL_TESTS();
  PetscPopErrorHandler();
  PetscFinalize();
  return result;
}
