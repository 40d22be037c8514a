// A Kokkos with CUDA does not start without a device.
#pragma once

#include <cstdio>

#include <Kokkos_Core.hpp>

/// Whether the program's Kokkos can start; says why its tests are skipped where it cannot.
inline bool kokkos_can_start() {
#ifdef KOKKOS_ENABLE_CUDA
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
    std::puts("skipped: no CUDA device");
    return false;
  }
#endif
  return true;
}
