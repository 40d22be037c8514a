// libmfs with the program's Kokkos (MFS_KOKKOS=shared): its kernels are that Kokkos' kernels, and it asks for
// a Kokkos that runs.
#include <Kokkos_Core.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <mfs/mfs.hpp>

#include "expect.hpp"
#include "kernels/runtime/engine.hpp"
#include "test/kokkos_device.hpp"
#include "tiny_system.hpp"

namespace {

template <class Body>
std::string refusal_of(const Body& body) {
  try {
    body();
  } catch (const mfs::StateError& error) {
    return error.what();
  }
  return "";
}

std::atomic<int> kernels_of_mfs{0};
void count_kernel(const char* name, const std::uint32_t, std::uint64_t*) {
  if (std::strncmp(name, "mfs::", 5) == 0) ++kernels_of_mfs;
}

struct Stop : std::runtime_error {
  Stop() : std::runtime_error("stop") {}
};

// Of a chain that is too long for panels, which are no kernels of Kokkos.
void kernels_are_seen() {
  constexpr int n = 30'000;
  std::vector<int> offsets{0}, columns;
  std::vector<double> values;
  for (int i = 0; i < n; ++i) {
    for (int j = std::max(i - 1, 0); j <= std::min(i + 1, n - 1); ++j) {
      columns.push_back(j);
      values.push_back(i == j ? 3.0 : -1.0);
    }
    offsets.push_back(static_cast<int>(columns.size()));
  }
  Kokkos::Tools::Experimental::set_begin_parallel_for_callback(count_kernel);
  mfs::Solver solver;
  solver.factor({n, n, offsets.data(), columns.data(), values.data()});
  Kokkos::Tools::Experimental::set_begin_parallel_for_callback(nullptr);
  expect(kernels_of_mfs > 0, "the program's Kokkos sees the kernels of MFS");
}

// A progress callback that throws: its exception arrives, and the solver works afterwards.
void progress_throws() {
  mfs::Options options;
  bool stop = true;
  int calls = 0;
  options.progress = [&](const mfs::Progress&) {
    ++calls;
    if (stop) throw Stop();
  };
  const int offsets[] = {0, 1}, columns[] = {0};
  const double value = 2.0, b = 4.0;
  double x = 0.0;
  mfs::Solver solver(options);
  bool stopped = false;
  try {
    solver.factor({1, 1, offsets, columns, &value});
  } catch (const Stop&) {
    stopped = true;
  }
  expect(stopped, "what the callback throws arrives");
  stop = false;
  solver.factor({1, 1, offsets, columns, &value});
  solver.solve(&b, &x);
  expect(x == 2.0 && calls > 2, "a solver works after its callback threw");
}

// What is called meanwhile comes from another thread, as this one works, and what it throws when that is
// done.
void called_beside_the_work() {
  int calls = 0, done = 0;
  const auto caller = std::this_thread::get_id();
  bool same_thread = true, other_thread = true, thrown = false;
  const auto work = [&] {
    same_thread = same_thread && std::this_thread::get_id() == caller;
    std::this_thread::sleep_for(std::chrono::milliseconds(450));
    ++done;
  };
  mfs::Engine::instance().run(1, work, [&] {
    ++calls;
    other_thread = other_thread && std::this_thread::get_id() != caller;
  });
  expect(calls > 0 && other_thread && same_thread, "called beside the work");
  try {
    mfs::Engine::instance().run(1, work, [] { throw Stop(); });
  } catch (const Stop&) {
    thrown = true;
  }
  expect(thrown && done == 2, "what is called beside the work throws when it is done");
}

#ifdef MFS_CUDA
using DeviceVector = Kokkos::View<double*, Kokkos::CudaSpace>;

// diag(1, 2, ... n) / factor. Functions of their own, as nvcc wants them for lambdas.
void set_diagonal(const DeviceVector& diagonal, double factor) {
  Kokkos::parallel_for(
      "diagonal", diagonal.extent(0), KOKKOS_LAMBDA(int i) { diagonal(i) = (i + 1) / factor; });
}
double largest_difference(const DeviceVector& x, double value) {
  double largest = 0.0;
  Kokkos::parallel_reduce(
      "difference", x.extent(0),
      KOKKOS_LAMBDA(int i, double& most) { most = fmax(most, fabs(x(i) - value)); },
      Kokkos::Max<double>(largest));
  return largest;
}

// Views are used where they lie: between kernels of the program in its stream, nothing is waited for.
void views_where_they_lie() {
  constexpr int n = 1000;
  std::vector<int> offsets(n + 1), columns(n);
  std::vector<double> values(n, 1.0);
  std::iota(offsets.begin(), offsets.end(), 0);
  std::iota(columns.begin(), columns.end(), 0);
  mfs::Options options;
  options.backend = mfs::Backend::cuda;
  mfs::Solver solver(options);
  solver.factor({n, n, offsets.data(), columns.data(), values.data()});
  const DeviceVector diagonal("diagonal", n), b("b", n), x("x", n);
  for (const double factor : {2.0, 5.0}) {
    set_diagonal(diagonal, factor);
    set_diagonal(b, 1.0);
    solver.refactor_device(diagonal.data(), Kokkos::Cuda().cuda_stream());
    solver.solve_device(b.data(), x.data(), 1, 0, 0, Kokkos::Cuda().cuda_stream());
    expect(largest_difference(x, factor) < 1e-14 * factor, "views on the device");
  }
}
#endif

}  // namespace

int main() {
  if (!kokkos_can_start()) return 0;
  expect(refusal_of([] { TinySystem(); }).find("not running") != std::string::npos, "without Kokkos");
  Kokkos::initialize();
  {
    TinySystem system;
    expect(system.solve(), "MFS solves");
    kernels_are_seen();
    progress_throws();
    called_beside_the_work();
#ifdef MFS_CUDA
    views_where_they_lie();
#endif
#ifdef KOKKOS_ENABLE_OPENMP
    bool inside = false;
    Kokkos::parallel_for("inside", Kokkos::RangePolicy<Kokkos::OpenMP>(0, 1),
                         [&](int) { inside = !refusal_of([&] { system.solve(); }).empty(); });
    expect(inside || Kokkos::OpenMP().concurrency() == 1, "refused inside a kernel");
#endif
    bool elsewhere = false;
    std::thread([&] {
      elsewhere = refusal_of([&] { expect(system.solve(), "MFS solves in another thread"); }).empty();
    }).join();
#if defined(KOKKOS_ENABLE_OPENMP) && KOKKOS_VERSION < 40000
    expect(!elsewhere, "refused in another thread than that which started OpenMP");
#else
    expect(elsewhere, "taken from another thread");
#endif
    Kokkos::finalize();
    expect(!refusal_of([&] { system.solve(); }).empty(), "refused after Kokkos has ended");
  }
  return failures == 0 ? 0 : 1;
}
