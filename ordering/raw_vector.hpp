// A std::vector whose resize leaves numbers as they are in memory: for arrays of the size of the matrix that
// several threads fill, so that each page is first touched by the thread that writes it, and only once. Large
// ones ask for huge pages.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "ordering/huge_pages.hpp"

namespace mfs {

template <class T>
struct DefaultInitAllocator : std::allocator<T> {
  template <class U>
  struct rebind {  // NOLINT(readability-identifier-naming): the standard's name
    using other = DefaultInitAllocator<U>;
  };
  T* allocate(std::size_t count) {
    T* const memory = std::allocator<T>::allocate(count);
    ask_for_huge_pages(memory, count * sizeof(T));
    return memory;
  }
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
