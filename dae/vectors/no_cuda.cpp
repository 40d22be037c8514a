// In place of cuda/cuda_queue.cpp where MFS is built without CUDA.
#include <mfs/error.hpp>

#include "dae/vectors/device_queue.hpp"

namespace mfs::dae {

std::unique_ptr<DeviceQueue> make_device_queue() {
  throw BackendError("CUDA", 0, "this build of MFS has no CUDA backend");
}

}  // namespace mfs::dae
