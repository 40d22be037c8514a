#include "describe.hpp"

#include <iomanip>
#include <sstream>

#include "parameters.hpp"

namespace mfs::amesos2 {
namespace {

std::string megabytes(std::int64_t bytes) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << static_cast<double>(bytes) / 1e6 << " MB";
  return text.str();
}

void describe_sizes(std::ostream& out, const Report& report) {
  out << "matrix: " << report.n << " rows, " << report.nnz << " entries\n"
      << "backend: " << backend_name(report.backend) << ", " << report.threads << " threads\n"
      << "entries of L and U: " << report.nnz_factor << " (" << megabytes(report.bytes_factor) << ", peak "
      << megabytes(report.bytes_peak) << ")\n";
}

void describe_work(std::ostream& out, const Report& report) {
  out << "fronts: " << report.fronts << " at " << report.depths << " depths, the largest of "
      << report.max_front << " rows\n"
      << "matched: " << (report.matched ? "yes" : "no") << "\n"
      << "flops: " << report.flops.total() << " (getrf " << report.flops.getrf << ", trsm "
      << report.flops.trsm << ", gemm " << report.flops.gemm << ")\n"
      << "time: ordering " << report.time_order << " s, symbolic " << report.time_symbolic << " s, factor "
      << report.time_factor << " s, refactor " << report.time_refactor << " s, solve " << report.time_solve
      << " s\n"
      << "precision of the factors: " << (report.single_precision ? "single" : "full") << "\n"
      << "perturbed pivots: " << report.perturbed_pivots << ", " << report.reanalyses
      << " changes of the tree\n"
      << "backward error: " << report.backward_error << " after " << report.refinement_steps
      << " refinement and " << report.krylov_steps << " FGMRES steps, " << report.corrected_pivots
      << " pivots corrected; highest rung: " << rung_name(report.rung) << ", " << report.time_ladder
      << " s\n";
}

void describe_depths(std::ostream& out, const std::vector<DepthSummary>& depths) {
  out << "depth   fronts     pivots  max front   factor entries\n";
  for (const DepthSummary& depth : depths)
    out << std::setw(5) << depth.depth << std::setw(9) << depth.fronts << std::setw(11) << depth.pivots
        << std::setw(11) << depth.max_front << std::setw(17) << depth.factor_entries << "\n";
}

}  // namespace

std::string description(std::int64_t unknowns, const RootedSolver& solver) {
  const char* state = solver.factored() ? "factored" : solver.analyzed() ? "analysed" : "not analysed";
  return "MFS solver interface: " + std::to_string(unknowns) + " unknowns, " + state;
}

void describe(std::ostream& out, Teuchos::EVerbosityLevel level, const std::string& title,
              const RootedSolver& solver, const Teuchos::ParameterList& parameters) {
  if (level == Teuchos::VERB_DEFAULT) level = Teuchos::VERB_LOW;
  out << title << "\n";
  if (solver.analyzed()) {
    describe_sizes(out, solver.report());
    if (level >= Teuchos::VERB_MEDIUM) describe_work(out, solver.report());
  }
  if (level >= Teuchos::VERB_HIGH) {
    Teuchos::ParameterList all(parameters);
    all.setParametersNotAlreadySet(*valid_parameters());
    out << "parameters:\n";
    all.print(out, 2);
  }
  if (level >= Teuchos::VERB_EXTREME) describe_depths(out, solver.depths());
}

}  // namespace mfs::amesos2
