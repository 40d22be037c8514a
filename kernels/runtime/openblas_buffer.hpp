// OpenBLAS works in buffers of 128 MiB of address space. Where one finds no room it asks again without end,
// so whoever calls it has to ask first.
#pragma once

#include <sys/mman.h>

#include <cstddef>

namespace mfs {

/// BUFFER_SIZE for x86-64, and what OpenBLAS and malloc put around it, in bytes.
constexpr std::size_t kOpenblasBuffer = (std::size_t{128} << 20) + (std::size_t{1} << 20);

inline bool room_for_openblas_buffer() {
  void* room = mmap(nullptr, kOpenblasBuffer, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) return false;
  munmap(room, kOpenblasBuffer);
  return true;
}

}  // namespace mfs
