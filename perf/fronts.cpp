// The fronts of a matrix, for perf/study: for each FAMILY:SIZE or file a JSON line with its distinct sizes
// and how many fronts have each, [[pivots, border rows, fronts], ...]. Nothing is factored. Sizes do not
// depend on how the pivot blocks are divided, so one analysis serves every block size. A file whose matrix is
// complex is refused.
//
//   perf_fronts elas3d:20 my_matrix.mtx.gz
#include <cstdio>
#include <exception>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include <nlohmann/json.hpp>

#include <mfs/error.hpp>

#include "kernels/runtime/engine.hpp"
#include "solver/analysis.hpp"
#include "solver/program/bench_case.hpp"

namespace {

nlohmann::ordered_json fronts_of(const std::string& name) {
  const int threads = mfs::available_threads();
  const mfs::io::SquareMatrix matrix = mfs::io::load_bench_case(name, threads);
  const auto* a = std::get_if<mfs::io::CsrMatrix<double>>(&matrix);
  if (!a) throw mfs::InvalidInput(name, "the matrix is complex");
  const mfs::Analysis analysis = mfs::analyze_matrix(
      a->view(), mfs::AnalysisOptions(), mfs::host_needs(threads), threads, [](const char*, double) {});
  const mfs::SymbolicPlan& plan = *analysis.plan;
  std::map<std::pair<mfs::Vertex, mfs::Vertex>, std::int64_t> count;
  for (mfs::Vertex f = 0; f < plan.num_fronts; ++f) ++count[{plan.pivots(f), plan.border_rows(f)}];
  nlohmann::ordered_json fronts = nlohmann::ordered_json::array();
  for (const auto& [size, number] : count) fronts.push_back({size.first, size.second, number});
  return {{"case", mfs::io::bench_case_name(name)},
          {"n", plan.n},
          {"nnz", plan.nnz},
          {"depths", plan.num_depths},
          {"fronts", std::move(fronts)}};
}

}  // namespace

int main(int argc, char** argv) try {
  for (int i = 1; i < argc; ++i) mfs::io::check_bench_case(argv[i]);
  for (int i = 1; i < argc; ++i) {
    std::printf("%s\n", fronts_of(argv[i]).dump().c_str());
    std::fflush(stdout);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "perf_fronts: %s\n", error.what());
  return 2;
}
