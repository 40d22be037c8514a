#include "kernels/runtime/arena.hpp"

#include <sys/mman.h>

namespace mfs {

HostArena::HostArena(Offset bytes) : RawArena(bytes) {
  data_ = ::operator new(static_cast<std::size_t>(bytes), std::align_val_t(kAlignment));
  // Huge pages save most of the address translation of the factor; refusal is no error.
  constexpr Offset kWorthwhile = Offset(4) << 20;
  if (bytes >= kWorthwhile)
    madvise(data_, static_cast<std::size_t>(bytes) / kAlignment * kAlignment, MADV_HUGEPAGE);
}

}  // namespace mfs
