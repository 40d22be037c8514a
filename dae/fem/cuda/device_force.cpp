#include "dae/fem/device_force.hpp"

#include <algorithm>
#include <array>

#include "dae/fem/cuda/device_body.hpp"
#include "dae/fem/cuda/device_tangent.hpp"
#include "dae/vectors/cuda/cuda_queue.hpp"
#include "kernels/cuda/runtime/device.hpp"

namespace mfs::dae {

namespace {

constexpr int kBlock = 128;  // threads

/// The element of this thread's lane.
template <ElementKind kind>
__device__ int own_element() {
  constexpr int width = PointLanes<kind>::width;
  return static_cast<int>(blockIdx.x * (kBlock / width) + threadIdx.x / width);
}

template <ElementKind kind>
__global__ void __launch_bounds__(kBlock)
    undeformed_elements(DeviceBody body, const double* nodes, DeviceUndeformed<kind> undeformed) {
  const int e = own_element<kind>();
  if (e >= body.elements) return;
  PointGradients<kind, PointLanes<kind>> cell;
  Undeformed<kind, PointLanes<kind>> own;
  double reference[Sizes<kind>::unknowns];
  load_cell<kind>(*undeformed.cell, cell);
  gather<kind>(body.connectivity + e * Sizes<kind>::nodes, nodes, reference);
  undeform<kind>(body.constants, cell, reference, own);
  undeformed.store(body, e, own);
}

/// Blocks that fit on a multiprocessor. hex8: at three the compiler has 168 registers and spills 224 bytes of
/// a thread, at four 1300 (sm_90, CUDA 13).
template <ElementKind kind>
constexpr int kBlocksEach = kind == ElementKind::hex8 ? 3 : 1;

template <ElementKind kind, MaterialLaw law>
__global__ void __launch_bounds__(kBlock, kBlocksEach<kind>)
    element_forces(DeviceBody body, DeviceUndeformed<kind> undeformed) {
  using Lanes = PointLanes<kind>;
  constexpr int nodes = Sizes<kind>::nodes, nodes_of_lane = (nodes + Lanes::width - 1) / Lanes::width;
  const int e = own_element<kind>();
  if (e >= body.elements) return;
  const int* element = body.connectivity + e * nodes;
  SolidConstants constants = body.constants;
  constants.law = law;

  PointGradients<kind, Lanes> cell;
  PointMaps<kind, Lanes> map;
  double q[3 * nodes], v[3 * nodes], force[nodes_of_lane][3] = {};
  load_cell<kind>(*undeformed.cell, cell);
  undeformed.load(body, e, map);
  gather<kind>(element, body.q, q);
  if (constants.beta > 0) gather<kind>(element, body.v, v);
  add_force<kind>(constants, cell, map, undeformed.modes[e], q, v, [&](int node, int i, double sum) {
    force[nodes_of_lane == 1 ? 0 : node / Lanes::width][i] += sum;
  });

  const double* mass = body.mass + static_cast<std::int64_t>(e) * body.inertia.entries(nodes);
  double* out = body.element_force + static_cast<std::int64_t>(e) * 3 * nodes;
  const auto acceleration = [&](int j, int k) {
    const int c = 3 * element[j] + k;
    return body.inertia.acceleration(body.a[c], body.v[c], k);
  };
  for (int i = Lanes::lane(), own = 0; own < nodes_of_lane; i += Lanes::width, ++own)
    if (i < nodes) {
      body.inertia.add_row(i, nodes, mass, acceleration, force[own]);
      for (int k = 0; k < 3; ++k) out[3 * i + k] = force[own][k];
    }
}

__global__ void __launch_bounds__(kBlock) nodal_forces(DeviceBody body) {
  const int c = static_cast<int>(blockIdx.x * kBlock + threadIdx.x), node = c / 3, k = c % 3;
  if (node >= body.nodes) return;
  double sum = 0;
  for (int s = body.slot_start[node]; s < body.slot_start[node + 1]; ++s)
    sum += body.element_force[3 * static_cast<std::int64_t>(body.slot[s]) + k];
  body.force[c] = sum;
}

int blocks_for(std::int64_t threads) {
  return static_cast<int>((threads + kBlock - 1) / kBlock);
}

template <ElementKind kind>
class CudaForce final : public DeviceForce {
 public:
  CudaForce(const SolidBody& body, int coordinates, int threads);
  ~CudaForce() override { stream_.drain(); }
  void begin(const StateView& state) override;
  void add_to(std::vector<double>& force) override;
  void write(const Executor& executor, const StateView& state, double* force) override;
  const Pattern& pattern() const override { return tangent_.pattern(); }
  std::unique_ptr<RemoteMatrix> make_matrix(std::size_t entries, const std::vector<int>& own) override {
    return std::make_unique<DeviceMatrix>(entries, own);
  }
  void place(const std::array<const int*, 3>& target, RemoteMatrix& matrix) override {
    tangent_.place(target, matrix, stream_);
  }
  void begin_tangent(const StateView& state) override {
    send(state);
    tangent_.begin(body_, undeformed_, stream_);
  }
  void begin_tangent(const Executor& executor, const StateView& state) override {
    between(executor, [&] { tangent_.begin(body_in(state, nullptr), undeformed_, stream_); });
  }
  void add_diagonals(const ByAVQ& factor, DiagonalsByAVQ& diagonals) override {
    tangent_.add_diagonals(factor, diagonals, stream_);
  }
  void begin_sum(const ByAVQ& factor) override { tangent_.begin_sum(factor, stream_); }

 private:
  struct Places {
    ArenaLayout layout;
    Offset cell, map, modes, mass, connectivity, slot_start, slot, state, element_force, force;
    explicit Places(const SolidBody& body);
  };
  void send(const StateView& state);
  void launch(const DeviceBody& body) const;
  /// The body with a state and a place for its forces elsewhere on the device.
  DeviceBody body_in(const StateView& state, double* force) const;
  /// What `work` puts into the stream comes between what the executor marked last and what it begins from now
  /// on. So bodies do not wait for each other.
  template <class Work>
  void between(const Executor& executor, const Work& work);
  void make_undeformed(const Mesh& mesh);
  int blocks_for_lanes() const { return blocks_for(std::int64_t{body_.elements} * PointLanes<kind>::width); }

  const std::int64_t n_;  // coordinates of the body
  const int first_, threads_;
  const Places places_;
  const Slots slots_;
  cuda::Stream stream_;
  cuda::Event done_;
  const cuda::DeviceArena device_;
  const cuda::PinnedArena host_;  // q, v and a; force
  DeviceTangent<kind> tangent_;
  DeviceBody body_;
  DeviceUndeformed<kind> undeformed_;
};

template <ElementKind kind>
CudaForce<kind>::Places::Places(const SolidBody& body) {
  const std::size_t n = 3 * body.mesh.nodes.size(), incidences = body.mesh.elements.size();
  const auto elements = static_cast<std::size_t>(body.mesh.element_count());
  const auto ints = [](std::size_t count) { return static_cast<Offset>(count * sizeof(int)); };
  cell = layout.add(sizeof(PointGradients<kind>));
  map = layout.add(bytes_of(DeviceUndeformed<kind>::numbers * PointLanes<kind>::width * elements));
  modes = layout.add(static_cast<Offset>(sizeof(Modes<kind>) * elements));
  mass = layout.add(bytes_of(body.mass.size()));
  connectivity = layout.add(ints(incidences));
  slot_start = layout.add(ints(body.mesh.nodes.size() + 1));
  slot = layout.add(ints(incidences));
  state = layout.add(bytes_of(3 * n));
  element_force = layout.add(bytes_of(3 * incidences));
  force = layout.add(bytes_of(n));
}

template <ElementKind kind>
CudaForce<kind>::CudaForce(const SolidBody& body, int coordinates, int threads)
    : n_(static_cast<std::int64_t>(3 * body.mesh.nodes.size())),
      first_(body.first_coordinate),
      threads_(threads),
      places_(body),
      slots_(body.mesh),
      device_(places_.layout.total()),
      host_(bytes_of(static_cast<std::size_t>(4 * n_))),
      tangent_(body, slots_, stream_, coordinates, threads) {
  const auto put = [&](Offset place, const void* from, std::size_t bytes) {
    stream_.to_device(device_.at<char>(place), from, static_cast<Offset>(bytes));
  };
  const auto put_all = [&](Offset place, const auto& values) {
    put(place, values.data(), values.size() * sizeof(values[0]));
  };
  put(places_.cell, &cell_gradients<kind>(), sizeof(PointGradients<kind>));
  put_all(places_.mass, body.mass);
  put_all(places_.connectivity, body.mesh.elements);
  put_all(places_.slot_start, slots_.start);
  put_all(places_.slot, slots_.slot);
  stream_.synchronize();  // what was borrowed may go
  const double* state = device_.at<double>(places_.state);
  body_ = {body.mesh.element_count(),
           static_cast<int>(body.mesh.nodes.size()),
           body.constants,
           body.inertia,
           device_.at<double>(places_.mass),
           device_.at<int>(places_.connectivity),
           device_.at<int>(places_.slot_start),
           device_.at<int>(places_.slot),
           state,
           state + n_,
           state + 2 * n_,
           device_.at<double>(places_.element_force),
           device_.at<double>(places_.force)};
  undeformed_ = {device_.at<PointGradients<kind>>(places_.cell), device_.at<double>(places_.map),
                 device_.at<Modes<kind>>(places_.modes)};
  make_undeformed(body.mesh);
}

template <ElementKind kind>
void CudaForce<kind>::make_undeformed(const Mesh& mesh) {
  const cuda::DeviceArena nodes(bytes_of(3 * mesh.nodes.size()));
  stream_.to_device(nodes.at<char>(0), mesh.nodes.data(), nodes.bytes());
  undeformed_elements<kind>
      <<<blocks_for_lanes(), kBlock, 0, stream_.get()>>>(body_, nodes.at<double>(0), undeformed_);
  cuda::check_launch("undeformed_elements");
  stream_.synchronize();
}

template <ElementKind kind>
void CudaForce<kind>::send(const StateView& state) {
  stream_.drain();  // the copies of an evaluation that was not taken
  const double* const from[] = {state.q + first_, state.v + first_, state.a + first_};
  const Offset bytes = bytes_of(static_cast<std::size_t>(n_));
  for (int part = 0; part < 3; ++part) {  // each travels while the next one is copied
    const double* const values = from[part];
    double* const staged = host_.at<double>(part * bytes);
#pragma omp parallel for num_threads(threads_)
    for (std::int64_t i = 0; i < n_; ++i) staged[i] = values[i];
    stream_.to_device(device_.at<char>(places_.state + part * bytes), staged, bytes);
  }
}

template <ElementKind kind>
void CudaForce<kind>::launch(const DeviceBody& body) const {
  const auto kernel = body.constants.law == MaterialLaw::st_venant_kirchhoff
                          ? element_forces<kind, MaterialLaw::st_venant_kirchhoff>
                          : element_forces<kind, MaterialLaw::neo_hookean>;
  kernel<<<blocks_for_lanes(), kBlock, 0, stream_.get()>>>(body, undeformed_);
  cuda::check_launch("element_forces");
  nodal_forces<<<blocks_for(n_), kBlock, 0, stream_.get()>>>(body);
  cuda::check_launch("nodal_forces");
}

template <ElementKind kind>
void CudaForce<kind>::begin(const StateView& state) {
  send(state);
  launch(body_);
  stream_.to_host(host_.at<double>(0) + 3 * n_, body_.force, bytes_of(static_cast<std::size_t>(n_)));
}

template <ElementKind kind>
DeviceBody CudaForce<kind>::body_in(const StateView& state, double* force) const {
  DeviceBody body = body_;
  body.q = state.q + first_;
  body.v = state.v + first_;
  body.a = state.a + first_;
  body.force = force;
  return body;
}

template <ElementKind kind>
template <class Work>
void CudaForce<kind>::between(const Executor& executor, const Work& work) {
  const cuda::Stream& others = queue_of(executor).work;
  stream_.wait_for(queue_of(executor).marked);
  work();
  done_.record(stream_);
  others.wait_for(done_);
}

template <ElementKind kind>
void CudaForce<kind>::write(const Executor& executor, const StateView& state, double* force) {
  between(executor, [&] { launch(body_in(state, force + first_)); });
}

template <ElementKind kind>
void CudaForce<kind>::add_to(std::vector<double>& force) {
  stream_.synchronize();
  const double* own = host_.at<double>(0) + 3 * n_;
#pragma omp parallel for num_threads(threads_)
  for (std::int64_t i = 0; i < n_; ++i) force[static_cast<std::size_t>(first_ + i)] += own[i];
}

}  // namespace

std::unique_ptr<DeviceForce> make_device_force(const SolidBody& body, int coordinates, int threads) {
  int devices = 0;
  cuda::check(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  switch (body.mesh.kind) {
    case ElementKind::hex8:
      return std::make_unique<CudaForce<ElementKind::hex8>>(body, coordinates, threads);
    case ElementKind::hex20:
      return std::make_unique<CudaForce<ElementKind::hex20>>(body, coordinates, threads);
    case ElementKind::tet10:
      break;
  }
  return std::make_unique<CudaForce<ElementKind::tet10>>(body, coordinates, threads);
}

}  // namespace mfs::dae
