// Amesos2::MFS: the phases of SolverCore in terms of RootedSolver.
//
// SolverCore drops the integer that the *_impl functions return, checks neither shapes nor patterns in
// release builds and gives an implementation no way to the objects behind its adapters; hence the overridden
// setA and solve, which check and keep them.
#pragma once

#include "Amesos2_MFS_decl.hpp"

#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>

#include <Amesos2_SolverCore_def.hpp>
#include <Teuchos_TimeMonitor.hpp>

#include <mfs/threads.hpp>

#include "describe.hpp"
#include "on_all_ranks.hpp"
#include "parameters.hpp"
#include "rooted_solver.hpp"
#include "trilinos_access.hpp"

#ifdef HAVE_AMESOS2_TIMERS
#define MFS_AMESOS2_TIME(timer) Teuchos::TimeMonitor mfs_time_monitor(this->timers_.timer)
#else
#define MFS_AMESOS2_TIME(timer) static_cast<void>(0)
#endif

namespace Amesos2 {

template <class Matrix, class Vector>
class MFS<Matrix, Vector>::Impl {
 public:
  using RootedSolver = mfs::amesos2::RootedSolver;
  using Space = RootedSolver::Space;
  using MatrixAccess = mfs::amesos2::MatrixAccess<Matrix>;
  using VectorAccess = mfs::amesos2::VectorAccess<Vector>;

  Impl(Teuchos::RCP<const Matrix> a, Teuchos::RCP<const Teuchos::Comm<int>> comm)
      : matrix(std::move(a)), solver(std::move(comm)) {}

  /// The maps of the matrix that was analysed.
  struct Maps {
    typename MatrixAccess::Map rows, columns, unknowns;
  };
  /// A vector's map and what was made of it; vectors of one map come again and again.
  struct KnownLayout {
    std::unique_ptr<typename VectorAccess::Map> map;
    mfs::amesos2::VectorLayout layout;
  };

  const mfs::amesos2::VectorLayout& layout(const Vector& v, Space space, KnownLayout& known) {
    const typename VectorAccess::Map map = VectorAccess::map(v);
    if (!known.map || !mfs::amesos2::same(map, *known.map)) {
      known.map.reset();
      known.layout = solver.make_layout(mfs::amesos2::ids(map), space);
      known.map = std::make_unique<typename VectorAccess::Map>(map);
    }
    return known.layout;
  }

  /// Pattern and values of the matrix, with its numbering.
  void load(const Teuchos::Comm<int>& comm) {
    mfs::amesos2::LocalIds ids;
    mfs::amesos2::LocalRows rows;
    maps = {};
    given_values = {};
    for (auto& known : layouts) known = {};
    mfs::amesos2::on_all_ranks(comm, [&] {
      check_complete();
      maps = {MatrixAccess::row_map(*matrix), MatrixAccess::column_map(*matrix),
              MatrixAccess::unknown_map(*matrix)};
      ids = {mfs::amesos2::ids(maps.rows), mfs::amesos2::ids(maps.columns), mfs::amesos2::ids(maps.unknowns)};
      rows = MatrixAccess::rows(*matrix);
    });
    solver.load(ids, rows);
    if constexpr (MatrixAccess::kOnDevice) {
      if (!on_device()) return;
      device_pattern = MatrixAccess::device_pattern(*matrix);
      solver.set_stream(MatrixAccess::stream());
    }
  }

  /// Values of a matrix that is spread over the ranks as the analysed one was.
  void load_values(const Teuchos::Comm<int>& comm) {
    mfs::amesos2::LocalRows rows;
    solver.forget_factorization();
    if (!solver.analyzed())
      throw mfs::StateError("numericFactorization: symbolicFactorization has not succeeded");
    const mfs::amesos2::DeviceValues given = std::exchange(given_values, {});
    if (given.data != nullptr) return solver.load_device_values(given);
    mfs::amesos2::on_all_ranks(comm, [&] { check_complete(); });
    const bool same_ids = mfs::amesos2::same(maps.rows, MatrixAccess::row_map(*matrix)) &&
                          mfs::amesos2::same(maps.unknowns, MatrixAccess::unknown_map(*matrix));
    const bool same_columns = mfs::amesos2::same(maps.columns, MatrixAccess::column_map(*matrix));
    if constexpr (MatrixAccess::kOnDevice) {
      if (same_ids && same_columns && on_device() && solver.takes_device_values()) {
        const mfs::amesos2::DeviceValues values = MatrixAccess::device_values(*matrix, device_pattern);
        if (values.data != nullptr)
          return solver.load_device_values(values);  // else the host says what differs
      }
    }
    std::vector<std::int64_t> column_ids;
    mfs::amesos2::on_all_ranks(comm, [&] {
      if (!same_ids)
        throw mfs::PatternChanged(
            "row or domain map of the matrix differ from those that symbolicFactorization saw", -1);
      rows = MatrixAccess::rows(*matrix);
      if (!same_columns) column_ids = mfs::amesos2::ids(MatrixAccess::column_map(*matrix));
    });
    solver.load_values(rows, same_columns ? nullptr : &column_ids);
  }

  /// Whether arrays on the device are read and written there.
  bool on_device() const {
    if constexpr (MatrixAccess::kOnDevice)
      return solver.takes_device_arrays() && MatrixAccess::on_first_device();
    return false;
  }

  Teuchos::RCP<const Matrix> matrix;
  RootedSolver solver;
  Maps maps;
  typename MatrixAccess::DevicePattern device_pattern;
  mfs::amesos2::DeviceValues given_values;  ///< for the next factorization, by setDeviceValues
  KnownLayout layouts[2];                   ///< by Space

  Teuchos::ParameterList parameters{"MFS"};  ///< as set last
  bool has_trans = false, trans = false;

  Vector* x = nullptr;  ///< of the solve that is running
  const Vector* b = nullptr;

 private:
  void check_complete() const {
    if (!MatrixAccess::complete(*matrix)) throw std::invalid_argument("MFS: the matrix is not fill-complete");
  }
};

template <class Matrix, class Vector>
const char* MFS<Matrix, Vector>::name = "MFS";

template <class Matrix, class Vector>
MFS<Matrix, Vector>::MFS(Teuchos::RCP<const Matrix> A, Teuchos::RCP<Vector> X, Teuchos::RCP<const Vector> B)
    : super_type(A, X, B), impl_(std::make_unique<Impl>(A, this->getComm())) {}

template <class Matrix, class Vector>
MFS<Matrix, Vector>::~MFS() = default;

template <class Matrix, class Vector>
bool MFS<Matrix, Vector>::matrixShapeOK_impl() const {
  return this->matrixA_->getGlobalNumRows() == this->matrixA_->getGlobalNumCols();
}

template <class Matrix, class Vector>
void MFS<Matrix, Vector>::setA(const Teuchos::RCP<const Matrix> a, EPhase keep_phase) {
  if (a.is_null()) throw std::invalid_argument("MFS: setA was given no matrix");
  const auto adapter = createConstMatrixAdapter<Matrix>(a);
  const auto rows = adapter->getGlobalNumRows(), columns = adapter->getGlobalNumCols();
  if (rows != columns)
    throw std::invalid_argument("MFS: setA was given a matrix of " + std::to_string(rows) + " rows and " +
                                std::to_string(columns) + " columns");
  if (keep_phase >= SYMBFACT && rows != this->globalNumRows_)
    throw std::invalid_argument("MFS: setA was asked to keep a phase of a matrix of " +
                                std::to_string(this->globalNumRows_) + " rows, the new one has " +
                                std::to_string(rows));
  super_type::setA(a, keep_phase);
  impl_->matrix = a;
}

template <class Matrix, class Vector>
void MFS<Matrix, Vector>::setDeviceValues(const double* values, void* stream) {
  if (!takesDeviceValues())
    throw mfs::StateError("setDeviceValues: only on one rank, with Backend cuda, after a factorization");
  if (values == nullptr) throw mfs::InvalidInput("values", "null pointer");
  impl_->given_values = {values, stream, nullptr};
}

template <class Matrix, class Vector>
bool MFS<Matrix, Vector>::takesDeviceValues() const {
  return impl_->solver.takes_device_values();
}

template <class Matrix, class Vector>
void MFS<Matrix, Vector>::solveDevice(const double* b, double* x, void* stream) const {
  impl_->solver.require_factorization();
  if (!takesDeviceValues()) throw mfs::StateError("solveDevice: only on one rank, with Backend cuda");
  MFS_AMESOS2_TIME(solveTime_);
  impl_->solver.solve_device(b, x, stream);
}

template <class Matrix, class Vector>
bool MFS<Matrix, Vector>::loadA_impl(EPhase current_phase) {
  MFS_AMESOS2_TIME(mtxRedistTime_);
  if (current_phase == SYMBFACT) {
    impl_->load(*this->getComm());
    return true;
  }
  if (current_phase == NUMFACT) {
    impl_->load_values(*this->getComm());
    return true;
  }
  return false;
}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::preOrdering_impl() {
  return 0;
}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::symbolicFactorization_impl() {
  MFS_AMESOS2_TIME(symFactTime_);
  impl_->solver.analyze();
  return 0;
}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::numericFactorization_impl() {
  MFS_AMESOS2_TIME(numFactTime_);
  impl_->solver.factor();
  if (this->root_) this->setNnzLU(static_cast<std::size_t>(report().nnz_factor));
  return 0;
}

template <class Matrix, class Vector>
void MFS<Matrix, Vector>::solve(const Teuchos::Ptr<Vector> X, const Teuchos::Ptr<const Vector> B) const {
  using Access = typename Impl::VectorAccess;
  X.assert_not_null();
  B.assert_not_null();
  const auto rows = static_cast<std::int64_t>(this->globalNumRows_);
  const auto check_length = [&](const Vector& v, const std::string& name) {
    if (Access::length(v) != rows)
      throw std::invalid_argument("MFS: " + name + " has " + std::to_string(Access::length(v)) +
                                  " entries per column, the matrix " + std::to_string(rows) + " rows");
    if (!Access::supported(v))
      throw std::invalid_argument("MFS: " + name + " has several entries per global id");
  };
  check_length(*X, "X");
  check_length(*B, "B");
  if (Access::columns(*X) != Access::columns(*B))
    throw std::invalid_argument("MFS: X has " + std::to_string(Access::columns(*X)) + " columns, B " +
                                std::to_string(Access::columns(*B)));
  impl_->x = X.getRawPtr();
  impl_->b = B.getRawPtr();
  super_type::solve(X, B);
}

template <class Matrix, class Vector>
int MFS<Matrix, Vector>::solve_impl(const Teuchos::Ptr<MultiVecAdapter<Vector>>,
                                    const Teuchos::Ptr<const MultiVecAdapter<Vector>>) const {
  using Access = typename Impl::VectorAccess;
  using Space = typename Impl::Space;
  Impl& impl = *impl_;
  const bool transpose = impl.has_trans ? impl.trans : this->control_.useTranspose_;
  const Space b_space = transpose ? Space::unknowns : Space::rows;
  const Space x_space = transpose ? Space::rows : Space::unknowns;
  impl.solver.require_factorization();
  std::shared_ptr<const void> hold_b, hold_x;
  std::vector<double> b_copy, x_copy;
  const mfs::amesos2::VectorLayout *b_layout = nullptr, *x_layout = nullptr;
  mfs::amesos2::LocalColumns<const double> b;
  mfs::amesos2::LocalColumns<double> x;
  const std::int64_t length_b = Access::local_length(*impl.b), length_x = Access::local_length(*impl.x);
  {
    MFS_AMESOS2_TIME(vecConvTime_);
    b_layout = &impl.layout(*impl.b, b_space, impl.layouts[static_cast<int>(b_space)]);
    x_layout = &impl.layout(*impl.x, x_space, impl.layouts[static_cast<int>(x_space)]);
    const bool on_device = impl.on_device() && b_layout->in_order() && x_layout->in_order() &&
                           Access::one_distance(*impl.b) && Access::one_distance(*impl.x);
    mfs::amesos2::on_all_ranks(*this->getComm(), [&] {
      b = Access::read(*impl.b, hold_b, on_device);
      if (b.data == nullptr && length_b > 0) {
        b_copy.resize(length_b * Access::columns(*impl.b));
        Access::copy_from(*impl.b, b_copy.data());
        b = {b_copy.data(), length_b};
      }
      x = Access::write(*impl.x, hold_x, on_device);
      if (x.data == nullptr && length_x > 0) {
        x_copy.resize(length_x * Access::columns(*impl.x));
        x = {x_copy.data(), length_x};
      }
    });
  }
  {
    MFS_AMESOS2_TIME(solveTime_);
    impl.solver.solve(*b_layout, b, *x_layout, x, Access::columns(*impl.b), transpose);
  }
  if (!x_copy.empty()) Access::copy_to(x_copy.data(), *impl.x);
  return 0;
}

template <class Matrix, class Vector>
void MFS<Matrix, Vector>::setParameters_impl(const Teuchos::RCP<Teuchos::ParameterList>& parameters) {
  const mfs::amesos2::Parameters read = mfs::amesos2::read_parameters(*parameters);
  if (read.default_threads > 0) mfs::set_default_threads(read.default_threads);
  impl_->has_trans = read.has_trans;
  impl_->trans = read.transpose;
  const bool same = mfs::amesos2::same_options(*parameters, impl_->parameters);
  impl_->parameters = *parameters;
  if (same) return;
  impl_->solver.set_options(read.options);
  super_type::setA(impl_->matrix, CLEAN);  // the phases start again, with the new options
}

template <class Matrix, class Vector>
Teuchos::RCP<const Teuchos::ParameterList> MFS<Matrix, Vector>::getValidParameters_impl() const {
  return mfs::amesos2::valid_parameters();
}

template <class Matrix, class Vector>
const mfs::Report& MFS<Matrix, Vector>::report() const {
  return impl_->solver.report();
}

template <class Matrix, class Vector>
std::string MFS<Matrix, Vector>::description() const {
  return mfs::amesos2::description(static_cast<std::int64_t>(this->globalNumRows_), impl_->solver);
}

template <class Matrix, class Vector>
void MFS<Matrix, Vector>::describe(Teuchos::FancyOStream& out, const Teuchos::EVerbosityLevel level) const {
  if (!this->root_ || level == Teuchos::VERB_NONE) return;
  Util::printLine(out);
  mfs::amesos2::describe(out, level, description(), impl_->solver, impl_->parameters);
  if (level == Teuchos::VERB_EXTREME) this->printTiming(out, level);
  Util::printLine(out);
}

}  // namespace Amesos2
