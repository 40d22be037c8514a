// MFS beside other direct solvers of the host: for each FAMILY:SIZE or file all of them go through all
// phases, by turns in one process and on the same matrix, and each leaves a JSON line for every round (times
// in s). A line for each peer has MFS' times over its own: the median of the rounds, the least and the most.
// perf/host runs this.
//
//   perf_host --pardiso libmkl_rt.so.3 --threads 16 elas3d:20 my_matrix.mtx.gz
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include <mfs/mfs.hpp>

#include "perf/peers.hpp"
#include "solver/program/bench_case.hpp"

namespace {

using Json = nlohmann::ordered_json;
using namespace mfs::perf;

struct Arguments {
  std::vector<std::string> cases{"elas3d:20", "convdiff3d:40", "kkt:20", "poisson2d:500"};
  std::vector<std::string> peers = linked_peers();
  std::string pardiso;
  int threads = 1, repeat = 5, rounds = 3;
};

struct Entrant {
  std::string name;
  MakeCandidate make;
  std::vector<Json> results;
};

void print(const Json& json) {
  std::printf("%s\n", json.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
  std::fflush(stdout);
}

std::vector<Entrant> entrants_of(const Arguments& arguments) {
  const int threads = arguments.threads;
  std::vector<Entrant> entrants{
      {"mfs", [=](const System& system) { return make_mfs(system, mfs::Backend::openmp, threads); }, {}}};
  for (const std::string& name : arguments.peers) entrants.push_back({name, linked_peer(name), {}});
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
  for (const std::string phase : {"analysis", "first_factor", "refactor", "solve_1", "solve_16"}) {
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
  const System system = make_system(name, arguments.threads);
  bool solved = true;
  for (int round = 1; round <= arguments.rounds; ++round) {
    for (Entrant& entrant : entrants) {
      Json line{{"case", mfs::io::bench_case_name(name)},
                {"round", round},
                {"solver", entrant.name},
                {"threads", arguments.threads},
                {"repeat", arguments.repeat},
                {"n", system.a.n},
                {"nnz", system.a.offsets.back()}};
      entrant.results.push_back(measure(entrant.make, system, arguments.repeat));
      line.update(entrant.results.back());
      print(line);
      solved = solved && entrant.results.back()["status"] == "solved";
    }
  }
  for (std::size_t i = 1; i < entrants.size(); ++i) {
    Json line{{"case", mfs::io::bench_case_name(name)}, {"ratio", "mfs/" + entrants[i].name}};
    line["threads"] = arguments.threads;
    const Json found = ratios(entrants.front(), entrants[i]);
    if (found.is_null()) continue;
    line.update(found);
    print(line);
  }
  return solved;
}

bool run(const Arguments& arguments) {
  for (const std::string& name : arguments.cases) mfs::io::check_bench_case(name);
  const std::vector<Entrant> entrants = entrants_of(arguments);
  bool solved = true;
  for (const std::string& name : arguments.cases) solved = run_case(name, entrants, arguments) && solved;
  return solved;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("MFS beside other direct solvers of the host, as JSON lines");
  app.add_option("cases", arguments.cases, "FAMILY:SIZE or a file, Matrix Market or PETSc binary")
      ->capture_default_str();
  app.add_option("--peers", arguments.peers, "solvers that this program was built with")
      ->check(CLI::IsMember(linked_peers()))
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--pardiso", arguments.pardiso, "libmkl_rt.so, for PARDISO");
  app.add_option("--threads", arguments.threads, "of MFS and PARDISO; others have those of the BLAS")
      ->check(CLI::PositiveNumber);
  app.add_option("--repeat", arguments.repeat, "refactorizations and solves that are timed")
      ->check(CLI::PositiveNumber);
  app.add_option("--rounds", arguments.rounds, "times that the solvers take turns")
      ->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  try {
    return run(arguments) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "perf_host: %s\n", error.what());
    return 2;
  }
}
