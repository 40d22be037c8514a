// Kokkos' CUDA space: memory by the seam to the CUDA runtime, a stream of its own, and cuBLAS.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/cuda/runtime/device.hpp"
#include "kernels/dense/device_blas.hpp"
#include "kernels/runtime/engine.hpp"
#include "kernels/space/space.hpp"

namespace mfs {

/// Streams with an instance of Kokkos for each. They are kept for the next queue, as instances are made of
/// many allocations, and Kokkos 3.4 ends the process where one of those fails.
class CudaInstances {
 public:
  struct Instance {
    cuda::Stream stream;
    Kokkos::Cuda exec{stream.get()};
  };
  static std::unique_ptr<Instance> take() {
    CudaInstances& all = instance();
    const std::lock_guard<std::mutex> lock(all.mutex_);
    if (all.free_.empty()) {
      all.free_.reserve(++all.made_);
      return std::make_unique<Instance>();
    }
    std::unique_ptr<Instance> taken = std::move(all.free_.back());
    all.free_.pop_back();
    return taken;
  }
  static void give_back(std::unique_ptr<Instance> instance_of) noexcept {
    instance_of->stream.drain();
    CudaInstances& all = instance();
    const std::lock_guard<std::mutex> lock(all.mutex_);
    if (all.free_.size() < all.free_.capacity()) all.free_.push_back(std::move(instance_of));
  }

 private:
  // Never destroyed: Kokkos may be gone by then.
  static CudaInstances& instance() {
    static auto* const all = new CudaInstances;
    return *all;
  }
  std::mutex mutex_;
  std::vector<std::unique_ptr<Instance>> free_;
  std::size_t made_ = 0;
};

template <>
struct Space<Kokkos::Cuda> {
  static void start() { Engine::use_cuda(); }
  static std::size_t free_memory() { return static_cast<std::size_t>(cuda::free_memory()); }

  static void require_reachable(const void* array, const char* name) { cuda::require_reachable(array, name); }

  using Arena = cuda::DeviceArena;
  using HostSide = cuda::PinnedArena;

  class Queue {
   public:
    Queue() : instance_(CudaInstances::take()) {}
    ~Queue() { CudaInstances::give_back(std::move(instance_)); }
    Queue(const Queue&) = delete;
    Queue& operator=(const Queue&) = delete;

    const Kokkos::Cuda& exec() const { return instance_->exec; }
    const cuda::Stream& stream() const { return instance_->stream; }
    void to_space(void* to, const void* from, Offset bytes) const { stream().to_device(to, from, bytes); }
    void to_host(void* to, const void* from, Offset bytes) const { stream().to_host(to, from, bytes); }
    void copy_within(void* to, const void* from, Offset bytes) const {
      stream().copy_columns(to, bytes, from, bytes, bytes, 1);
    }
    void fill(void* place, int byte, Offset bytes) const { stream().fill(place, byte, bytes); }
    void follow(void* foreign_stream) {
      foreign_.record_foreign(foreign_stream);
      stream().wait_for(foreign_);
    }
    /// Throws BackendError for what failed in it.
    void wait() const { stream().synchronize(); }

    static constexpr bool kLibrary = true;
    void open_library() { blas_.emplace(stream()); }
    template <class S>
    void gemm_minus(Vertex m, Vertex n, Vertex k, const S* a, Vertex lda, const S* b, Vertex ldb, S* c,
                    Vertex ldc) const {
      blas_->gemm_minus<S>(m, n, k, a, lda, b, ldb, c, ldc);
    }
    Offset library_bytes() const { return blas_ ? blas_->bytes() : 0; }

   private:
    std::unique_ptr<CudaInstances::Instance> instance_;
    cuda::Event foreign_;
    std::optional<cuda::DeviceBlas> blas_;
  };

  /// The first run makes the launches and records them; later ones replay them, which allocates nothing.
  class Launches {
   public:
    template <class Work>
    void run(const Queue& queue, const Work& work) {
      if (graph_.recorded()) return graph_.launch(queue.stream());
      work();
      graph_.record(queue.stream(), work);
    }
    void forget() { graph_.reset(); }

   private:
    cuda::Graph graph_;
  };
};

}  // namespace mfs
