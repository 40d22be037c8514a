// One block of memory, cut into regions whose sizes are known beforehand.
#pragma once

#include <cstddef>
#include <new>

#include "ordering/types.hpp"

namespace mfs {

constexpr Offset kRegionAlignment = 64;  // bytes: a cache line, a vector register

/// Adds up the regions of an arena in the order in which they are then taken from it.
class ArenaLayout {
 public:
  /// Returns the offset of the new region.
  Offset add(Offset bytes) {
    const Offset begin = total_;
    total_ += (bytes + kRegionAlignment - 1) / kRegionAlignment * kRegionAlignment;
    return begin;
  }
  Offset total() const { return total_; }

 private:
  Offset total_ = 0;
};

/// What all kinds of memory are once they have been taken.
class RawArena {
 public:
  RawArena(const RawArena&) = delete;
  RawArena& operator=(const RawArena&) = delete;

  template <class T>
  T* at(Offset offset) const {
    return reinterpret_cast<T*>(static_cast<char*>(data_) + offset);
  }
  Offset bytes() const { return bytes_; }

 protected:
  explicit RawArena(Offset bytes) : bytes_(bytes) {}
  ~RawArena() = default;
  Offset bytes_;
  void* data_ = nullptr;
};

/// Host memory of one arena; pages are touched first by the thread that fills them. Throws std::bad_alloc.
class HostArena : public RawArena {
 public:
  explicit HostArena(Offset bytes);
  ~HostArena() { ::operator delete(data_, std::align_val_t(kAlignment)); }

 private:
  static constexpr std::size_t kAlignment = 4096;
};

}  // namespace mfs
