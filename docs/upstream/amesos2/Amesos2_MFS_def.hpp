#ifndef AMESOS2_MFS_DEF_HPP
#define AMESOS2_MFS_DEF_HPP

#include <Teuchos_CommHelpers.hpp>
#include <Teuchos_ParameterList.hpp>
#include <Teuchos_StandardParameterEntryValidators.hpp>
#include <exception>

#include "Amesos2_MFS_decl.hpp"

namespace Amesos2 {

template <class Matrix, class Vector>
MFS<Matrix, Vector>::MFS(Teuchos::RCP<const Matrix> A, Teuchos::RCP<Vector> X, Teuchos::RCP<const Vector> B)
    : SolverCore<Amesos2::MFS, Matrix, Vector>(A, X, B), transposed_(false), is_contiguous_(true) {}

template <class Matrix, class Vector>
MFS<Matrix, Vector>::~MFS() {}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::preOrdering_impl() {
  return 0;  // a part of the symbolic factorization
}

template <class Matrix, class Vector>
template <class Work>
void MFS<Matrix, Vector>::on_root(const char* phase, const Work& work) const {
  std::string error;
  int failed = 0;
  if (this->root_) {
    try {
      work();
    } catch (const std::exception& e) {
      failed = 1;
      error = e.what();
    }
  }
  Teuchos::broadcast(*(this->getComm()), 0, &failed);
  TEUCHOS_TEST_FOR_EXCEPTION(failed != 0, std::runtime_error,
                             "MFS " << phase << " failed on rank 0. " << error);
}

template <class Matrix, class Vector>
mfs::CsrView<typename MFS<Matrix, Vector>::mfs_dtype> MFS<Matrix, Vector>::view() const {
  const std::int64_t n = static_cast<std::int64_t>(this->globalNumRows_);
  return {n, n, offsets_.data(), columns_.data(), reinterpret_cast<const mfs_dtype*>(values_.data())};
}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::symbolicFactorization_impl() {
  on_root("symbolic factorization", [&] {
    solver_.reset(new mfs::BasicSolver<mfs_dtype>(options_));
    mfs::CsrView<mfs_dtype> pattern = view();
    pattern.values = nullptr;  // those of the first numeric factorization decide about the matching
    solver_->analyze(pattern);
  });
  return 0;
}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::numericFactorization_impl() {
  on_root("numeric factorization", [&] {
#ifdef HAVE_AMESOS2_TIMERS
    Teuchos::TimeMonitor timer(this->timers_.numFactTime_);
#endif
    solver_->factor(view());
    this->setNnzLU(static_cast<std::size_t>(solver_->report().nnz_factor));
  });
  return 0;
}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::solve_impl(const Teuchos::Ptr<MultiVecAdapter<Vector>> X,
                                    const Teuchos::Ptr<const MultiVecAdapter<Vector>> B) const {
  const std::size_t rows = this->root_ ? X->getGlobalLength() : 0;
  const std::size_t columns = X->getGlobalNumVectors();
  bool x_is_the_adapters = false;
  {
#ifdef HAVE_AMESOS2_TIMERS
    Teuchos::TimeMonitor timer(this->timers_.vecConvTime_);
#endif
    typedef Util::get_1d_copy_helper_kokkos_view<MultiVecAdapter<Vector>, host_solve_array_t> get;
    get::do_get(true, B, b_, rows, distribution(), this->rowIndexBase_);
    x_is_the_adapters = get::do_get(false, X, x_, rows, distribution(), this->rowIndexBase_);
  }
  on_root("solve", [&] {
#ifdef HAVE_AMESOS2_TIMERS
    Teuchos::TimeMonitor timer(this->timers_.solveTime_);
#endif
    const mfs_dtype* b = reinterpret_cast<const mfs_dtype*>(b_.data());
    mfs_dtype* x = reinterpret_cast<mfs_dtype*>(x_.data());
    const std::int64_t ldb = static_cast<std::int64_t>(columns > 1 ? b_.stride(1) : rows);
    const std::int64_t ldx = static_cast<std::int64_t>(columns > 1 ? x_.stride(1) : rows);
    if (transposed_)
      solver_->solve_transpose(b, x, static_cast<std::int64_t>(columns), ldb, ldx);
    else
      solver_->solve(b, x, static_cast<std::int64_t>(columns), ldb, ldx);
  });
  if (!x_is_the_adapters) {
#ifdef HAVE_AMESOS2_TIMERS
    Teuchos::TimeMonitor timer(this->timers_.vecRedistTime_);
#endif
    Util::put_1d_data_helper_kokkos_view<MultiVecAdapter<Vector>, host_solve_array_t>::do_put(
        X, x_, rows, distribution(), this->rowIndexBase_);
  }
  return 0;
}

template <class Matrix, class Vector>
bool MFS<Matrix, Vector>::matrixShapeOK_impl() const {
  return this->matrixA_->getGlobalNumRows() == this->matrixA_->getGlobalNumCols();
}

template <class Matrix, class Vector>
void MFS<Matrix, Vector>::setParameters_impl(const Teuchos::RCP<Teuchos::ParameterList>& parameterList) {
  transposed_ = this->control_.useTranspose_;
  if (parameterList->isParameter("Trans")) transposed_ = parameterList->get<std::string>("Trans") == "TRANS";
  if (parameterList->isParameter("IsContiguous")) is_contiguous_ = parameterList->get<bool>("IsContiguous");
  mfs::Options options = options_;
  for (const std::string& option : mfs::option_names()) {
    if (!parameterList->isParameter(option)) continue;
    const Teuchos::ParameterEntry& entry = parameterList->getEntry(option);
    const bool is_flag = entry.isType<bool>();
    const std::string text = is_flag                       ? (Teuchos::getValue<bool>(entry) ? "yes" : "no")
                             : entry.isType<std::string>() ? Teuchos::getValue<std::string>(entry)
                                                           : Teuchos::toString(entry.getAny(false));
    mfs::set_option(options, option, text);
  }
  mfs::BasicSolver<mfs_dtype>{options};  // refuses what makes no sense
  options_ = options;                    // of the next symbolic factorization
}

template <class Matrix, class Vector>
Teuchos::RCP<const Teuchos::ParameterList> MFS<Matrix, Vector>::getValidParameters_impl() const {
  static Teuchos::RCP<const Teuchos::ParameterList> valid;
  if (is_null(valid)) {
    Teuchos::RCP<Teuchos::ParameterList> list = Teuchos::parameterList();
    list->set("Trans", "NOTRANS", "NOTRANS: A x = b, TRANS: A^T x = b",
              Teuchos::rcp(new Teuchos::StringValidator(Teuchos::tuple<std::string>("NOTRANS", "TRANS"))));
    list->set("IsContiguous", true, "Whether GIDs contiguous");
    const Teuchos::RCP<const Teuchos::ParameterEntryValidator> any =
        Teuchos::rcp(new Teuchos::AnyNumberParameterEntryValidator(
            Teuchos::AnyNumberParameterEntryValidator::PREFER_STRING,
            Teuchos::AnyNumberParameterEntryValidator::AcceptedTypes(true)));
    for (const std::string& option : mfs::option_names()) {
      const bool number = option != "backend" && option != "matching" && option != "scaling" &&
                          option != "precision" && option != "out_of_core_dir" && option != "dump_prefix";
      if (number)
        list->set(option, std::string("0"), "See mfs/options.hpp", any);
      else if (option == "scaling")
        list->set(option, true, "See mfs/analysis_options.hpp");
      else
        list->set(option, std::string(), "See mfs/options.hpp");
    }
    valid = list;
  }
  return valid;
}

template <class Matrix, class Vector>
bool MFS<Matrix, Vector>::loadA_impl(EPhase current_phase) {
  if (current_phase == SOLVE) return false;
#ifdef HAVE_AMESOS2_TIMERS
  Teuchos::TimeMonitor timer(this->timers_.mtxConvTime_);
#endif
  if (this->root_) {
    values_ =
        host_value_type_array(Kokkos::ViewAllocateWithoutInitializing("values"), this->globalNumNonZeros_);
    columns_ =
        host_ordinal_type_array(Kokkos::ViewAllocateWithoutInitializing("columns"), this->globalNumNonZeros_);
    offsets_ =
        host_ordinal_type_array(Kokkos::ViewAllocateWithoutInitializing("offsets"), this->globalNumRows_ + 1);
  }
  local_ordinal_type entries = 0;
  Util::get_crs_helper_kokkos_view<MatrixAdapter<Matrix>, host_value_type_array, host_ordinal_type_array,
                                   host_ordinal_type_array>::do_get(this->matrixA_.ptr(), values_, columns_,
                                                                    offsets_, entries, distribution(),
                                                                    ARBITRARY, this->rowIndexBase_);
  return true;
}

template <class Matrix, class Vector>
const char* MFS<Matrix, Vector>::name = "MFS";

}  // namespace Amesos2

#endif  // AMESOS2_MFS_DEF_HPP
