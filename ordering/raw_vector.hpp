// A std::vector whose resize leaves numbers as they are in memory: for arrays of the size of the matrix that
// several threads fill, so that each page is first touched by the thread that writes it, and only once.
#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace mfs {

template <class T>
struct DefaultInitAllocator : std::allocator<T> {
  template <class U>
  struct rebind {  // NOLINT(readability-identifier-naming): the standard's name
    using other = DefaultInitAllocator<U>;
  };
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    if constexpr (sizeof...(Arguments) == 0) {
      ::new (static_cast<void*>(place)) U;
    } else {
      ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
    }
  }
};

template <class T>
using RawVector = std::vector<T, DefaultInitAllocator<T>>;

}  // namespace mfs
