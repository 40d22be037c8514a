// The forces of a whole body on a device: elements first, each by the same source as on the host
// (solid_force.hpp), then the sums at the nodes, each by one thread in the order of the elements. So nothing
// is atomic, and the same state gives the same bits. Derivatives are summed colour by colour
// (cuda/device_tangent.hpp).
#pragma once

#include <memory>
#include <vector>

#include "dae/fem/mesh.hpp"
#include "dae/fem/solid_force.hpp"
#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

/// A body as SolidGroup keeps it. Borrowed while the device's copy is made.
struct SolidBody {
  const Mesh& mesh;
  SolidConstants constants;
  SolidInertia inertia;
  const std::vector<double>& mass;  ///< of one element after the other
  int first_coordinate;             ///< of node 0 in the system
};

/// In a system of so many coordinates. All memory of the device is taken here, and that for the rows of a
/// matrix when their places are given. `threads`: of the host, for the copies of each evaluation. Throws
/// BackendError where there is no device, or this build has no CUDA, and OutOfMemory.
std::unique_ptr<DeviceForce> make_device_force(const SolidBody& body, int coordinates, int threads);

}  // namespace mfs::dae
