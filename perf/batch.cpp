// mfs::BatchSolver beside KLU on the host and beside cuDSS on a device: many systems with one pattern, each
// with values and a right-hand side of its own. All have made their analysis and take turns in one process.
// KLU refactors with the pivots of the first values and solves, one system a thread at a time. On a device
// all arrays lie there. JSON lines with wall-clock and processor time for one system (us), and the wall-clock
// time of the analysis (ms, with the factorization of a first matrix).
//
//   perf_batch --threads 16 --count 10000 chain:91 circuit:1000 my_matrix.mtx
//   perf_batch --backends cuda --cudss DIR chain:91
#include <algorithm>
#include <ctime>
#include <memory>

#include "ordering/stopwatch.hpp"
#include "perf/batch_entrant.hpp"
#include "perf/command.hpp"

namespace {

using Json = nlohmann::ordered_json;
using namespace mfs::perf;

struct Arguments {
  std::vector<std::string> cases{"chain:91", "chain:18", "circuit:1000"}, backends{"openmp"};
  std::int64_t count = 10000;
  int rounds = 3;
  MfsBatchOptions mfs;
  std::string cudss;
  bool without_klu = false;
};

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

Json measured(const BatchCase& batch, BatchEntrant& entrant) {
  const double processor = processor_seconds();
  const mfs::Stopwatch watch;
  const std::int64_t failed = entrant.solve();
  const double wall = watch.seconds(), used = processor_seconds() - processor;
  const double systems = static_cast<double>(batch.count) * 1e-6;
  std::vector<double> x(batch.b.size());
  entrant.read(x.data());
  return {{"us", wall / systems},
          {"processor_us", used / systems},
          {"failed", failed},
          {"backward_error", worst_error(batch, x.data())}};
}

struct Named {
  std::string name;
  std::function<std::unique_ptr<BatchEntrant>()> make;
};

std::vector<Named> entrants_of(const BatchCase& batch, const Arguments& arguments) {
  std::vector<Named> all;
  for (const std::string& backend : arguments.backends)
    all.push_back({"mfs " + backend, [&, backend] { return make_mfs_batch(batch, backend, arguments.mfs); }});
  if (!arguments.without_klu)
    all.push_back({"klu", [&] { return make_klu_batch(batch, arguments.mfs.threads); }});
  if (!arguments.cudss.empty()) {
    for (const int steps : {0, 2})
      all.push_back({"cudss, " + std::to_string(steps) + " refinements",
                     [&, steps] { return make_cudss_batch(batch, arguments.cudss, steps); }});
  }
  return all;
}

// Whether all was solved. One solver after the other has the device's memory.
bool run_case(const std::string& name, const Arguments& arguments) {
  const BatchCase batch = make_batch_case(name, arguments.count);
  bool solved = true;
  for (const Named& named : entrants_of(batch, arguments)) {
    Json line{{"case", name},
              {"solver", named.name},
              {"round", 0},
              {"n", batch.a.n},
              {"nnz", batch.a.offsets.back()},
              {"count", batch.count},
              {"threads", arguments.mfs.threads}};
    try {
      const std::unique_ptr<BatchEntrant> entrant = named.make();
      line["analysis_ms"] = 1e3 * entrant->analysis_seconds();
      for (int round = 1; round <= arguments.rounds; ++round) {
        line["round"] = round;
        line.update(measured(batch, *entrant));
        print(line);
        solved = solved && line["failed"] == 0;
      }
    } catch (const std::exception& error) {
      line["error"] = error.what();
      print(line);
      solved = false;
    }
  }
  return solved;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("mfs::BatchSolver beside KLU and cuDSS, as JSON lines");
  app.add_option("cases", arguments.cases, "FAMILY:SIZE, a file, or chain:BODIES")->capture_default_str();
  app.add_option("--count", arguments.count, "systems")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--backends", arguments.backends, "of MFS; 'cuda with copies': arrays on the host")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  app.add_option("--cudss", arguments.cudss, "folder of libcudss");
  app.add_flag("--without-klu", arguments.without_klu, "leave KLU out");
  app.add_option("--threads", arguments.mfs.threads, "of the host")->check(CLI::PositiveNumber);
  app.add_option("--leaf-size", arguments.mfs.leaf_size, "of MFS' ordering")->check(CLI::PositiveNumber);
  app.add_flag("--details", arguments.mfs.details, "tell what MFS' analysis has made");
  app.add_option("--rounds", arguments.rounds, "times that each solves all")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  return exit_status("perf_batch", [&] {
    bool solved = true;
    for (const std::string& name : arguments.cases) solved = run_case(name, arguments) && solved;
    return solved;
  });
}
