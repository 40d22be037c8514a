#include "solver/backend.hpp"

#include <algorithm>
#include <complex>
#include <limits>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "kernels/cuda/cuda_factors.hpp"
#include "kernels/dense/blas.hpp"
#include "kernels/panels/panel_factors.hpp"
#include "kernels/portable/portable_factors.hpp"
#include "kernels/runtime/scalars.hpp"
#include "solver/memory_limit.hpp"
#include "solver/option_checks.hpp"

namespace mfs {

namespace {

void refuse_memory_limit(const Options& options) {
  if (options.memory_limit > 0)
    throw InvalidInput("memory_limit", std::string("backend ") + backend_name(options.backend) +
                                           " obeys none: its factors need all memory of their plan");
}

void refuse_out_of_core(const Options& options) {
  if (!options.out_of_core_dir.empty())
    throw InvalidInput("out_of_core_dir", std::string("factors of backend ") + backend_name(options.backend) +
                                              " do not go to files");
}

}  // namespace

std::size_t BackendRules::available_memory() const {
  return available_host_memory();
}

template <class Scalar>
std::future<void> BackendFor<Scalar>::load_beside(bool, const Pattern&) const {
  return {};
}

namespace {

// Rates: of one core, of eight cores, and of an H200. A solve takes for an entry of the factors the time that
// a factorization takes for 103 to 115 operations on an H200, and for about 40 on a host with BLAS kernels
// that suit its processor (docs/experiments).
constexpr double kHostEntry = 40;

/// How the factors of a plan are made on the host.
template <class Scalar>
struct HostPlan {
  HostSpace space;
  bool single_precision;
  std::shared_ptr<const SymbolicPlan> plan;
  std::shared_ptr<const Pattern> pattern;
  int threads;
  /// For small fronts, beside them (kernels/panels/panel_factors.hpp).
  std::shared_ptr<const PanelProgram> panels =
      make_panel_program(*plan, *pattern, space == HostSpace::serial ? 1 : threads);

  Offset scalar_bytes() const { return single_precision ? sizeof(Narrow<Scalar>) : sizeof(Scalar); }
  NumericBytes bytes(Vertex columns) const {
    NumericBytes bytes = numeric_bytes(*plan, scalar_bytes(), sizeof(Scalar), columns);
    if (panels) bytes.other += panel_bytes(*plan, *panels, scalar_bytes());
    return bytes;
  }
  std::unique_ptr<Factorization<Scalar>> make(const OutOfCore* outside, Vertex columns) const {
    auto factors =
        make_host_factors<Scalar>(space, single_precision, plan, pattern, threads, outside, columns);
    if (panels && !outside)
      factors = make_panel_factors<Scalar>(single_precision, std::move(factors), plan, pattern, panels);
    return make_factorization<Scalar>(space, std::move(factors), plan, pattern);
  }
  Planned<Factorization<Scalar>> planned(const NumericBytes& bytes, const Movement& movement,
                                         std::function<std::unique_ptr<Factorization<Scalar>>()> made) const {
    return {bytes, plan->flops, movement, std::move(made), {}, space == HostSpace::serial};
  }
};

/// Where one block has most of the unknowns, threads share its solve better as a part of one tree
/// (plan/subtrees.hpp).
PlanNeeds block_needs(int threads) {
  PlanNeeds needs = host_needs(threads);
  needs.largest_block = threads == 1 ? 1 : 0.5;
  return needs;
}

Offset free_host_bytes() {
  return static_cast<Offset>(
      std::min<std::size_t>(available_host_memory(), std::numeric_limits<Offset>::max() / 2));
}

/// For segments that are made for what is free: other things need some as well.
Offset most_of(Offset bytes) {
  return bytes - bytes / 8;
}

[[noreturn]] void refuse_in_memory(Offset needed, Offset available) {
  OutOfMemory error(MemorySpace::host, static_cast<std::size_t>(needed), static_cast<std::size_t>(available));
  error.append("; with out_of_core_dir, factors that do not fit would go to a file");
  throw error;
}

template <class Scalar>
Planned<Factorization<Scalar>> plan_out_of_core(const HostPlan<Scalar>& host, const MemoryRoom& room,
                                                Offset available) {
  const auto ladder = [n = host.plan->n](Vertex columns) { return ladder_bytes(n, sizeof(Scalar), columns); };
  auto outside = std::make_shared<const OutOfCore>(mfs::plan_out_of_core(
      *host.plan, host.scalar_bytes(), sizeof(Scalar), ladder, room.out_of_core_dir, available));
  return host.planned(outside->bytes, outside->movement, [=] {
    const Offset left = free_host_bytes();
    if (outside->bytes.total() > left) return plan_out_of_core(host, room, most_of(left)).make();
    return host.make(outside.get(), outside->columns);
  });
}

template <class Scalar>
Planned<Factorization<Scalar>> plan_on_host(HostPlan<Scalar> host, const MemoryRoom& room) {
  const bool has_folder = !room.out_of_core_dir.empty();
  // With a folder, solutions are the same for any limit, and some leave no room for panels.
  if (has_folder || (room.limit > 0 && host.bytes(1).total() > room.limit)) host.panels.reset();
  const NumericBytes bytes = host.bytes(1);
  if (has_folder) {
    const Offset free = free_host_bytes() + room.held;
    if (bytes.total() > (room.limit > 0 ? room.limit : free))
      return plan_out_of_core(host, room, room.limit > 0 ? room.limit : most_of(free));
  } else if (room.limit > 0 && bytes.total() > room.limit) {
    refuse_in_memory(bytes.total(), room.limit);
  }
  Vertex columns = kSolveColumns;
  while (room.limit > 0 && columns > 1 && host.bytes(columns).total() > room.limit) columns /= 4;
  return host.planned(bytes, {}, [=] {
    const Offset available = free_host_bytes();
    if (bytes.total() <= available) return host.make(nullptr, columns);
    if (has_folder) return plan_out_of_core(host, room, most_of(available)).make();
    refuse_in_memory(bytes.total(), available);
  });
}

template <class Scalar>
class SerialBackend final : public BackendFor<Scalar> {
 public:
  BackendInfo info() const override { return {MemorySpace::host, 8e10 / 3, kHostEntry}; }
  bool one_thread() const override { return true; }
  PlanNeeds plan_needs(int threads) const override { return block_needs(threads); }
  Planned<Factorization<Scalar>> plan(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                      std::shared_ptr<const Pattern> pattern, int threads,
                                      const MemoryRoom& room) const override {
    return plan_on_host<Scalar>(
        {HostSpace::serial, single_precision, std::move(plan), std::move(pattern), threads}, room);
  }
};

template <class Scalar>
class OpenMPBackend final : public BackendFor<Scalar> {
 public:
  BackendInfo info() const override { return {MemorySpace::host, 2e11, kHostEntry}; }
  PlanNeeds plan_needs(int threads) const override { return block_needs(threads); }
  Planned<Factorization<Scalar>> plan(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                      std::shared_ptr<const Pattern> pattern, int threads,
                                      const MemoryRoom& room) const override {
    // With a BLAS that only one thread may call, others would do harm.
    const bool serial = threads == 1 || is_for_one_thread(*plan) || !blas::many_callers();
    return plan_on_host<Scalar>({serial ? HostSpace::serial : HostSpace::openmp, single_precision,
                                 std::move(plan), std::move(pattern), threads},
                                room);
  }
};

void check_block_size(const Options& options, const char* backend) {
  if (options.analysis.max_block_size != AnalysisOptions().max_block_size)
    throw InvalidInput("max_block_size", std::string("the blocks of backend ") + backend +
                                             " are its own: leave it at " +
                                             std::to_string(AnalysisOptions().max_block_size));
}

template <class Scalar>
class CudaBackend final : public BackendFor<Scalar> {
 public:
  BackendInfo info() const override { return {MemorySpace::device, 1e13, 100}; }
  bool present() const override { return cuda::device_found(); }
  void check(const Options& options) const override {
    refuse_out_of_core(options);
    check_block_size(options, "cuda");
    cuda::require_device();
  }
  Precision automatic_precision() const override { return mfs::automatic_precision(cuda::speed_of_single()); }
  bool uses_kokkos() const override { return true; }
  PlanNeeds plan_needs(int) const override { return kDeviceNeeds; }
  std::size_t available_memory() const override { return cuda::available_device_memory(); }
  std::future<void> load_beside(bool single_precision, const Pattern& pattern) const override {
    return cuda::load_library<Scalar>(single_precision, pattern);
  }
  Planned<Factorization<Scalar>> plan(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                      std::shared_ptr<const Pattern> pattern, int,
                                      const MemoryRoom& room) const override {
    const Planned<Factors<Scalar>> factors =
        cuda::plan_cuda_factors<Scalar>(single_precision, plan, pattern, {room.limit, room.held});
    return {factors.bytes,
            factors.flops,
            factors.movement,
            [=] {
              const auto outside = static_cast<std::size_t>(factors.bytes.outside);
              const std::size_t available = outside > 0 ? available_host_memory() : 0;
              if (outside > available) throw OutOfMemory(MemorySpace::host, outside, available);
              return make_factorization<Scalar>(HostSpace::openmp, factors.make(), plan, pattern);
            },
            factors.step_flops,
            false,
            factors.early};
  }
};

/// Kokkos' default space; its factors lie in the memory of the host or of a device.
template <class Scalar>
class PortableBackend final : public BackendFor<Scalar> {
 public:
  BackendInfo info() const override {
    return portable::on_host() ? BackendInfo{MemorySpace::host, 2e11, kHostEntry}
                               : BackendInfo{MemorySpace::device, 1e13, 100};
  }
  bool present() const override { return portable::on_host() || cuda::device_found(); }
  void check(const Options& options) const override {
    refuse_memory_limit(options);
    refuse_out_of_core(options);
    check_block_size(options, "kokkos");
    if (!portable::on_host()) cuda::require_device();
  }
  bool one_thread() const override { return !portable::has_threads(); }
  bool uses_kokkos() const override { return true; }
  Precision automatic_precision() const override {
    return portable::on_host() ? Precision::full : mfs::automatic_precision(cuda::speed_of_single());
  }
  PlanNeeds plan_needs(int threads) const override {
    return portable::on_host() ? host_needs(threads) : kDeviceNeeds;
  }
  std::size_t available_memory() const override {
    return portable::on_host() ? available_host_memory() : portable::free_memory();
  }
  Planned<Factorization<Scalar>> plan(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                      std::shared_ptr<const Pattern> pattern, int threads,
                                      const MemoryRoom&) const override {
    const Planned<Factors<Scalar>> factors =
        portable::plan_portable_factors<Scalar>(single_precision, plan, pattern, threads);
    NumericBytes bytes = factors.bytes;
    if (portable::on_host()) bytes.solve += ladder_bytes(plan->n, sizeof(Scalar), 1);
    return {bytes,
            factors.flops,
            {},
            [=, backend = this] {
              const auto needed = static_cast<std::size_t>(bytes.total());
              const std::size_t available = backend->available_memory();
              if (needed > available) throw OutOfMemory(backend->info().memory, needed, available);
              return make_factorization<Scalar>(HostSpace::openmp, factors.make(), plan, pattern);
            },
            factors.step_flops};
  }
};

}  // namespace

template <class Scalar>
const BackendFor<Scalar>& backend_for(Backend backend) {
  static const SerialBackend<Scalar> serial;
  static const OpenMPBackend<Scalar> openmp;
  static const CudaBackend<Scalar> cuda;
  static const PortableBackend<Scalar> kokkos;
  switch (backend) {
    case Backend::serial:
      return serial;
    case Backend::openmp:
      return openmp;
    case Backend::cuda:
      return cuda;
    case Backend::kokkos:
      return kokkos;
  }
  throw InvalidInput("backend", "no such backend");
}

const BackendRules& rules_of(Backend backend) {
  return backend_for<double>(backend);
}

template const BackendFor<float>& backend_for<float>(Backend);
template const BackendFor<double>& backend_for<double>(Backend);
template const BackendFor<std::complex<float>>& backend_for<std::complex<float>>(Backend);
template const BackendFor<std::complex<double>>& backend_for<std::complex<double>>(Backend);

}  // namespace mfs
