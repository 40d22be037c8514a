// What the execution spaces of Kokkos differ in beside their kernels: memory of their own, copies to it and
// back, an instance to launch in, and a library for large products, if there is one. Every other file that
// serves all spaces goes through here.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <type_traits>

#include <Kokkos_Core.hpp>

#include <mfs/error.hpp>
#include "kernels/runtime/arena.hpp"
#include "kernels/runtime/scalars.hpp"

namespace mfs {

/// Whether kernels of the space work in the memory of the host, by threads of it: one thread is a team.
template <class Exec>
constexpr bool kOnHost = std::is_same_v<typename Exec::memory_space, Kokkos::HostSpace>;

/// Memory of a device. Throws OutOfMemory(device).
template <class Exec>
class KokkosArena : public RawArena {
 public:
  explicit KokkosArena(Offset bytes) : RawArena(bytes) {
    try {
      data_ =
          Kokkos::kokkos_malloc<typename Exec::memory_space>("mfs::arena", static_cast<std::size_t>(bytes));
    } catch (const std::exception&) {  // versions of Kokkos throw what they like
    }
    if (!data_) throw OutOfMemory(MemorySpace::device, static_cast<std::size_t>(bytes), 0);
  }
  ~KokkosArena() { Kokkos::kokkos_free<typename Exec::memory_space>(data_); }
};

/// Any space: the instance that Kokkos has, its memory and its copies.
template <class Exec>
struct Space {
  /// Before its first use in a process; inside Engine::run.
  static void start() {}
  /// Bytes free in its memory, as far as it tells.
  static std::size_t free_memory() { return std::numeric_limits<std::size_t>::max(); }

  /// Throws InvalidInput(name) for a caller's array that kernels cannot reach, as far as it tells.
  static void require_reachable(const void*, const char*) {}

  /// Where kernels work.
  using Arena = std::conditional_t<kOnHost<Exec>, HostArena, KokkosArena<Exec>>;
  /// Memory of the host that is copied from and to.
  using HostSide = HostArena;

  /// Launches and copies, one after the other.
  class Queue {
   public:
    const Exec& exec() const { return exec_; }
    void to_space(void* to, const void* from, Offset bytes) const {
      copy<typename Exec::memory_space, Kokkos::HostSpace>(to, from, bytes);
    }
    void to_host(void* to, const void* from, Offset bytes) const {
      copy<Kokkos::HostSpace, typename Exec::memory_space>(to, from, bytes);
    }
    void copy_within(void* to, const void* from, Offset bytes) const {
      copy<typename Exec::memory_space, typename Exec::memory_space>(to, from, bytes);
    }
    /// What the caller put into a stream before comes first.
    void follow(void*) { Kokkos::fence(); }
    /// Fills with one byte.
    void fill(void* place, int byte, Offset bytes) const {
      if constexpr (kOnHost<Exec>) {
        std::memset(place, byte, static_cast<std::size_t>(bytes));
      } else {
        Kokkos::View<char*, typename Exec::memory_space, Kokkos::MemoryUnmanaged> view(
            static_cast<char*>(place), static_cast<std::size_t>(bytes));
        Kokkos::deep_copy(exec_, view, static_cast<char>(byte));
      }
    }
    void wait() const { exec_.fence(); }

    /// No library: products are kernels like all else.
    static constexpr bool kLibrary = false;
    void open_library() {}
    template <class S>
    void gemm_minus(Vertex, Vertex, Vertex, const S*, Vertex, const S*, Vertex, S*, Vertex) const {}
    Offset library_bytes() const { return 0; }

   private:
    template <class To, class From>
    void copy(void* to, const void* from, Offset bytes) const {
      if (bytes == 0) return;
      if constexpr (kOnHost<Exec>) {
        std::memcpy(to, from, static_cast<std::size_t>(bytes));
      } else {
        const auto count = static_cast<std::size_t>(bytes);
        Kokkos::deep_copy(
            exec_, Kokkos::View<char*, To, Kokkos::MemoryUnmanaged>(static_cast<char*>(to), count),
            Kokkos::View<const char*, From, Kokkos::MemoryUnmanaged>(static_cast<const char*>(from), count));
      }
    }
    Exec exec_;
  };

  /// Launches that are made again and again: work() puts them into the queue, the same ones each time, and
  /// waits for nothing.
  class Launches {
   public:
    template <class Work>
    void run(const Queue&, const Work& work) {
      work();
    }
    /// The next ones are others.
    void forget() {}
  };
};

}  // namespace mfs

#ifdef MFS_CUDA
#include "kernels/space/cuda_space.hpp"
#endif
