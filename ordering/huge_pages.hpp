// Large arrays in huge pages. For one that is filled once, page faults may take longer than filling it.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace mfs {

/// Asks for huge pages where `memory` is large enough for them; refusal is no error. For memory that no
/// thread has written to yet.
inline void ask_for_huge_pages(void* memory, std::size_t bytes) {
  constexpr std::size_t kWorthwhile = std::size_t(4) << 20, kPage = 4096;
  if (bytes < kWorthwhile) return;
  const std::size_t before_page = (kPage - reinterpret_cast<std::uintptr_t>(memory) % kPage) % kPage;
  madvise(static_cast<char*>(memory) + before_page, (bytes - before_page) / kPage * kPage, MADV_HUGEPAGE);
}

}  // namespace mfs
