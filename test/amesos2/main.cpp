// GoogleTest inside a Tpetra session. On several ranks every rank runs every test; rank 0 reports, the others
// only their failures. A Tpetra with CUDA does not start without a device: then nothing is tested.
#include <gtest/gtest.h>

#include <cstdio>

#include <Kokkos_Core.hpp>
#include <Tpetra_Core.hpp>

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
#ifdef KOKKOS_ENABLE_CUDA
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
    std::puts("skipped: no CUDA device");
    return 0;
  }
#endif
  Tpetra::ScopeGuard scope(&argc, &argv);
  if (Tpetra::getDefaultComm()->getRank() != 0) {
    ::testing::TestEventListeners& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_xml_generator());
  }
  return RUN_ALL_TESTS();
}
