// MFS beside cuDSS on one device: for each FAMILY:SIZE or file both solvers go through all phases, one after
// the other on the same matrix, and each leaves a JSON line (times in s, memory in bytes); a third line has
// MFS' figures over cuDSS'. MFS may run by several backends, each as if it were another solver. With
// --memory-limit both run with less memory as well, cuDSS in its hybrid memory mode, and the lines tell by
// solution_1 and solution_16 whether solutions are the same bit for bit. perf/device runs this with all it
// needs.
//
//   perf_device --cudss DIR --backend cuda,kokkos elas3d:40 poisson2d:1000 my_matrix.mtx.gz
#include <cstdint>
#include <sstream>
#include <stdexcept>

#include <mfs/mfs.hpp>

#include "perf/command.hpp"
#include "perf/cudss_candidate.hpp"
#include "perf/device_info.hpp"
#include "perf/measure.hpp"

namespace {

using Json = nlohmann::ordered_json;
using namespace mfs::perf;

struct Arguments {
  Runs runs{{"elas3d:20", "elas3d:40", "elas3d:60", "elas3d:75", "elas3d:90", "convdiff3d:60",
             "convdiff3d:100", "kkt:24", "kkt:40", "poisson2d:1000"},
            16,
            5,
            1};
  std::string cudss, backend = "cuda";
  std::vector<std::uint64_t> limits;
};

struct Entrant {
  std::string name, backend;
  MakeCandidate make;
};

mfs::Backend backend_of(const std::string& name) {
  for (const mfs::Backend backend : {mfs::Backend::openmp, mfs::Backend::cuda, mfs::Backend::kokkos}) {
    if (name == mfs::backend_name(backend)) return backend;
  }
  throw std::invalid_argument("--backend: '" + name + "' is none of openmp, cuda and kokkos");
}

std::vector<Entrant> entrants_of(const Arguments& arguments) {
  std::vector<Entrant> entrants;
  std::istringstream names(arguments.backend);
  for (std::string name; std::getline(names, name, ',');) {
    const mfs::Backend backend = backend_of(name);
    entrants.push_back({"mfs", name, [backend, &arguments](const System& system) {
                          return make_mfs(system, backend, arguments.runs.threads);
                        }});
  }
  const auto add_cudss = [&](const std::string& name, std::int64_t bytes) {
    if (arguments.cudss.empty()) return;
    entrants.push_back({name, mfs::backend_name(mfs::Backend::cuda),
                        load_cudss(arguments.cudss, arguments.runs.threads, bytes)});
  };
  for (const std::uint64_t limit : arguments.limits) {
    const auto bytes = static_cast<std::int64_t>(limit);
    entrants.push_back({"mfs, " + std::to_string(bytes) + " bytes", mfs::backend_name(mfs::Backend::cuda),
                        [&arguments, bytes](const System& system) {
                          return make_mfs(system, mfs::Backend::cuda, arguments.runs.threads, bytes);
                        }});
    add_cudss("cudss, " + std::to_string(bytes) + " bytes", bytes);
  }
  add_cudss("cudss", 0);
  return entrants;
}

// Below 1: MFS is faster, or takes less.
Json ratios(const Json& ours, const Json& theirs) {
  Json json;
  for (const char* key : {"analysis_s", "first_factor_s", "refactor_s", "refactor_median_s", "solve_1_s",
                          "solve_16_s", "step_s", "factor_entries", "device_bytes", "device_bytes_1"}) {
    const double denominator = theirs[key];
    json[key] = denominator > 0 ? Json(ours[key].get<double>() / denominator) : Json(nullptr);
  }
  const double factor_bytes = ours["factor_entries"].get<double>() * sizeof(double);
  for (const char* key : {"device_bytes", "device_bytes_1"})
    json[std::string(key) + "_per_factor_byte"] = ours[key].get<double>() / factor_bytes;
  return json;
}

// Whether all of them solved it.
bool run_case(const std::string& name, const std::vector<Entrant>& entrants, const Arguments& arguments) {
  const System system = make_system(name, arguments.runs.threads);
  bool solved = true;
  for (int round = 1; round <= arguments.runs.rounds; ++round) {
    const Json head{{"case", mfs::io::bench_case_name(name)}, {"round", round}};
    std::vector<Json> results;
    for (const Entrant& entrant : entrants) {
      Json line = head;
      line.update({{"solver", entrant.name},
                   {"device", device_name()},
                   {"backend", entrant.backend},
                   {"threads", arguments.runs.threads},
                   {"repeat", arguments.runs.repeat},
                   {"n", system.a.n},
                   {"nnz", system.a.offsets.back()}});
      results.push_back(measure(entrant.make, system, arguments.runs.repeat));
      line.update(results.back());
      print(line);
      solved = solved && results.back()["status"] == "solved";
    }
    const auto is_solved = [](const Json& result) { return result["status"] == "solved"; };
    if (entrants.back().name != "cudss" || !is_solved(results.back())) continue;
    for (std::size_t i = 0; i + 1 < results.size(); ++i) {
      if (!is_solved(results[i])) continue;
      Json line = head;
      line.update({{"ratio", entrants[i].name + "/cudss"}, {"backend", entrants[i].backend}});
      line.update(ratios(results[i], results.back()));
      print(line);
    }
  }
  return solved;
}

// Whether every case was solved.
bool run(const Arguments& arguments) {
  check_cases(arguments.runs);
  const std::vector<Entrant> entrants = entrants_of(arguments);
  // The first use of a device makes its context and loads kernels: not part of any case.
  for (const Entrant& entrant : entrants)
    measure(entrant.make, make_system("elas3d:8", arguments.runs.threads), 1);
  return run_cases(arguments.runs,
                   [&](const std::string& name) { return run_case(name, entrants, arguments); });
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("MFS beside cuDSS on one device, as JSON lines");
  add_options(app, arguments.runs, "host threads of both");
  app.add_option("--cudss", arguments.cudss,
                 "folder of libcudss.so and its threading layer; without it MFS runs alone");
  app.add_option("--backend", arguments.backend,
                 "where MFS runs: cuda, kokkos, openmp, or several with commas");
  app.add_option("--memory-limit", arguments.limits,
                 "bytes of the device, once or more: MFS on cuda and cuDSS in its hybrid memory mode are "
                 "measured with each limit, too")
      ->transform(CLI::AsSizeValue(true).description(""))
      ->allow_extra_args(false);
  CLI11_PARSE(app, argc, argv);
  return exit_status("perf_device", [&] { return run(arguments); });
}
