#include "factor.hpp"

#include <algorithm>

namespace mfs::petsc {

void Factor::analyze_now(const CsrView<Scalar>& a) {
  pattern_may_differ_ = false;
  solver_.analyze(a);
  ++analyses_;
}

void Factor::analyze(const CsrView<Scalar>& a) {
  if (solver_.analyzed())
    pattern_may_differ_ = true;
  else
    analyze_now(a);
}

void Factor::factorize(const CsrView<Scalar>& a) {
  const auto factor = [&] { solver_.factored() ? solver_.refactor(a) : solver_.factor(a); };
  if (!solver_.analyzed()) analyze_now(a);
  try {
    factor();
  } catch (const PatternChanged&) {
    if (!pattern_may_differ_) throw;
    analyze_now(a);
    factor();
  }
  pattern_may_differ_ = false;
  ++factorizations_;
  if (solver_.report().perturbed_pivots > 0) try_to_solve(a);
}

// Whether a perturbed matrix is a singular one, a solve finds out. That of A x = A (1 ... 1) has no unknown
// or row that is tiny beside the others, so it meets no other trouble; if it does, the caller's solves will
// tell.
void Factor::try_to_solve(const CsrView<Scalar>& a) {
  trial_.assign(static_cast<std::size_t>(a.rows), Scalar(0));
  for (std::int64_t i = 0; i < a.rows; ++i)
    for (std::int64_t k = a.row_offsets[i]; k < a.row_offsets[i + 1]; ++k)
      trial_[static_cast<std::size_t>(i)] += a.values[k];
  try {
    solver_.solve(trial_.data(), trial_.data());
  } catch (const AccuracyNotReached&) {
  }
}

namespace {

constexpr const char* kYesNo[] = {"no", "yes"};

const char* matching_name(Matching matching) {
  return matching == Matching::automatic ? "automatic" : matching == Matching::always ? "always" : "never";
}

PetscErrorCode view_options(const Options& options, PetscViewer viewer) {
  const AnalysisOptions& analysis = options.analysis;
  PetscFunctionBegin;
  PetscCall(
      PetscViewerASCIIPrintf(viewer,
                             "  threads of the analysis %d, matching %s, scaling %s, max block size %d, "
                             "leaf size %d\n",
                             analysis.threads, matching_name(analysis.matching), kYesNo[analysis.scaling],
                             analysis.max_block_size, analysis.leaf_size));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "  precision of the factors %s, pivot tolerance %g (0: the default), max reanalyses %d\n",
      precision_name(options.factor.precision), options.factor.pivot_tolerance,
      options.factor.max_reanalyses));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "  tolerance %g (0: the default), max refinement steps %d, row floor %g, solve singular %s\n",
      options.solve.tolerance, options.solve.max_refinement_steps, options.solve.row_floor,
      kYesNo[options.solve.solve_singular]));
  if (!options.dump_prefix.empty())
    PetscCall(PetscViewerASCIIPrintf(viewer, "  dump prefix %s\n", options.dump_prefix.c_str()));
  PetscFunctionReturn(kSuccess);
}

}  // namespace

PetscErrorCode view_factor(Factor* factor, PetscViewer viewer) {
  PetscFunctionBegin;
  if (factor == nullptr || !factor->solver().analyzed()) {
    PetscCall(PetscViewerASCIIPrintf(viewer, "MFS %s: nothing analysed\n", version()));
    PetscFunctionReturn(kSuccess);
  }
  const Report& report = factor->solver().report();
  PetscCall(PetscViewerASCIIPrintf(viewer, "MFS %s: backend %s, threads %d\n", version(),
                                   backend_name(report.backend), report.threads));
  PetscCall(view_options(factor->solver().options(), viewer));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "  analyses %" PetscInt_FMT ", factorizations %" PetscInt_FMT ", changes of the tree %d\n",
      factor->analyses(), factor->factorizations(), report.reanalyses));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "  rows matched %s, fronts %lld at %lld depths, the largest of %lld rows\n",
      kYesNo[report.matched], static_cast<long long>(report.fronts), static_cast<long long>(report.depths),
      static_cast<long long>(report.max_front)));
  PetscCall(
      PetscViewerASCIIPrintf(viewer, "  nonzeros of L and U %lld, flops %g, memory %g MB\n",
                             static_cast<long long>(report.nnz_factor), report.flops.total(),
                             static_cast<double>(std::max(report.bytes_used, report.bytes_peak)) / 1e6));
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "  perturbed pivots %lld, last solve: backward error %g, reached by %s\n",
      static_cast<long long>(report.perturbed_pivots), report.backward_error, rung_name(report.rung)));
  PetscFunctionReturn(kSuccess);
}

}  // namespace mfs::petsc
