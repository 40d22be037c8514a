// The derivatives of a body's forces on the device. A block of threads evaluates a few elements by the source
// of the host (solid_tangent.hpp): lanes make what belongs to the points of all of them, then, for one
// element after the other, each thread has one column of the element's matrices and some of their rows.
// Elements of one colour share no node, and colours follow one another, so nothing is atomic and each entry
// gets its terms in one order. Values are kept by pairs of coupled nodes, 3 x 3 for each. They stay on the
// device: the sum of all three derivatives is added to Newton's matrix there (RemoteTangent).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <mfs/error.hpp>

#include "dae/fem/cuda/device_body.hpp"
#include "dae/fem/cuda/device_matrix.hpp"
#include "dae/fem/device_force.hpp"
#include "dae/fem/solid_tangent.hpp"
#include "kernels/cuda/runtime/device.hpp"
#include "ordering/raw_vector.hpp"

namespace mfs::dae {

/// Who does what in the block of threads of one element: columns side by side, padded to whole warps, and
/// `rows` rows of each for one thread.
template <ElementKind kind>
struct TangentThreads {
  static constexpr int unknowns = Sizes<kind>::unknowns;
  static constexpr int columns = (unknowns + 31) / 32 * 32;
  static constexpr int rows = kind == ElementKind::hex8 ? 12 : 15;  ///< few enough for the registers
  static constexpr int count = columns * (unknowns / rows);
  /// The most elements of a block, one after the other; their points are evaluated at once.
  static constexpr int elements = kind == ElementKind::hex20 ? 1 : 4;
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
  put(p, from.reference.gradient, to.reference.gradient);
  put(p, from.reference.weight, to.reference.weight);
  put(p, r.elastic.f, all.elastic.f);
  put(p, r.rate.f, all.rate.f);
  put(p, r.stress.value, all.stress.value);
  to.stiffness.same = from.stiffness.same;
  if (from.stiffness.same) return;
  if (p == 0) to.factors = from.factors;
  for (int i = 0; i < 36; ++i) to.stiffness.value[p][i] = from.stiffness.value[0][i];
}

/// Adds grad N_i . S grad N_j, of each direction by itself.
template <ElementKind kind>
__device__ void add_initial_stress(const TangentState<kind>& s, double* force_q) {
  using Threads = TangentThreads<kind>;
  const int node = Threads::column() / 3, direction = Threads::column() % 3, first = Threads::first_row() / 3;
  for (int p = 0; p < Sizes<kind>::points; ++p) {
    double stressed[3];
    for (int a = 0; a < 3; ++a) stressed[a] = stressed_gradient<kind>(s, p, a, node);
#pragma unroll
    for (int i = 0; i < Threads::rows / 3; ++i) {
      double sum = 0;
      for (int a = 0; a < 3; ++a) sum += s.reference.gradient[a][first + i][p] * stressed[a];
      for (int k = 0; k < 3; ++k) force_q[3 * i + k] += k == direction ? sum : 0.0;
    }
  }
}

/// Where the values of all pairs of nodes are: 9 of each, row by row; of dF/da one, the mass.
struct PairValues {
  const int* pair;            ///< of each element: nodes x nodes numbers
  double *force_q, *force_v;  ///< force_v, without what is in proportion to the mass: null without viscosity
  const double* mass;
  double alpha;  ///< dF/dv is alpha M and force_v

  /// factor (dF/da, dF/dv, dF/dq) of entry `place`, row 0 ... 2 and column 0 ... 2 of its pair's.
  __device__ void terms(std::int64_t place, const double (&factor)[3], double (&term)[3]) const {
    const double m = place % 9 % 4 == 0 ? mass[place / 9] : 0.0;
    term[0] = factor[0] * m;
    term[1] = factor[1] * (alpha * m + (force_v != nullptr ? force_v[place] : 0.0));
    term[2] = factor[2] * force_q[place];
  }
};

/// Writes the state of element e, whose points this thread's lane and its neighbours have.
template <ElementKind kind>
__device__ void prepare_element(const SolidConstants& constants, const DeviceBody& body,
                                const DeviceUndeformed<kind>& undeformed, int e, TangentState<kind>& state) {
  using Lanes = PointLanes<kind>;
  const int* nodes = body.connectivity + e * Sizes<kind>::nodes;
  TangentState<kind, Lanes> own;
  PointGradients<kind, Lanes> cell;
  PointMaps<kind, Lanes> map;
  double q[Sizes<kind>::unknowns], v[Sizes<kind>::unknowns];
  load_cell<kind>(*undeformed.cell, cell);
  undeformed.load(body, e, map);
  gather<kind>(nodes, body.q, q);
  if (constants.beta > 0) gather<kind>(nodes, body.v, v);
  prepare_tangent<kind>(constants, cell, map, undeformed.modes[e], q, v, own);
  if (Lanes::lane() < Sizes<kind>::points) put_point<kind>(Lanes::lane(), own, state);
}

template <ElementKind kind>
__device__ void add_tangent(const int* pairs, const MultipliedRows<kind>& rows, const PairValues& values) {
  using Threads = TangentThreads<kind>;
  if (Threads::place() >= Threads::unknowns) return;
  const int j = Threads::column() / 3, direction = Threads::column() % 3, first = Threads::first_row() / 3;
#pragma unroll
  for (int i = 0; i < Threads::rows / 3; ++i) {
    const std::int64_t place =
        9 * static_cast<std::int64_t>(pairs[(first + i) * Sizes<kind>::nodes + j]) + direction;
    for (int k = 0; k < 3; ++k) {
      values.force_q[place + 3 * k] += rows.force_q[3 * i + k];
      if (values.force_v != nullptr) values.force_v[place + 3 * k] += rows.force_v[3 * i + k];
    }
  }
}

template <ElementKind kind, MaterialLaw law>
__global__ void __launch_bounds__(TangentThreads<kind>::count)
    element_tangents(DeviceBody body, DeviceUndeformed<kind> undeformed, const int* elements, int count,
                     int of_block, PairValues values) {
  using Threads = TangentThreads<kind>;
  constexpr int nodes = Sizes<kind>::nodes;
  __shared__ TangentState<kind> state[Threads::elements];
  __shared__ typename MultipliedRows<kind>::Shared left;
  SolidConstants constants = body.constants;
  constants.law = law;
  const int first = static_cast<int>(blockIdx.x) * of_block;
  const int here = min(of_block, count - first);

  const int prepared = static_cast<int>(threadIdx.x) / PointLanes<kind>::width;
  if (prepared < here)
    prepare_element<kind>(constants, body, undeformed, elements[first + prepared], state[prepared]);
  __syncthreads();

  for (int k = 0; k < here; ++k) {
    const int e = elements[first + k];
    MultipliedRows<kind> rows(left);
    tangent_rows<kind, ThreadColumn<kind>>(constants, undeformed.modes[e], state[k], rows);
    add_initial_stress<kind>(state[k], rows.force_q);
    add_tangent<kind>(values.pair + static_cast<std::int64_t>(e) * nodes * nodes, rows, values);
  }
}

struct Factors {
  double of[3];  ///< dF/da, dF/dv, dF/dq
};

/// diagonal[3 i + k] of node i, whose pair with itself is own[i]: those of dF/da, then dF/dv, then dF/dq.
static __global__ void diagonal_entries(int nodes, const int* own, PairValues values, double* diagonal) {
  const int c = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (c >= 3 * nodes) return;
  const double each[3] = {1.0, 1.0, 1.0};
  double term[3] = {};
  if (own[c / 3] >= 0) values.terms(9 * static_cast<std::int64_t>(own[c / 3]) + 4 * (c % 3), each, term);
  for (int k = 0; k < 3; ++k) diagonal[3 * nodes * k + c] = term[k];
}

/// Adds each entry to its places in `matrix`: those of dF/da, then dF/dv, then dF/dq, `entries` of each.
static __global__ void add_entries(std::int64_t entries, const int* target, PairValues values, Factors factor,
                                   double* matrix) {
  const std::int64_t k = static_cast<std::int64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (k >= entries) return;
  double term[3];
  values.terms(k, factor.of, term);
  const int by_a = target[k], by_v = target[entries + k], by_q = target[2 * entries + k];
  // No other thread has any of these places.
  double at_a = term[0], at_v = term[1];
  if (by_v == by_a) at_a += at_v;
  if (by_q == by_a)
    at_a += term[2];
  else if (by_q == by_v)
    at_v += term[2];
  else
    matrix[by_q] += term[2];
  if (by_v != by_a) matrix[by_v] += at_v;
  matrix[by_a] += at_a;
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
  std::size_t count() const { return neighbour.size(); }
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
  /// Of each node with itself; -1: it has no element.
  std::vector<int> of_nodes() const {
    std::vector<int> own(start.size() - 1);
    for (std::size_t i = 0; i < own.size(); ++i)
      own[i] = start[i] == start[i + 1] ? -1 : pair(static_cast<int>(i), static_cast<int>(i));
    return own;
  }
  /// Where the rows of node i's coordinates begin among the entries of all, when rows follow one another.
  int first_entry(int i) const {
    return 9 * start[i];
  }
  /// Entries of one of these rows.
  int row_length(int i) const {
    return 3 * (start[i + 1] - start[i]);
  }
  /// Calls visit(entry in the order of rows, entry in the order of pairs) for all entries of node i's rows.
  template <class Visit>
  void for_each_entry(int i, const Visit& visit) const {
    for (int k = 0; k < 3; ++k) {
      int entry = first_entry(i) + k * row_length(i);
      for (int p = start[i]; p < start[i + 1]; ++p)
        for (int c = 0; c < 3; ++c) visit(entry++, 9 * static_cast<std::int64_t>(p) + 3 * k + c);
    }
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

/// Entries of the body's rows in a system of so many coordinates, of which `first` is node 0's first. Throws
/// InvalidInput where there are more than an int can count.
inline Pattern pattern_of(const NodePairs& pairs, int first, int coordinates) {
  if (pairs.count() > static_cast<std::size_t>(std::numeric_limits<int>::max() / 9))
    throw InvalidInput("groups", "the elements couple more pairs of coordinates than an int can count");
  const int nodes = static_cast<int>(pairs.start.size()) - 1;
  Pattern pattern{coordinates, coordinates, std::vector<int>(static_cast<std::size_t>(first) + 1), {}};
  pattern.column.resize(9 * pairs.count());
  for (int i = 0; i < nodes; ++i) {
    for (int k = 1; k <= 3; ++k) pattern.row_start.push_back(pairs.first_entry(i) + k * pairs.row_length(i));
    pairs.for_each_entry(i, [&](int entry, std::int64_t of_pair) {
      pattern.column[static_cast<std::size_t>(entry)] =
          first + 3 * pairs.neighbour[static_cast<std::size_t>(of_pair / 9)] + static_cast<int>(of_pair % 3);
    });
  }
  pattern.row_start.resize(static_cast<std::size_t>(coordinates) + 1, pattern.row_start.back());
  return pattern;
}

/// The masses of all pairs.
inline std::vector<double> pair_masses(const SolidBody& body, const std::vector<int>& of_elements,
                                       std::size_t pairs) {
  const int nodes = nodes_per_element(body.mesh.kind);
  const auto entries = static_cast<std::size_t>(body.inertia.entries(nodes));
  std::vector<double> masses(pairs);
  const int* pair = of_elements.data();
  for (std::size_t e = 0; e < static_cast<std::size_t>(body.mesh.element_count()); ++e)
    for (int i = 0; i < nodes; ++i)
      for (int j = 0; j < nodes; ++j)
        masses[static_cast<std::size_t>(*pair++)] += body.inertia.mass(&body.mass[e * entries], i, j);
  return masses;
}

/// The derivatives of one body's forces.
template <ElementKind kind>
class DeviceTangent {
 public:
  /// In a system of so many coordinates.
  DeviceTangent(const SolidBody& body, const Slots& slots, const cuda::Stream& stream, int coordinates,
                int threads);

  // As in RemoteTangent.
  const Pattern& pattern() const { return pattern_; }
  void place(const std::array<const int*, 3>& target, RemoteMatrix& matrix, const cuda::Stream& stream);
  void begin(const DeviceBody& body, const DeviceUndeformed<kind>& undeformed,
             const cuda::Stream& stream) const;
  void add_diagonals(const ByAVQ& factor, DiagonalsByAVQ& diagonals, const cuda::Stream& stream) const;
  void begin_sum(const ByAVQ& factor, const cuda::Stream& stream) const;

 private:
  struct Places {
    ArenaLayout layout;
    Offset pair, own_pair, element, mass, force_q, force_v, diagonals;
    Places(const SolidBody& body, std::size_t pairs);
  };
  PairValues values() const {
    return {device_.at<int>(places_.pair), device_.at<double>(places_.force_q),
            viscous_ ? device_.at<double>(places_.force_v) : nullptr, device_.at<double>(places_.mass),
            alpha_};
  }
  static int blocks_for(std::int64_t threads) {
    return static_cast<int>((threads + kThreads - 1) / kThreads);
  }
  static Factors factors(const ByAVQ& factor) { return {{factor[0], factor[1], factor[2]}}; }

  static constexpr int kThreads = 256;
  /// As many blocks as a multiprocessor can run.
  static constexpr int kBlocksEach = 4;
  int elements_of_block(int count) const;
  const int multiprocessors_ = cuda::multiprocessors();
  const int first_, threads_, nodes_;
  const bool viscous_;
  const double alpha_;
  const NodePairs pairs_;
  const ElementColours colours_;
  const Pattern pattern_;
  const Places places_;
  const cuda::DeviceArena device_;
  const cuda::PinnedArena host_;  // diagonals
  DeviceMatrix* matrix_ = nullptr;
  std::optional<cuda::DeviceArena> target_;  // entries of the matrix, as add_entries takes them
};

template <ElementKind kind>
DeviceTangent<kind>::Places::Places(const SolidBody& body, std::size_t pairs) {
  const std::size_t incidences = body.mesh.elements.size(), nodes = body.mesh.nodes.size();
  const auto ints = [&](std::size_t count) { return layout.add(static_cast<Offset>(count * sizeof(int))); };
  pair = ints(incidences * Sizes<kind>::nodes);
  own_pair = ints(nodes);
  element = ints(static_cast<std::size_t>(body.mesh.element_count()));
  mass = layout.add(bytes_of(pairs));
  force_q = layout.add(bytes_of(9 * pairs));
  force_v = layout.add(body.constants.beta > 0 ? bytes_of(9 * pairs) : 0);
  diagonals = layout.add(bytes_of(9 * nodes));
}

template <ElementKind kind>
DeviceTangent<kind>::DeviceTangent(const SolidBody& body, const Slots& slots, const cuda::Stream& stream,
                                   int coordinates, int threads)
    : first_(body.first_coordinate),
      threads_(threads),
      nodes_(static_cast<int>(body.mesh.nodes.size())),
      viscous_(body.constants.beta > 0),
      alpha_(body.inertia.alpha),
      pairs_(body.mesh, slots),
      colours_(body.mesh, slots),
      pattern_(pattern_of(pairs_, first_, coordinates)),
      places_(body, pairs_.count()),
      device_(places_.layout.total()),
      host_(bytes_of(9 * body.mesh.nodes.size())) {
  const std::vector<int> of_elements = pairs_.of_elements(body.mesh, threads), of_nodes = pairs_.of_nodes();
  const std::vector<double> masses = pair_masses(body, of_elements, pairs_.count());
  const auto put = [&](Offset place, const auto& from) {
    stream.to_device(device_.at<char>(place), from.data(),
                     static_cast<Offset>(from.size() * sizeof(from[0])));
  };
  put(places_.pair, of_elements);
  put(places_.own_pair, of_nodes);
  put(places_.element, colours_.element);
  put(places_.mass, masses);
  stream.synchronize();  // what was borrowed may go
}

template <ElementKind kind>
void DeviceTangent<kind>::place(const std::array<const int*, 3>& target, RemoteMatrix& matrix,
                                const cuda::Stream& stream) {
  const std::size_t entries = pattern_.entries();
  stream.drain();  // what is added to another matrix
  target_.reset();
  target_.emplace(static_cast<Offset>(3 * entries * sizeof(int)));
  matrix_ = &dynamic_cast<DeviceMatrix&>(matrix);
  RawVector<int> by_pair(entries);
  for (std::size_t b = 0; b < 3; ++b) {
#pragma omp parallel for num_threads(threads_) schedule(static)
    for (int i = 0; i < nodes_; ++i)
      pairs_.for_each_entry(i, [&](int entry, std::int64_t of_pair) {
        by_pair[static_cast<std::size_t>(of_pair)] = target[b][entry];
      });
    stream.to_device(target_->at<int>(0) + b * entries, by_pair.data(),
                     static_cast<Offset>(entries * sizeof(int)));
    stream.synchronize();
  }
}

/// Of `count`: so many that the rounds of blocks take the least time. A block takes one element after the
/// other, after the points of all together, which take about as long as an element.
template <ElementKind kind>
int DeviceTangent<kind>::elements_of_block(int count) const {
  const int at_once = kBlocksEach * multiprocessors_;
  const auto time = [&](int elements) {
    const int blocks = (count + elements - 1) / elements;
    return (blocks + at_once - 1) / at_once * (elements + 1);
  };
  int best = 1;
  for (int elements = 2; elements <= TangentThreads<kind>::elements; ++elements)
    if (time(elements) < time(best)) best = elements;
  return best;
}

template <ElementKind kind>
void DeviceTangent<kind>::begin(const DeviceBody& body, const DeviceUndeformed<kind>& undeformed,
                                const cuda::Stream& stream) const {
  using Threads = TangentThreads<kind>;
  const auto kernel = body.constants.law == MaterialLaw::st_venant_kirchhoff
                          ? element_tangents<kind, MaterialLaw::st_venant_kirchhoff>
                          : element_tangents<kind, MaterialLaw::neo_hookean>;
  const PairValues to = values();
  stream.clear(to.force_q, bytes_of(pattern_.entries()));
  if (viscous_) stream.clear(to.force_v, bytes_of(pattern_.entries()));
  for (std::size_t c = 0; c + 1 < colours_.start.size(); ++c) {
    const int first = colours_.start[c], count = colours_.start[c + 1] - first;
    const int of_block = elements_of_block(count);
    kernel<<<(count + of_block - 1) / of_block, Threads::count, 0, stream.get()>>>(
        body, undeformed, device_.at<int>(places_.element) + first, count, of_block, to);
    cuda::check_launch("element_tangents");
  }
  double* const diagonals = device_.at<double>(places_.diagonals);
  diagonal_entries<<<blocks_for(3 * nodes_), kThreads, 0, stream.get()>>>(
      nodes_, device_.at<int>(places_.own_pair), to, diagonals);
  cuda::check_launch("diagonal_entries");
  stream.to_host(host_.at<double>(0), diagonals, host_.bytes());
}

template <ElementKind kind>
void DeviceTangent<kind>::add_diagonals(const ByAVQ& factor, DiagonalsByAVQ& diagonals,
                                        const cuda::Stream& stream) const {
  stream.synchronize();
  const std::int64_t count = 3 * static_cast<std::int64_t>(nodes_);
  const double* const own = host_.at<double>(0);
#pragma omp parallel for num_threads(threads_)
  for (std::int64_t c = 0; c < count; ++c)
    for (int b = 0; b < 3; ++b)
      diagonals[b][static_cast<std::size_t>(first_ + c)] += factor[b] * own[count * b + c];
}

template <ElementKind kind>
void DeviceTangent<kind>::begin_sum(const ByAVQ& factor, const cuda::Stream& stream) const {
  const auto entries = static_cast<std::int64_t>(pattern_.entries());
  matrix_->add(stream, [&](double* matrix) {
    add_entries<<<blocks_for(entries), kThreads, 0, stream.get()>>>(entries, target_->at<int>(0), values(),
                                                                    factors(factor), matrix);
    cuda::check_launch("add_entries");
  });
}

}  // namespace mfs::dae
