// Where the time of a factorization by backend kokkos goes, in Kokkos' default space: for each FAMILY:SIZE a
// JSON line per kernel, each waited for, and one for what lies between them (calls of a library, and
// launches).
//
//   perf_kernels elas3d:40 kkt:24
#include <fmt/format.h>

#include <map>
#include <string>

#include "cases/families.hpp"
#include "kernels/portable/stages.hpp"
#include "kernels/runtime/engine.hpp"
#include "ordering/stopwatch.hpp"
#include "solver/analysis.hpp"

namespace {

using Exec = Kokkos::DefaultExecutionSpace;
using Stages = mfs::portable::PortableStages<Exec, double, double>;

struct Time {
  double seconds = 0;
  int launches = 0;
};
std::map<std::string, Time> times;
std::string running;
const Stages* stages = nullptr;
mfs::Stopwatch watch;

void take(const std::string& name) {
  stages->queue().wait();
  Time& time = times[name];
  time.seconds += watch.seconds();
  ++time.launches;
  watch = mfs::Stopwatch();
}
void begin_kernel(const char* name, std::uint32_t, std::uint64_t*) {
  take("between");
  running = name;
}
void end_kernel(std::uint64_t) {
  take(running);
}

void measure(const std::string& name) {
  const auto colon = name.find(':');
  const mfs::cases::FamilyMatrix a =
      mfs::cases::make_family(name.substr(0, colon), std::stoll(name.substr(colon + 1)));
  const mfs::CsrView<double> view{a.n, a.n, a.offsets.data(), a.column_indices.data(), a.values.data()};
  const int threads = mfs::available_threads();
  const mfs::PlanNeeds needs = mfs::kOnHost<Exec> ? mfs::host_needs(threads) : mfs::kDeviceNeeds;
  const mfs::Analysis analysis =
      mfs::analyze_matrix(view, mfs::AnalysisOptions(), needs, threads, [](const char*, double) {});
  const mfs::blas::SequentialScope sequential(threads);
  Stages made(*analysis.plan, *analysis.pattern,
              mfs::portable::make_lists(
                  *analysis.plan,
                  mfs::portable::sizes_for<Exec, double, mfs::portable::DenseOf<Exec, double>>(threads)));
  made.allocate();
  const auto send = [&](double* to, const double* from, mfs::Offset count) {
    made.queue().to_space(to, from, count * static_cast<mfs::Offset>(sizeof(double)));
    made.queue().wait();
  };
  const auto& at = made.store().fronts;
  send(at.matrix_values, a.values.data(), analysis.plan->nnz);
  send(at.row_scale, analysis.matched.row_scale.data(), analysis.plan->n);
  send(at.column_scale, analysis.matched.column_scale.data(), analysis.plan->n);
  constexpr double kTolerance = 1.5e-8;
  const auto factor = [&] {
    const mfs::Stopwatch whole;
    made.factor(kTolerance, [](mfs::Vertex) {});
    made.queue().wait();
    return whole.seconds();
  };
  factor();
  const double unwatched = factor();
  stages = &made;
  times.clear();
  Kokkos::Tools::Experimental::set_begin_parallel_for_callback(begin_kernel);
  Kokkos::Tools::Experimental::set_end_parallel_for_callback(end_kernel);
  watch = mfs::Stopwatch();
  factor();
  take("between");
  Kokkos::Tools::Experimental::set_begin_parallel_for_callback(nullptr);
  Kokkos::Tools::Experimental::set_end_parallel_for_callback(nullptr);
  fmt::print("{{\"case\": \"{}\", \"space\": \"{}\", \"kernel\": \"all\", \"ms\": {:.3f}}}\n", name,
             Exec::name(), 1e3 * unwatched);
  for (const auto& [kernel, time] : times) {
    fmt::print("{{\"case\": \"{}\", \"kernel\": \"{}\", \"ms\": {:.3f}, \"launches\": {}}}\n", name, kernel,
               1e3 * time.seconds, time.launches);
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    mfs::Engine::instance().run(mfs::available_threads(), [&] {
      mfs::Space<Exec>::start();
      measure(argv[i]);
    });
  }
}
