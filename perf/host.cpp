// MFS beside other direct solvers of the host: for each FAMILY:SIZE or file all of them go through all
// phases, by turns in one process and on the same matrix, and each leaves a JSON line for every round (times
// in s). A line for each peer has MFS' times over its own: the median of the rounds, the least and the most.
// perf/host runs this.
//
//   perf_host --pardiso libmkl_rt.so.3 --threads 16 elas3d:20 my_matrix.mtx.gz
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include <mfs/mfs.hpp>

#include "perf/command.hpp"
#include "perf/peers.hpp"

namespace {

using Json = nlohmann::ordered_json;
using namespace mfs::perf;

/// What --peers takes where PARDISO alone, or nothing, is to stand beside MFS.
constexpr const char* kNone = "none";

struct Arguments {
  Runs runs{{"elas3d:20", "convdiff3d:40", "kkt:20", "poisson2d:500"}, 1, 5, 3};
  std::vector<std::string> peers{"umfpack", "klu"};
  std::string pardiso;
  bool without_mfs = false;
};

struct Entrant {
  std::string name;
  MakeCandidate make;
  std::vector<Json> results;
};

std::vector<Entrant> entrants_of(const Arguments& arguments) {
  const int threads = arguments.runs.threads;
  std::vector<Entrant> entrants;
  if (!arguments.without_mfs) {
    entrants.push_back(
        {"mfs", [=](const System& system) { return make_mfs(system, mfs::Backend::openmp, threads); }, {}});
  }
  for (const std::string& name : arguments.peers) {
    if (name != kNone) entrants.push_back({name, linked_peer(name), {}});
  }
  if (!arguments.pardiso.empty())
    entrants.push_back({"pardiso", load_pardiso(arguments.pardiso, threads), {}});
  return entrants;
}

bool is_accurate(const Json& result) {
  return result["status"] == "solved" && result["accurate"] == true;
}

// Below 1: MFS is faster. Only rounds that both have ended with an accurate solution count.
Json ratios(const Entrant& ours, const Entrant& theirs) {
  Json json;
  for (const std::string phase : {"analysis", "first_factor", "refactor", "solve_1", "solve_16", "step"}) {
    std::vector<double> found;
    for (std::size_t round = 0; round < ours.results.size(); ++round) {
      const Json &a = ours.results[round], &b = theirs.results[round];
      if (is_accurate(a) && is_accurate(b))
        found.push_back(a[phase + "_s"].get<double>() / b[phase + "_s"].get<double>());
    }
    std::sort(found.begin(), found.end());
    if (found.empty()) continue;
    json[phase] = found[found.size() / 2];
    json[phase + "_least"] = found.front();
    json[phase + "_most"] = found.back();
    json["rounds"] = found.size();
  }
  return json;
}

// Whether all of them solved it.
bool run_case(const std::string& name, std::vector<Entrant> entrants, const Arguments& arguments) {
  const Runs& runs = arguments.runs;
  const System system = make_system(name, runs.threads);
  bool solved = true;
  for (int round = 1; round <= runs.rounds; ++round) {
    for (Entrant& entrant : entrants) {
      Json line{{"case", mfs::io::bench_case_name(name)},
                {"round", round},
                {"solver", entrant.name},
                {"threads", runs.threads},
                {"repeat", runs.repeat},
                {"n", system.a.n},
                {"nnz", system.a.offsets.back()}};
      entrant.results.push_back(measure(entrant.make, system, runs.repeat));
      line.update(entrant.results.back());
      print(line);
      solved = solved && entrant.results.back()["status"] == "solved";
    }
  }
  for (std::size_t i = 1; i < entrants.size() && !arguments.without_mfs; ++i) {
    Json line{{"case", mfs::io::bench_case_name(name)}, {"ratio", "mfs/" + entrants[i].name}};
    line["threads"] = runs.threads;
    const Json found = ratios(entrants.front(), entrants[i]);
    if (found.is_null()) continue;
    line.update(found);
    print(line);
  }
  return solved;
}

// Solvers have as many threads of OpenBLAS as there are to be, and kernels that suit the processor. OpenBLAS
// reads its environment when it is loaded, so the program begins once more where that says something else.
void begin_with_blas_for(int threads, char** argv) {
  const std::string wanted = std::to_string(threads), kernels = mfs::better_blas_kernels();
  const char* told = std::getenv("OPENBLAS_NUM_THREADS");
  if (told != nullptr && told == wanted && kernels.empty()) return;
  setenv("OPENBLAS_NUM_THREADS", wanted.c_str(), 1);
  if (!kernels.empty()) setenv("OPENBLAS_CORETYPE", kernels.c_str(), 0);
  if (std::getenv("PERF_HOST_BEGUN") != nullptr) return;
  setenv("PERF_HOST_BEGUN", "1", 1);
  execv("/proc/self/exe", argv);
}

bool run(const Arguments& arguments) {
  check_cases(arguments.runs);
  const std::vector<Entrant> entrants = entrants_of(arguments);
  return run_cases(arguments.runs,
                   [&](const std::string& name) { return run_case(name, entrants, arguments); });
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  std::vector<std::string> named = linked_peers();
  named.emplace_back(kNone);
  CLI::App app("MFS beside other direct solvers of the host, as JSON lines");
  add_options(app, arguments.runs, "of all solvers but KLU, which has one");
  app.add_option("--peers", arguments.peers,
                 "solvers that this program was built with; cholmod needs a positive definite matrix")
      ->check(CLI::IsMember(named))
      ->allow_extra_args(false)
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--pardiso", arguments.pardiso, "libmkl_rt.so, for PARDISO");
  app.add_flag("--without-mfs", arguments.without_mfs, "measure the others alone");
  CLI11_PARSE(app, argc, argv);
  begin_with_blas_for(arguments.runs.threads, argv);
  return exit_status("perf_host", [&] { return run(arguments); });
}
