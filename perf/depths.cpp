// Where the time of a factorization on the device goes: for each FAMILY:SIZE, a JSON line per depth and kind
// of kernel, from events around every launch (not from the recorded graph, whose launches cannot be told
// apart).
//
//   perf_depths elas3d:40 poisson2d:1000
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "cases/families.hpp"
#include "kernels/cuda/device_stages.hpp"
#include "kernels/cuda/runtime/device.hpp"
#include "kernels/runtime/engine.hpp"
#include "solver/analysis.hpp"

namespace {

using mfs::Vertex;
using mfs::cuda::Kernel;
using mfs::cuda::PivotSearch;

constexpr const char* kNames[] = {"largest",  "small", "assemble", "diagonal", "strips",
                                  "products", "roots", "exchange", "update",   "inverses"};
constexpr int kKinds = static_cast<int>(Kernel::end);

struct Launch {
  Kernel kernel;
  Vertex step;
  std::unique_ptr<mfs::cuda::Event> begin = std::make_unique<mfs::cuda::Event>();
};

void print_depths(const std::string& name, const mfs::SymbolicPlan& plan,
                  const std::vector<Launch>& launches) {
  std::vector<std::vector<double>> time(plan.num_depths + 1, std::vector<double>(kKinds, 0.0));
  std::vector<std::vector<int>> count(plan.num_depths + 1, std::vector<int>(kKinds, 0));
  for (std::size_t i = 0; i + 1 < launches.size(); ++i) {
    const int kind = static_cast<int>(launches[i].kernel);
    const double ms = launches[i + 1].begin->since(*launches[i].begin);
    for (const Vertex row : {launches[i].step, plan.num_depths}) {
      time[row][kind] += ms;
      ++count[row][kind];
    }
  }
  for (Vertex step = 0; step <= plan.num_depths; ++step) {
    double flops = 0, update = 0, total = 0, entries = 0;
    Vertex fronts = 0, most_pivots = 0;
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      if (step < plan.num_depths && (f < plan.depth_begin[step] || f >= plan.depth_begin[step + 1])) continue;
      flops += plan.front_flops[f];
      const double border = plan.border_rows(f), pivots = plan.pivots(f);
      if (pivots + border > mfs::cuda::kSmallRows<double>) update += 2 * pivots * border * border;
      // The least that must move: factors are written, a contribution block is written and read by the
      // parent.
      entries += pivots * (pivots + 2 * border) + 2 * border * border;
      most_pivots = std::max(most_pivots, plan.pivots(f));
      ++fronts;
    }
    std::string kinds;
    for (int kind = 0; kind < kKinds; ++kind) {
      total += time[step][kind];
      kinds += fmt::format(", \"{}_ms\": {:.4f}, \"{}_launches\": {}", kNames[kind], time[step][kind],
                           kNames[kind], count[step][kind]);
    }
    const std::string depth = step < plan.num_depths ? std::to_string(plan.num_depths - 1 - step) : "\"all\"";
    fmt::print(
        "{{\"case\": \"{}\", \"depth\": {}, \"fronts\": {}, \"gflop\": {:.4f}, \"update_gflop\": {:.4f}, "
        "\"gbyte\": {:.6f}, \"most_pivots\": {}, \"ms\": {:.4f}{}}}\n",
        name, depth, fronts, flops / 1e9, update / 1e9, entries * sizeof(double) / 1e9, most_pivots, total,
        kinds);
  }
}

void measure(const std::string& name) {
  const auto colon = name.find(':');
  const mfs::cases::FamilyMatrix a =
      mfs::cases::make_family(name.substr(0, colon), std::stoll(name.substr(colon + 1)));
  const mfs::CsrView<double> view{a.n, a.n, a.offsets.data(), a.column_indices.data(), a.values.data()};
  const mfs::Analysis analysis = mfs::analyze_matrix(view, mfs::AnalysisOptions(), mfs::kDeviceNeeds,
                                                     mfs::available_threads(), [](const char*, double) {});
  const mfs::cuda::Stream stream;
  mfs::cuda::DeviceStages<double, double> stages(*analysis.plan, *analysis.pattern, stream);
  const auto bytes = [&](mfs::Offset entries) { return entries * static_cast<mfs::Offset>(sizeof(double)); };
  stream.to_device(stages.matrix_values(), a.values.data(), bytes(analysis.plan->nnz));
  stream.to_device(stages.row_scale(), analysis.matched.row_scale.data(), bytes(analysis.plan->n));
  stream.to_device(stages.column_scale(), analysis.matched.column_scale.data(), bytes(analysis.plan->n));
  constexpr double kTolerance = 1.5e-8;
  stages.factor(kTolerance, PivotSearch::not_in_roots);
  stages.factor(kTolerance, PivotSearch::not_in_roots);
  stream.synchronize();
  std::vector<Launch> launches;
  stages.factor(kTolerance, PivotSearch::not_in_roots, [&](Kernel kernel, Vertex step) {
    launches.push_back({kernel, step});
    launches.back().begin->record(stream);
  });
  stream.synchronize();
  print_depths(name, *analysis.plan, launches);
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    mfs::Engine::instance().run(mfs::available_threads(), [&] {
      mfs::Engine::use_cuda();
      measure(argv[i]);
    });
  }
}
