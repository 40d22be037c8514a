// The options database against mfs::Options.
#include <iterator>
#include <limits>
#include <type_traits>

#include "factor.hpp"

namespace mfs::petsc {
namespace {

/// The enumerators of Backend, Matching and Precision count these.
constexpr const char* kBackends[] = {"serial", "openmp", "cuda", "kokkos"};
constexpr const char* kMatchings[] = {"automatic", "always", "never"};
constexpr const char* kPrecisions[] = {"automatic", "full", "single"};

/// PETSc itself only remarks at the end, if asked, that nobody has read an option.
PetscErrorCode refuse_unknown_names(Mat F) {
  const char* prefix = ((PetscObject)F)->prefix;
  char **names = nullptr, **values = nullptr, unknown[256] = "";
  PetscInt count = 0;
  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(((PetscObject)F)->options, &count, &names, &values));
  for (PetscInt k = 0; k < count; ++k) {
    const char* name = names[k];
    PetscBool ours = PETSC_TRUE;
    if (prefix != nullptr) {
      std::size_t length = 0;
      PetscCall(PetscStrbeginswith(name, prefix, &ours));
      PetscCall(PetscStrlen(prefix, &length));
      if (ours) name += length;
    }
    if (ours) PetscCall(PetscStrbeginswith(name, "mat_mfs_", &ours));
    if (ours) PetscCall(PetscStrncpy(unknown, names[k], sizeof unknown));
  }
  PetscCall(PetscOptionsLeftRestore(((PetscObject)F)->options, &count, &names, &values));
  PetscCheck(unknown[0] == '\0', PETSC_COMM_SELF, PETSC_ERR_ARG_UNKNOWN_TYPE, "MFS has no option -%s",
             unknown);
  PetscFunctionReturn(kSuccess);
}

}  // namespace

PetscErrorCode read_options(Mat F, Options* options) {
  PetscFunctionBegin;
  PetscOptionsBegin(PetscObjectComm((PetscObject)F), ((PetscObject)F)->prefix, "MFS options", "Mat");
  const auto number = [&](const char* name, const char* text, int least, int* value) -> PetscErrorCode {
    PetscInt given = *value;
    PetscCall(PetscOptionsInt(name, text, "Mat", given, &given, nullptr));
    PetscCheck(given >= least && given <= std::numeric_limits<int>::max(), PETSC_COMM_SELF,
               PETSC_ERR_ARG_OUTOFRANGE, "%s is %" PetscInt_FMT ", not at least %d", name, given, least);
    *value = static_cast<int>(given);
    return kSuccess;
  };
  const auto fraction = [&](const char* name, const char* text, double* value) -> PetscErrorCode {
    auto given = static_cast<PetscReal>(*value);
    PetscCall(PetscOptionsReal(name, text, "Mat", given, &given, nullptr));
    PetscCheck(given >= 0 && given <= 1, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
               "%s is %g, not in 0 ... 1", name, static_cast<double>(given));  // nor is NaN
    *value = given;
    return kSuccess;
  };
  const auto choice = [&](const char* name, const char* text, const auto& names,
                          auto* value) -> PetscErrorCode {
    auto given = static_cast<PetscInt>(*value);
    PetscCall(PetscOptionsEList(name, text, "Mat", names, std::size(names), names[given], &given, nullptr));
    *value = static_cast<std::decay_t<decltype(*value)>>(given);
    return kSuccess;
  };
  AnalysisOptions& analysis = options->analysis;
  PetscBool scaling = analysis.scaling ? PETSC_TRUE : PETSC_FALSE;
  PetscBool solve_singular = options->solve.solve_singular ? PETSC_TRUE : PETSC_FALSE;
  char dump_prefix[PETSC_MAX_PATH_LEN] = "";
  PetscCall(choice("-mat_mfs_backend", "Where the numeric phases run", kBackends, &options->backend));
  PetscCall(number("-mat_mfs_threads", "Threads; 0: this rank's share of its node, or MFS_NUM_THREADS", 0,
                   &options->threads));
  PetscCall(number("-mat_mfs_analysis_threads", "Threads of the analysis; 0: as many as of the rest", 0,
                   &analysis.threads));
  PetscCall(choice("-mat_mfs_matching", "When large entries are brought to the diagonal", kMatchings,
                   &analysis.matching));
  PetscCall(PetscOptionsBool("-mat_mfs_scaling", "Whether rows and columns are scaled", "Mat", scaling,
                             &scaling, nullptr));
  PetscCall(number("-mat_mfs_max_block_size", "Widest block of pivots", 1, &analysis.max_block_size));
  PetscCall(
      number("-mat_mfs_leaf_size", "Unknowns of a graph that is not dissected", 1, &analysis.leaf_size));
  PetscCall(choice("-mat_mfs_precision", "Of the factors; solutions are as accurate", kPrecisions,
                   &options->factor.precision));
  PetscCall(fraction("-mat_mfs_pivot_tolerance", "Smallest pivot of the scaled matrix; 0: sqrt(epsilon)",
                     &options->factor.pivot_tolerance));
  PetscCall(number("-mat_mfs_max_reanalyses", "How often the tree may change because pivots failed", 0,
                   &options->factor.max_reanalyses));
  PetscCall(fraction("-mat_mfs_tolerance", "Componentwise backward error of every solution; 0: the default",
                     &options->solve.tolerance));
  PetscCall(number("-mat_mfs_max_refinement_steps", "Most steps of iterative refinement", 0,
                   &options->solve.max_refinement_steps));
  PetscCall(
      fraction("-mat_mfs_row_floor", "What rows of rounding count at least", &options->solve.row_floor));
  PetscCall(PetscOptionsBool("-mat_mfs_solve_singular",
                             "Whether a matrix that is singular to working precision is solved all the same",
                             "Mat", solve_singular, &solve_singular, nullptr));
  PetscCall(PetscOptionsString("-mat_mfs_dump_prefix", "Where a system that fails is left", "Mat",
                               dump_prefix, dump_prefix, sizeof dump_prefix, nullptr));
  analysis.scaling = scaling == PETSC_TRUE;
  options->solve.solve_singular = solve_singular == PETSC_TRUE;
  const Failure failure = attempt([&] { options->dump_prefix = dump_prefix; });
  PetscCheck(!failure.happened, PETSC_COMM_SELF, failure.code, "MFS: %s", failure.text);
  PetscOptionsEnd();
  PetscCall(refuse_unknown_names(F));
  PetscFunctionReturn(kSuccess);
}

}  // namespace mfs::petsc
