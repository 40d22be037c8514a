// MFS below Trilinos' methods for many machines: Schwarz methods and multigrid over MPI ranks, each rank with
// direct solvers of its own.
//
//   mpiexec -n 4 mfs_distributed gdsw.xml                    3D elasticity, 13 nodes a side
//   mpiexec -n 4 mfs_distributed gdsw.xml schwarz.xml --problem=stokes --nodes=21
//   mpiexec -n 4 mfs_distributed schwarz.xml --matrix=A.mtx
//   mpiexec -n 8 mfs_distributed gdsw.xml --per-rank=12 --new-values=1    12 nodes a side on each rank
//
// For each parameter file (settings.hpp) and solver: a table of set-up, iterations and solution, also for new
// values on the same pattern, and of what MFS did on each rank. Exit codes: 0 solved, 1 an error, or a system
// that did not converge or is not the direct solution (--check), 2 usage.
#include <algorithm>
#include <exception>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <Teuchos_CommandLineProcessor.hpp>
#include <Teuchos_oblackholestream.hpp>
#include <Tpetra_Core.hpp>

#include "all_ranks.hpp"
#include "problem.hpp"
#include "report.hpp"
#include "settings.hpp"
#include "solve.hpp"

namespace {

using namespace distributed;

/// Largest relative difference from the direct solution. The residual is 1e-10 of the right-hand side, and
/// the condition of the bodies magnifies it.
constexpr double kSame = 1e-6;

struct Options {
  std::vector<std::string> files;
  std::string problem = "elasticity", matrix, solvers = "MFS", backend;
  int nodes = 13, per_rank = 0, threads = -1, singular = -1;
  Task task;
  bool json = false;
};

/// Exit code, or -1: go on.
int read_options(int argc, char** argv, Options& options) {
  while (argc > 1 && argv[1][0] != '-') {
    options.files.push_back(argv[1]);
    --argc;
    ++argv;
  }
  Teuchos::CommandLineProcessor line(false, true, true);
  line.setDocString("mfs_distributed FILE.xml... [options]");
  line.setOption("problem", &options.problem, "elasticity or stokes");
  line.setOption("matrix", &options.matrix, "a Matrix Market file instead");
  line.setOption("nodes", &options.nodes, "nodes of the body on each side");
  line.setOption("per-rank", &options.per_rank, "nodes of each rank on each side, instead");
  line.setOption("solver", &options.solvers, "MFS, or a list such as MFS,KLU2");
  line.setOption("new-values", &options.task.new_values, "how often the values change");
  line.setOption("check", "no-check", &options.task.check, "compare with the direct solution");
  line.setOption("mfs-threads", &options.threads, "MFS' Threads in place of the file's");
  line.setOption("mfs-backend", &options.backend, "MFS' Backend in place of the file's");
  line.setOption("singular", &options.singular, "rank in the middle of whose rows one becomes zero");
  line.setOption("verbose", "quiet", &options.task.verbose, "let the engines print");
  line.setOption("json", "table", &options.json, "one JSON line per file and solver");
  const auto comm = Tpetra::getDefaultComm();
  Teuchos::oblackholestream nowhere;
  std::ostream& err = comm->getRank() == 0 ? std::cerr : static_cast<std::ostream&>(nowhere);
  const auto parsed = line.parse(argc, argv, &err);
  if (parsed == Teuchos::CommandLineProcessor::PARSE_HELP_PRINTED) return 0;
  if (parsed != Teuchos::CommandLineProcessor::PARSE_SUCCESSFUL) return 2;
  if (!options.files.empty() && options.task.new_values >= 0 && options.singular < comm->getSize()) return -1;
  err << "mfs_distributed: at least one FILE.xml; --new-values from 0; --singular is a rank" << std::endl;
  return 2;
}

Problem make_problem(const Options& options) {
  const auto comm = Tpetra::getDefaultComm();
  if (!options.matrix.empty()) {
    require_file(options.matrix, *comm);
    return from_file(comm, options.matrix);
  }
  Counts nodes{options.nodes, options.nodes, options.nodes};
  if (options.per_rank > 0) {
    nodes = divide_ranks(comm->getSize());
    for (auto& count : nodes) count *= options.per_rank;
  }
  if (options.problem == "elasticity") return elasticity(comm, nodes);
  if (options.problem == "stokes") return stokes(comm, nodes);
  throw std::invalid_argument("--problem is elasticity or stokes, not " + options.problem);
}

/// From the next values on, a row of zeros in the middle of that rank's.
void make_singular(Problem& problem, int rank) {
  const auto a = problem.a;
  problem.set_values = [a, rank, set_values = problem.set_values](int step) {
    set_values(step);
    a->resumeFill();
    if (a->getComm()->getRank() == rank) {
      const auto map = a->getRowMap();
      const auto middle = static_cast<LocalOrdinal>(map->getMyGlobalIndices().extent(0) / 2);
      const std::size_t length = a->getNumEntriesInLocalRow(middle);
      Matrix::nonconst_local_inds_host_view_type columns("columns", length);
      Matrix::nonconst_values_host_view_type values("values", length);
      std::size_t count = 0;
      a->getLocalRowCopy(middle, columns, values, count);
      Kokkos::deep_copy(values, 0.0);
      a->replaceLocalValues(middle, columns, values);
    }
    a->fillComplete(a->getDomainMap(), a->getRangeMap());
  };
}

std::vector<std::string> parts(const std::string& list) {
  std::vector<std::string> all;
  std::istringstream text(list);
  for (std::string part; std::getline(text, part, ',');) all.push_back(part);
  return all;
}

int run(const Options& options, const AllRanks& all_ranks) {
  const auto comm = Tpetra::getDefaultComm();
  Problem problem = make_problem(options);
  if (options.singular >= 0) make_singular(problem, options.singular);
  Teuchos::oblackholestream nowhere;
  std::ostream& out = comm->getRank() == 0 ? std::cout : static_cast<std::ostream&>(nowhere);
  if (!options.json) print_heading(out, problem);
  bool good = true;
  for (const std::string& file : options.files) {
    Settings settings = read_settings(file, comm);
    if (options.threads >= 0) set_mfs_option(settings.engine, "Threads", options.threads);
    if (!options.backend.empty()) set_mfs_option(settings.engine, "Backend", options.backend);
    for (const std::string& solver : parts(options.solvers)) {
      const Measured measured = measure(problem, settings, solver, options.task, all_ranks);
      if (options.json)
        print_json(out, problem, measured);
      else
        print_table(out, measured);
      const bool same = std::all_of(measured.steps.begin(), measured.steps.end(),
                                    [](const Step& step) { return step.difference <= kSame; });
      good = good && measured.converged() && same;
    }
  }
  return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Tpetra::ScopeGuard scope(&argc, &argv);
  Options options;
  const int usage = read_options(argc, argv, options);
  if (usage >= 0) return usage;
  const AllRanks all_ranks(MPI_COMM_WORLD);
  int code = 1;
  try {
    all_ranks.run([&] { code = run(options, all_ranks); });
  } catch (const std::exception& e) {
    if (Tpetra::getDefaultComm()->getRank() == 0) std::cerr << "mfs_distributed: " << e.what() << std::endl;
  }
  return code;
}
