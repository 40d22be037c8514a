// Amesos2's interface to MFS.
//
//   preOrdering              nothing: the ordering is part of the analysis
//   symbolicFactorization    rows to rank 0, mfs analyze (matching, ordering, symbolic plan)
//   numericFactorization     values to rank 0, mfs factor; afterwards mfs refactor, without any new memory
//   solve                    right-hand sides to rank 0, mfs solve, solutions back
//
// On one rank the caller's arrays are read and written where they lie.
//
// Errors are thrown on every rank: the classes of mfs/error.hpp (all are std::runtime_error), with rows and
// columns as the caller's global ids, and std::invalid_argument for shapes that do not fit. After a failed
// numericFactorization, solve throws until another one has succeeded.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <Amesos2_SolverCore.hpp>
#include <Amesos2_SolverTraits.hpp>

#include <mfs/report.hpp>

namespace Amesos2 {

/// The parameters of the sublist "MFS" of a list named "Amesos2", with defaults, documentation and
/// validators: "Backend", "Threads", "DefaultThreads", "AnalysisThreads", "Matching", "Scaling",
/// "MaxBlockSize", "MemoryLimit", "OutOfCoreDir", "LeafSize", "PivotTolerance", "Precision", "MaxReanalyses",
/// "Tolerance", "MaxRefinementSteps", "RowFloor", "SolveSingular", "DumpPrefix", "Verbosity", "Trans" and
/// "IsContiguous".
Teuchos::RCP<const Teuchos::ParameterList> mfs_valid_parameters();

/// What all solvers named MFS have done in this process. Ifpack2, FROSch and MueLu keep the solvers that they
/// make to themselves; this is how to see how often those analysed, and what they hold. A solver of several
/// ranks works, and counts, on the first of them.
struct MfsTotals {
  std::int64_t analyses = 0;        ///< ordering and symbolic factorization
  std::int64_t factorizations = 0;  ///< the first ones and those with new values
  std::int64_t solves = 0;          ///< right-hand sides
  double seconds_analyses = 0, seconds_factorizations = 0, seconds_solves = 0;
  std::int64_t bytes = 0;  ///< of the factorizations that there are now, with their workspace
};
MfsTotals mfs_totals();

/// Made by Amesos2::create<Matrix, Vector>("MFS", ...); see Amesos2_MFS.hpp.
template <class Matrix, class Vector>
class MFS : public SolverCore<Amesos2::MFS, Matrix, Vector> {
  friend class SolverCore<Amesos2::MFS, Matrix, Vector>;

 public:
  static const char* name;

  using type = MFS<Matrix, Vector>;
  using super_type = SolverCore<Amesos2::MFS, Matrix, Vector>;

  MFS(Teuchos::RCP<const Matrix> A, Teuchos::RCP<Vector> X, Teuchos::RCP<const Vector> B);
  ~MFS();

  /// Throws std::invalid_argument where `a` is null or not square, or has other dimensions although a phase
  /// is to be kept.
  void setA(const Teuchos::RCP<const Matrix> a, EPhase keep_phase = CLEAN) override;
  using super_type::setA;

  /// The next numericFactorization takes these values, in memory of the CUDA device, instead of those of the
  /// matrix, whose entries they belong to in its order; the pattern is not compared. `stream`, a
  /// cudaStream_t, is where they become what they are. Throws mfs::StateError unless takesDeviceValues(), and
  /// mfs::InvalidInput for a null pointer.
  void setDeviceValues(const double* values, void* stream = nullptr);
  /// On one rank, with "Backend" "cuda", once a matrix has been factored: matching needs its values on the
  /// host.
  bool takesDeviceValues() const;
  /// Solves A x = b with both in memory of the CUDA device, one number for each row and for the unknown of
  /// the same global id, in the order of the rows. `stream`, a cudaStream_t, is where b becomes what it is; x
  /// is there when the call returns. Throws mfs::StateError unless takesDeviceValues(), and as solve() does.
  void solveDevice(const double* b, double* x, void* stream = nullptr) const;

  /// Throws std::invalid_argument where lengths or numbers of columns do not fit, on all ranks.
  void solve(const Teuchos::Ptr<Vector> X, const Teuchos::Ptr<const Vector> B) const override;
  using super_type::solve;

  /// What the solver says about its work. Rank 0 has it; on the other ranks all figures are zero.
  const mfs::Report& report() const;

  std::string description() const override;
  /// On rank 0. VERB_LOW: sizes and memory; VERB_MEDIUM: also flops, times, accuracy; VERB_HIGH: also
  /// the parameters; VERB_EXTREME: also the fronts by depth and Amesos2's timers.
  void describe(Teuchos::FancyOStream& out, const Teuchos::EVerbosityLevel level =
                                                Teuchos::Describable::verbLevel_default) const override;

 private:
  int preOrdering_impl();
  int symbolicFactorization_impl();
  int numericFactorization_impl();
  int solve_impl(const Teuchos::Ptr<MultiVecAdapter<Vector>> X,
                 const Teuchos::Ptr<const MultiVecAdapter<Vector>> B) const;
  bool matrixShapeOK_impl() const;
  void setParameters_impl(const Teuchos::RCP<Teuchos::ParameterList>& parameters);
  Teuchos::RCP<const Teuchos::ParameterList> getValidParameters_impl() const;
  bool loadA_impl(EPhase current_phase);

  class Impl;
  std::unique_ptr<Impl> impl_;
};

template <>
struct solver_traits<MFS> {
  using supported_scalars = Meta::make_list1<double>;
};

}  // namespace Amesos2
