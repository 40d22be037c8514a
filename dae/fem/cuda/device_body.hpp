// What the kernels of a body share: the body, and how lanes hold an element's points.
#pragma once

#include <algorithm>
#include <vector>

#include "dae/fem/mesh.hpp"
#include "dae/fem/solid_force.hpp"
#include "kernels/arena.hpp"

namespace mfs::dae {

// The points of an element, one to each lane. Lanes beyond the last point hold it, too, with no weight.
template <ElementKind kind>
struct PointLanes {
  static constexpr int count = 1;
  static constexpr int width = kind == ElementKind::hex8 ? 8 : kind == ElementKind::hex20 ? 32 : 4;
  static_assert(width >= Sizes<kind>::points);

  __device__ static int lane() { return static_cast<int>(threadIdx.x) % width; }
  __device__ static int point(int) { return min(lane(), Sizes<kind>::points - 1); }
  // Each lane adds the same pairs, so all get the same bits, as long as no product is contracted into a sum.
  __device__ static double sum(double x) {
    const unsigned first = threadIdx.x % 32 / width * width;
    const unsigned lanes = (width == 32 ? ~0U : (1U << width % 32) - 1) << first;
    for (int step = 1; step < width; step *= 2) x = __dadd_rn(x, __shfl_xor_sync(lanes, x, step));
    return x;
  }
};

// The body on the device. Coordinates are those of the body: 3 i + k of node i.
struct DeviceBody {
  int elements, nodes;
  SolidConstants constants;
  SolidInertia inertia;
  const double *reference, *mass;
  const int* connectivity;
  const int *slot_start, *slot;  // of each node: its places among the nodes of all elements
  const double *q, *v, *a;
  double *element_force, *force;
};

/// The three numbers of each node of an element.
template <ElementKind kind>
__device__ void gather(const int* nodes, const double* from, double* to) {
  for (int i = 0; i < Sizes<kind>::nodes; ++i)
    for (int k = 0; k < 3; ++k) to[3 * i + k] = from[3 * nodes[i] + k];
}

/// The points of this thread's lane.
template <ElementKind kind>
__device__ void load_cell(const PointGradients<kind>& whole_cell,
                          PointGradients<kind, PointLanes<kind>>& cell) {
  const int lane = PointLanes<kind>::lane(), point = PointLanes<kind>::point(0);
  for (int a = 0; a < 3; ++a)
    for (int i = 0; i < Sizes<kind>::nodes; ++i) cell.gradient[a][i][0] = whole_cell.gradient[a][i][point];
  cell.weight[0] = lane == point ? whole_cell.weight[point] : 0.0;
}

// Where each node is among the nodes of all elements.
struct Slots {
  std::vector<int> start, slot;

  explicit Slots(const Mesh& mesh) : start(mesh.nodes.size() + 1), slot(mesh.elements.size()) {
    for (const int node : mesh.elements) ++start[static_cast<std::size_t>(node) + 1];
    for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
    std::vector<int> next = start;
    for (std::size_t k = 0; k < mesh.elements.size(); ++k)
      slot[static_cast<std::size_t>(next[static_cast<std::size_t>(mesh.elements[k])]++)] =
          static_cast<int>(k);
  }
};

inline Offset bytes_of(std::size_t doubles) {
  return static_cast<Offset>(doubles * sizeof(double));
}

}  // namespace mfs::dae
