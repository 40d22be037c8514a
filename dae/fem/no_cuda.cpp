// In place of cuda/device_force.cpp where MFS is built without CUDA.
#include <mfs/error.hpp>

#include "dae/fem/device_force.hpp"

namespace mfs::dae {

std::unique_ptr<DeviceForce> make_device_force(const SolidBody&, int, int) {
  throw BackendError("CUDA", 0, "this build of MFS has no CUDA backend");
}

}  // namespace mfs::dae
