// Kokkos' CUDA space: memory by the seam to the CUDA runtime, a stream of its own, and cuBLAS.
#pragma once

#include <optional>

#include "kernels/cuda/runtime/device.hpp"
#include "kernels/dense/device_blas.hpp"
#include "kernels/runtime/engine.hpp"
#include "kernels/space/space.hpp"

namespace mfs {

template <>
struct Space<Kokkos::Cuda> {
  static void start() { Engine::use_cuda(); }
  static std::size_t free_memory() { return static_cast<std::size_t>(cuda::free_memory()); }

  using Arena = cuda::DeviceArena;
  using HostSide = cuda::PinnedArena;

  class Queue {
   public:
    Queue() : exec_(stream_.get()) {}
    const Kokkos::Cuda& exec() const { return exec_; }
    void to_space(void* to, const void* from, Offset bytes) const { stream_.to_device(to, from, bytes); }
    void to_host(void* to, const void* from, Offset bytes) const { stream_.to_host(to, from, bytes); }
    void fill(void* place, int byte, Offset bytes) const { stream_.fill(place, byte, bytes); }
    /// Throws BackendError for what failed in it.
    void wait() const { stream_.synchronize(); }

    static constexpr bool kLibrary = true;
    void open_library() { blas_.emplace(stream_); }
    template <class S>
    void gemm_minus(Vertex m, Vertex n, Vertex k, const S* a, Vertex lda, const S* b, Vertex ldb, S* c,
                    Vertex ldc) const {
      blas_->gemm_minus<S>(m, n, k, a, lda, b, ldb, c, ldc);
    }
    Offset library_bytes() const { return blas_ ? blas_->bytes() : 0; }

   private:
    cuda::Stream stream_;
    Kokkos::Cuda exec_;
    std::optional<cuda::DeviceBlas> blas_;
  };
};

}  // namespace mfs
