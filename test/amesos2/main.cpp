// GoogleTest inside a Tpetra session. On several ranks every rank runs every test; rank 0 reports, the others
// only their failures.
#include <gtest/gtest.h>

#include <Tpetra_Core.hpp>

#include "test/kokkos_device.hpp"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (!kokkos_can_start()) return 0;
  Tpetra::ScopeGuard scope(&argc, &argv);
  if (Tpetra::getDefaultComm()->getRank() != 0) {
    ::testing::TestEventListeners& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_xml_generator());
  }
  return RUN_ALL_TESTS();
}
