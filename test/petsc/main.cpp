// GoogleTest inside a PETSc session that loads the plug-in as its users do. Errors of PETSc are returned, not
// printed.
#include <gtest/gtest.h>
#include <petscsys.h>

#include "test_paths.hpp"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  char name[] = "test_petsc", append[] = "-dll_append", plugin[] = MFS_PETSC_PLUGIN;
  char* arguments[] = {name, append, plugin, nullptr};
  int count = 3;
  char** given = arguments;
  if (PetscInitialize(&count, &given, nullptr, nullptr) != 0) return 1;
  PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr);
  const int result = RUN_ALL_TESTS();
  PetscPopErrorHandler();
  PetscFinalize();
  return result;
}
