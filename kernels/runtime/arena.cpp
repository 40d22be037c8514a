#include "kernels/runtime/arena.hpp"

#include "ordering/huge_pages.hpp"

namespace mfs {

HostArena::HostArena(Offset bytes) : RawArena(bytes) {
  data_ = ::operator new(static_cast<std::size_t>(bytes), std::align_val_t(kAlignment));
  ask_for_huge_pages(data_, static_cast<std::size_t>(bytes));  // fewer address translations of the factor
}

}  // namespace mfs
