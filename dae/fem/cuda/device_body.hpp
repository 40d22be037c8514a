// What the kernels of a body share: the body, and how lanes hold an element's points.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "dae/fem/mesh.hpp"
#include "dae/fem/solid_force.hpp"
#include "kernels/runtime/arena.hpp"

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
    for (int step = 1; step < width; step *= 2) x = __dadd_rn(x, exchange(x, step));
    return x;
  }
  // Sum number i goes to lane i % width.
  template <int total, class F, class Take>
  __device__ static void sum_all(const F& f, const Take& take) {
#pragma unroll
    for (int first = 0; first < total; first += width) {
      const double sum = sums<width, total>(first, f);
      if (first + lane() < total) take(first + lane(), sum);
    }
  }

 private:
  // x of the lane that differs by `step`.
  __device__ static double exchange(double x, int step) {
    const unsigned first = threadIdx.x % 32 / width * width;
    const unsigned lanes = (width == 32 ? ~0U : (1U << width % 32) - 1) << first;
    return __shfl_xor_sync(lanes, x, step);
  }
  // Of the sums first ... first + count - 1, over all lanes that differ by less than count, that of number
  // first + lane() % count. Lanes that differ by count / 2 exchange half of what they have.
  template <int count, int total, class F>
  __device__ static double sums(int first, const F& f) {
    if constexpr (count == 1) {
      return first < total ? f(first) : 0.0;
    } else {
      constexpr int half = count / 2;
      const double low = sums<half, total>(first, f), high = sums<half, total>(first + half, f);
      const bool upper = (lane() & half) != 0;
      return __dadd_rn(upper ? high : low, exchange(upper ? low : high, half));
    }
  }
};

// The body on the device. Coordinates are those of the body: 3 i + k of node i.
struct DeviceBody {
  int elements, nodes;
  SolidConstants constants;
  SolidInertia inertia;
  const double* mass;
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

// What does not change with the state. Numbers of the points: [which][element][lane].
template <ElementKind kind>
struct DeviceUndeformed {
  static constexpr int numbers = 10;  // of a point

  const PointGradients<kind>* cell;
  double* map;
  Modes<kind>* modes;  // of each element

  __device__ double& number(const DeviceBody& body, int which, int e) const {
    constexpr int width = PointLanes<kind>::width;
    return map[(std::int64_t{which} * body.elements + e) * width + PointLanes<kind>::lane()];
  }
  __device__ void store(const DeviceBody& body, int e, const Undeformed<kind, PointLanes<kind>>& from) const {
    for (int i = 0; i < 9; ++i) number(body, i, e) = from.map.inverse[i][0];
    number(body, 9, e) = from.map.weight[0];
    if (PointLanes<kind>::lane() == 0) modes[e] = from.modes;
  }
  __device__ void load(const DeviceBody& body, int e, PointMaps<kind, PointLanes<kind>>& to) const {
    for (int i = 0; i < 9; ++i) to.inverse[i][0] = number(body, i, e);
    to.weight[0] = number(body, 9, e);
  }
};

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
