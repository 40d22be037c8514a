// The derivatives of a body's forces on the device. A block of threads evaluates an element by the source of
// the host (solid_tangent.hpp): lanes make what belongs to the points, then each thread has one column of the
// element's matrices and some of their rows. Elements of one colour share no node, and colours follow one
// another, so nothing is atomic and each entry gets its terms in one order. Values are kept by pairs of
// coupled nodes, 3 x 3 for each, and the host adds those to the rows of the system.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "dae/fem/cuda/device_body.hpp"
#include "dae/fem/device_force.hpp"
#include "dae/fem/solid_tangent.hpp"
#include "kernels/cuda/device.hpp"

namespace mfs::dae {

/// Who does what in the block of threads of one element: columns side by side, padded to whole warps, and
/// `rows` rows of each for one thread.
template <ElementKind kind>
struct TangentThreads {
  static constexpr int unknowns = Sizes<kind>::unknowns;
  static constexpr int columns = (unknowns + 31) / 32 * 32;
  static constexpr int rows = kind == ElementKind::hex8 ? 12 : 15;  ///< few enough for the registers
  static constexpr int count = columns * (unknowns / rows);
  static_assert(unknowns % rows == 0 && rows % 3 == 0);

  __device__ static int place() { return static_cast<int>(threadIdx.x) % columns; }
  __device__ static int column() { return min(place(), unknowns - 1); }
  __device__ static int first_row() { return static_cast<int>(threadIdx.x) / columns * rows; }
};

/// The column of this thread (see AllColumns).
template <ElementKind kind>
struct ThreadColumn {
  static constexpr int used = 1, stride = 1;
  __device__ static int column(int) { return TangentThreads<kind>::column(); }
};

/// Rows of solid_tangent.hpp that are multiplied as soon as they are there.
template <ElementKind kind>
class MultipliedRows {
 public:
  using Threads = TangentThreads<kind>;
  using Shared = double[kModes][Threads::columns];
  double force_q[Threads::rows] = {}, force_v[Threads::rows] = {};

  __device__ explicit MultipliedRows(Shared& shared) : shared_(shared) {}
  __device__ double* left() { return left_; }
  __device__ double* by_q() { return by_q_; }
  __device__ double* by_v() { return by_v_; }
  template <int count>
  __device__ void take(bool with_by_v) {
    __syncthreads();  // all have used those before
    if (Threads::first_row() == 0)
      for (int k = 0; k < count; ++k) shared_[k][Threads::place()] = left_[k];
    __syncthreads();
    const int first = Threads::first_row();
#pragma unroll
    for (int k = 0; k < count; ++k)
#pragma unroll
      for (int r = 0; r < Threads::rows; ++r) {
        const double left = shared_[k][first + r];
        force_q[r] += left * by_q_[k];
        if (with_by_v) force_v[r] += left * by_v_[k];
      }
  }

 private:
  Shared& shared_;
  double left_[kModes], by_q_[kModes], by_v_[kModes];
};

// What a lane has of its point goes to point p of all.
template <int points>
__device__ void put(int p, const double (&from)[1], double (&to)[points]) {
  to[p] = from[0];
}
template <int rows, class From, class To>
__device__ void put(int p, const From (&from)[rows], To (&to)[rows]) {
  for (int i = 0; i < rows; ++i) put(p, from[i], to[i]);
}

template <ElementKind kind>
__device__ void put_point(int p, const TangentState<kind, PointLanes<kind>>& from, TangentState<kind>& to) {
  const auto& r = from.response;
  auto& all = to.response;
  put(p, r.reference.gradient, all.reference.gradient);
  put(p, r.reference.weight, all.reference.weight);
  put(p, r.elastic.f, all.elastic.f);
  put(p, r.rate.f, all.rate.f);
  put(p, r.stress.value, all.stress.value);
  if constexpr (Enhancement<kind>::modes > 0) {
    put(p, r.enhancement.xi, all.enhancement.xi);
    if (p == 0) {
      for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 6; ++k) all.enhancement.basis[i][k] = r.enhancement.basis[i][k];
      all.enhancement.det0 = r.enhancement.det0;
      all.enhancement.linear = r.enhancement.linear;
      to.factors = from.factors;
    }
  }
  to.stiffness.same = from.stiffness.same;
  for (int i = 0; i < 36; ++i) to.stiffness.value[p][i] = from.stiffness.value[0][i];
}

/// Adds grad N_i . S grad N_j, of each direction by itself.
template <ElementKind kind>
__device__ void add_initial_stress(const Response<kind>& r, double* force_q) {
  using Threads = TangentThreads<kind>;
  const int node = Threads::column() / 3, direction = Threads::column() % 3, first = Threads::first_row() / 3;
  for (int p = 0; p < Sizes<kind>::points; ++p) {
    double stressed[3];
    for (int a = 0; a < 3; ++a) stressed[a] = stressed_gradient<kind>(r, p, a, node);
#pragma unroll
    for (int i = 0; i < Threads::rows / 3; ++i) {
      double sum = 0;
      for (int a = 0; a < 3; ++a) sum += r.reference.gradient[a][first + i][p] * stressed[a];
      for (int k = 0; k < 3; ++k) force_q[3 * i + k] += k == direction ? sum : 0.0;
    }
  }
}

/// Where the values of all pairs of nodes are: 9 of each, row by row.
struct PairValues {
  const int* pair;            ///< of each element: nodes x nodes numbers
  double *force_q, *force_v;  ///< force_v is null where there is no viscosity: the host knows it then
};

template <ElementKind kind>
__global__ void __launch_bounds__(TangentThreads<kind>::count)
    element_tangents(DeviceBody body, const PointGradients<kind>* whole_cell, const int* elements,
                     PairValues values) {
  using Threads = TangentThreads<kind>;
  using Lanes = PointLanes<kind>;
  constexpr int nodes = Sizes<kind>::nodes;
  __shared__ TangentState<kind> state;
  __shared__ typename MultipliedRows<kind>::Shared left;
  const int e = elements[blockIdx.x];

  if (threadIdx.x < Lanes::width) {
    TangentState<kind, Lanes> own;
    PointGradients<kind, Lanes> cell;
    double reference[3 * nodes], q[3 * nodes], v[3 * nodes];
    load_cell<kind>(*whole_cell, cell);
    gather<kind>(body.connectivity + e * nodes, body.reference, reference);
    gather<kind>(body.connectivity + e * nodes, body.q, q);
    gather<kind>(body.connectivity + e * nodes, body.v, v);
    prepare_tangent<kind>(body.constants, cell, reference, q, v, own);
    if (Lanes::lane() < Sizes<kind>::points) put_point<kind>(Lanes::lane(), own, state);
  }
  __syncthreads();

  MultipliedRows<kind> rows(left);
  tangent_rows<kind, ThreadColumn<kind>>(body.constants, state, rows);
  add_initial_stress<kind>(state.response, rows.force_q);

  if (Threads::place() >= Threads::unknowns) return;
  const int j = Threads::column() / 3, direction = Threads::column() % 3, first = Threads::first_row() / 3;
  const double* mass = body.mass + static_cast<std::int64_t>(e) * body.inertia.entries(nodes);
  const int* pair = values.pair + static_cast<std::int64_t>(e) * nodes * nodes;
#pragma unroll
  for (int i = 0; i < Threads::rows / 3; ++i) {
    const double damping = body.inertia.alpha * body.inertia.mass(mass, first + i, j);
    const std::int64_t place = 9 * static_cast<std::int64_t>(pair[(first + i) * nodes + j]) + direction;
    for (int k = 0; k < 3; ++k) {
      values.force_q[place + 3 * k] += rows.force_q[3 * i + k];
      if (values.force_v != nullptr)
        values.force_v[place + 3 * k] += rows.force_v[3 * i + k] + (k == direction ? damping : 0.0);
    }
  }
}

/// Pairs of nodes that an element has both of: those of node i from start[i] on, neighbours ascending.
struct NodePairs {
  std::vector<int> start, neighbour;

  NodePairs(const Mesh& mesh, const Slots& slots) : start(1) {
    const int nodes = nodes_per_element(mesh.kind), count = static_cast<int>(mesh.nodes.size());
    std::vector<int> seen_by(mesh.nodes.size(), -1);
    for (int i = 0; i < count; ++i) {
      const auto first = static_cast<std::ptrdiff_t>(neighbour.size());
      for (int s = slots.start[i]; s < slots.start[i + 1]; ++s)
        for (int k = 0; k < nodes; ++k) {
          const int j = mesh.elements[slots.slot[s] / nodes * nodes + k];
          if (seen_by[j] != i) neighbour.push_back(j);
          seen_by[j] = i;
        }
      std::sort(neighbour.begin() + first, neighbour.end());
      start.push_back(static_cast<int>(neighbour.size()));
    }
  }
  int pair(int i, int j) const {
    const auto first = neighbour.begin() + start[i], last = neighbour.begin() + start[i + 1];
    return static_cast<int>(std::lower_bound(first, last, j) - neighbour.begin());
  }
  /// Of all elements: nodes x nodes.
  std::vector<int> of_elements(const Mesh& mesh, int threads) const {
    const int nodes = nodes_per_element(mesh.kind), elements = mesh.element_count();
    std::vector<int> pairs(mesh.elements.size() * static_cast<std::size_t>(nodes));
#pragma omp parallel for num_threads(threads)
    for (int e = 0; e < elements; ++e) {
      const int* element = &mesh.elements[static_cast<std::size_t>(e * nodes)];
      int* out = &pairs[static_cast<std::size_t>(e) * static_cast<std::size_t>(nodes * nodes)];
      for (int i = 0; i < nodes; ++i)
        for (int j = 0; j < nodes; ++j) *out++ = pair(element[i], element[j]);
    }
    return pairs;
  }
};

/// Elements by colour, of as many colours as it takes: each takes the first that no neighbour before it has.
struct ElementColours {
  std::vector<int> element, start;

  ElementColours(const Mesh& mesh, const Slots& slots) : start(1) {
    const int nodes = nodes_per_element(mesh.kind);
    std::vector<int> colour(static_cast<std::size_t>(mesh.element_count()));
    std::vector<std::vector<int>> of_colour;
    std::vector<int> last_seen;  // of each colour: the last element with a neighbour that has it
    for (int e = 0; e < mesh.element_count(); ++e) {
      for (int k = 0; k < nodes; ++k) {
        const int node = mesh.elements[e * nodes + k];
        for (int s = slots.start[node]; s < slots.start[node + 1] && slots.slot[s] / nodes < e; ++s)
          last_seen[colour[slots.slot[s] / nodes]] = e;
      }
      int c = 0;
      while (c < static_cast<int>(last_seen.size()) && last_seen[c] == e) ++c;
      if (c == static_cast<int>(last_seen.size())) {
        last_seen.push_back(-1);
        of_colour.emplace_back();
      }
      colour[e] = c;
      of_colour[c].push_back(e);
    }
    for (const std::vector<int>& some : of_colour) {
      element.insert(element.end(), some.begin(), some.end());
      start.push_back(static_cast<int>(element.size()));
    }
  }
};

/// dF/dq of one body and, with viscosity, dF/dv.
template <ElementKind kind>
class DeviceTangent {
 public:
  DeviceTangent(const SolidBody& body, const Slots& slots, const cuda::Stream& stream, int threads);

  BlockSet blocks() const { return blocks_; }
  /// Evaluates `blocks`, some of the above, and begins to copy them to the host.
  void begin(const DeviceBody& body, const PointGradients<kind>* cell, BlockSet blocks,
             const cuda::Stream& stream);
  /// Adds what was begun, each block as soon as it has been copied.
  void add_to(Tangent& tangent, const TangentPattern& pattern, const cuda::Stream& stream) const;

 private:
  struct Places {
    ArenaLayout layout;
    Offset pair, element, force_q, force_v;
    Places(std::size_t incidences, std::size_t elements, std::size_t entries, bool viscous);
  };
  void add(const double* own, const Pattern& pattern, std::vector<double>& values) const;

  const int first_, threads_;
  const BlockSet blocks_;
  const NodePairs pairs_;
  const ElementColours colours_;
  const std::size_t entries_;  // of a block
  const Places places_;
  const cuda::DeviceArena device_;
  const cuda::PinnedArena host_;  // dF/dq, dF/dv
  cuda::Event force_q_copied_;
  BlockSet begun_;
};

template <ElementKind kind>
DeviceTangent<kind>::Places::Places(std::size_t incidences, std::size_t elements, std::size_t entries,
                                    bool viscous) {
  pair = layout.add(static_cast<Offset>(incidences * sizeof(int) * Sizes<kind>::nodes));
  element = layout.add(static_cast<Offset>(elements * sizeof(int)));
  force_q = layout.add(bytes_of(entries));
  force_v = layout.add(viscous ? bytes_of(entries) : 0);
}

template <ElementKind kind>
DeviceTangent<kind>::DeviceTangent(const SolidBody& body, const Slots& slots, const cuda::Stream& stream,
                                   int threads)
    : first_(body.first_coordinate),
      threads_(threads),
      blocks_(body.constants.beta > 0 ? BlockSet{Block::force_q, Block::force_v} : BlockSet{Block::force_q}),
      pairs_(body.mesh, slots),
      colours_(body.mesh, slots),
      entries_(9 * pairs_.neighbour.size()),
      places_(body.mesh.elements.size(), colours_.element.size(), entries_, blocks_.has(Block::force_v)),
      device_(places_.layout.total()),
      host_(bytes_of(entries_) * (blocks_.has(Block::force_v) ? 2 : 1)) {
  const std::vector<int> of_elements = pairs_.of_elements(body.mesh, threads);
  stream.to_device(device_.at<int>(places_.pair), of_elements.data(),
                   static_cast<Offset>(of_elements.size() * sizeof(int)));
  stream.to_device(device_.at<int>(places_.element), colours_.element.data(),
                   static_cast<Offset>(colours_.element.size() * sizeof(int)));
  stream.synchronize();  // what was borrowed may go
}

template <ElementKind kind>
void DeviceTangent<kind>::begin(const DeviceBody& body, const PointGradients<kind>* cell, BlockSet blocks,
                                const cuda::Stream& stream) {
  begun_ = blocks;
  const bool viscous = blocks_.has(Block::force_v);
  const Offset bytes = bytes_of(entries_);
  const PairValues values{device_.at<int>(places_.pair), device_.at<double>(places_.force_q),
                          viscous ? device_.at<double>(places_.force_v) : nullptr};
  stream.clear(values.force_q, bytes);
  if (viscous) stream.clear(values.force_v, bytes);
  for (std::size_t c = 0; c + 1 < colours_.start.size(); ++c) {
    element_tangents<kind>
        <<<colours_.start[c + 1] - colours_.start[c], TangentThreads<kind>::count, 0, stream.get()>>>(
            body, cell, device_.at<int>(places_.element) + colours_.start[c], values);
    cuda::check_launch("element_tangents");
  }
  double* own = host_.at<double>(0);
  if (blocks.has(Block::force_q)) stream.to_host(own, values.force_q, bytes);
  force_q_copied_.record(stream);
  if (blocks.has(Block::force_v)) stream.to_host(own + entries_, values.force_v, bytes);
}

template <ElementKind kind>
void DeviceTangent<kind>::add_to(Tangent& tangent, const TangentPattern& pattern,
                                 const cuda::Stream& stream) const {
  const double* own = host_.at<double>(0);
  force_q_copied_.synchronize();
  if (begun_.has(Block::force_q)) add(own, pattern[Block::force_q], tangent[Block::force_q]);
  stream.synchronize();
  if (begun_.has(Block::force_v)) add(own + entries_, pattern[Block::force_v], tangent[Block::force_v]);
}

/// Rows of the system may have more entries than those of the body.
template <ElementKind kind>
void DeviceTangent<kind>::add(const double* own, const Pattern& pattern, std::vector<double>& values) const {
  const int nodes = static_cast<int>(pairs_.start.size()) - 1;
#pragma omp parallel for num_threads(threads_) schedule(static)
  for (int i = 0; i < nodes; ++i)
    for (int k = 0; k < 3; ++k) {
      int entry = pattern.row_start[first_ + 3 * i + k];
      for (int pair = pairs_.start[i]; pair < pairs_.start[i + 1]; ++pair, entry += 3) {
        while (pattern.column[entry] != first_ + 3 * pairs_.neighbour[pair]) ++entry;
        const double* from = own + 9 * static_cast<std::int64_t>(pair) + 3 * k;
        for (int c = 0; c < 3; ++c) values[entry + c] += from[c];
      }
    }
}

}  // namespace mfs::dae
