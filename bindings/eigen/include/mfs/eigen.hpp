// MFS for Eigen: a sparse direct solver like Eigen::SparseLU, for SparseMatrix of four kinds of numbers,
// row-major or column-major, with 32-bit or 64-bit indices.
//
//   mfs::MfsLU<Eigen::SparseMatrix<double>> lu(A);      // or lu.compute(A)
//   if (lu.info() != Eigen::Success) std::cerr << lu.lastErrorMessage();
//   x = lu.solve(b);                                    // one or many columns
//   lu.factorize(A_next);                               // same pattern, new values
//   x = lu.transpose().solve(b);                        // and lu.adjoint()
//
//   Eigen::GMRES<Matrix, mfs::MfsLU<Matrix>> gmres;     // as a preconditioner
//
// Failures are told as Eigen tells them, by info() and not by exceptions: InvalidInput for a matrix with NaN
// or infinity and for one that does not have the analysed pattern, NumericalIssue for a singular one and for
// memory or devices that are not to be had, NoConvergence for a solution that misses the tolerance. The
// solution of a solve that failed is NaN everywhere.
#pragma once

#include <Eigen/SparseCore>

#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include <mfs/mfs.hpp>

namespace mfs {

template <class MatrixType_>
class MfsLU;

/// What MfsLU::transpose and MfsLU::adjoint return: solves with A^T, or with A^H. It must not outlive its
/// MfsLU.
template <class Lu, bool Conjugated>
class MfsTransposedLU : public Eigen::SparseSolverBase<MfsTransposedLU<Lu, Conjugated>> {
  using Base = Eigen::SparseSolverBase<MfsTransposedLU>;

 public:
  using MatrixType = typename Lu::MatrixType;
  using Scalar = typename Lu::Scalar;
  using StorageIndex = typename Lu::StorageIndex;
  enum {
    ColsAtCompileTime = MatrixType::RowsAtCompileTime,
    MaxColsAtCompileTime = MatrixType::MaxRowsAtCompileTime
  };

  explicit MfsTransposedLU(const Lu* lu) : lu_(lu) { this->m_isInitialized = lu->isInitialized(); }
  MfsTransposedLU(MfsTransposedLU&& other) : MfsTransposedLU(other.lu_) {}

  Eigen::Index rows() const { return lu_->cols(); }
  Eigen::Index cols() const { return lu_->rows(); }
  Eigen::ComputationInfo info() const { return lu_->info(); }

  using Base::_solve_impl;
  template <class Rhs, class Dest>
  void _solve_impl(const Eigen::MatrixBase<Rhs>& b, Eigen::MatrixBase<Dest>& x) const {
    typename Lu::Columns columns = Conjugated ? typename Lu::Columns(b.conjugate()) : typename Lu::Columns(b);
    lu_->solve_in_place(columns, !Lu::kRowMajor ? Lu::Form::stored : Lu::Form::transposed);
    if (Conjugated) columns = columns.conjugate().eval();
    x = columns;
  }

 private:
  const Lu* lu_;
};

/// `MatrixType` is an Eigen::SparseMatrix of float, double or a complex of these. One object belongs to one
/// thread at a time.
template <class MatrixType_>
class MfsLU : public Eigen::SparseSolverBase<MfsLU<MatrixType_>> {
  using Base = Eigen::SparseSolverBase<MfsLU>;

 public:
  using MatrixType = MatrixType_;
  using Scalar = typename MatrixType::Scalar;
  using RealScalar = typename MatrixType::RealScalar;
  using StorageIndex = typename MatrixType::StorageIndex;
  enum {
    ColsAtCompileTime = MatrixType::ColsAtCompileTime,
    MaxColsAtCompileTime = MatrixType::MaxColsAtCompileTime
  };
  /// A matrix, map, block or expression of that type; what is not compressed, or in the other order, is
  /// copied.
  using ConstMatrix = Eigen::Ref<const MatrixType, Eigen::StandardCompressedFormat>;

  /// Throws as BasicSolver's constructor does for options that make no sense.
  explicit MfsLU(const Options& options = {}) { setOptions(options); }
  explicit MfsLU(const ConstMatrix& a, const Options& options = {}) : MfsLU(options) { compute(a); }

  /// Options of all that follows; forgets what was computed. For the preconditioner within an iterative
  /// solver.
  void setOptions(const Options& options) {
    solver_ = std::make_unique<BasicSolver<Scalar>>(options);
    this->m_isInitialized = false;
    info_ = Eigen::InvalidInput;
  }

  /// Orders the pattern of `a`. Its values, where they can be used, decide about matching and scaling.
  MfsLU& analyzePattern(const ConstMatrix& a) {
    this->m_isInitialized = false;
    attempt([&] { analyze(a); });
    return *this;
  }
  /// Factors `a`, which has the analysed pattern.
  MfsLU& factorize(const ConstMatrix& a) {
    eigen_assert(solver_->analyzed() && "analyzePattern comes first");
    this->m_isInitialized = attempt([&] { factor(a); });
    return *this;
  }
  /// Both.
  MfsLU& compute(const ConstMatrix& a) {
    analyzePattern(a);
    return info_ == Eigen::Success ? factorize(a) : *this;
  }

  Eigen::Index rows() const { return size_; }
  Eigen::Index cols() const { return size_; }
  /// Of the last call, solve included.
  Eigen::ComputationInfo info() const { return info_; }
  /// What went wrong and where, counted from 0; empty after a success. Row and column are those of `a` where
  /// it is row-major, else of its transposed.
  const std::string& lastErrorMessage() const { return message_; }
  bool isInitialized() const { return this->m_isInitialized; }

  /// Solve A^T x = b (without conjugation) and A^H x = b: lu.transpose().solve(b).
  MfsTransposedLU<MfsLU, false> transpose() const { return MfsTransposedLU<MfsLU, false>(this); }
  MfsTransposedLU<MfsLU, true> adjoint() const { return MfsTransposedLU<MfsLU, true>(this); }

  /// phase * exp(log_abs); throw as BasicSolver's do.
  Determinant<Scalar> determinant() const { return solver_->determinant(); }
  /// The solver itself: report, depths, estimate of the condition. A matrix that is column-major is to it the
  /// transposed one.
  BasicSolver<Scalar>& solver() const { return *solver_; }

  using Base::_solve_impl;
  template <class Rhs, class Dest>
  void _solve_impl(const Eigen::MatrixBase<Rhs>& b, Eigen::MatrixBase<Dest>& x) const {
    Columns columns = b;
    solve_in_place(columns, kRowMajor ? Form::stored : Form::transposed);
    x = columns;
  }

 private:
  template <class, bool>
  friend class MfsTransposedLU;

  using Columns = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor>;
  /// Which of A and A^T a solve is with: the one whose compressed rows the solver has, or the other.
  enum class Form { stored, transposed };
  static constexpr bool kRowMajor = MatrixType::IsRowMajor;

  static CsrView<Scalar> view(const ConstMatrix& a) {
    const std::int64_t outer = a.outerSize(), inner = a.innerSize();
    return {outer, inner, a.outerIndexPtr(), a.innerIndexPtr(), a.valuePtr()};
  }

  void analyze(const ConstMatrix& a) {
    size_ = a.rows();
    try {
      solver_->analyze(view(a));
    } catch (const SingularMatrix&) {
      analyze_alone(a);
    } catch (const InvalidInput& e) {
      if (e.argument() != "values") throw;
      analyze_alone(a);
    }
  }
  /// Without values, which may come later.
  void analyze_alone(const ConstMatrix& a) {
    CsrView<Scalar> pattern = view(a);
    pattern.values = nullptr;
    solver_->analyze(pattern);
  }

  void factor(const ConstMatrix& a) {
    if (solver_->factored())
      solver_->refactor(view(a));
    else
      solver_->factor(view(a));
  }

  void solve_in_place(Columns& columns, Form form) const {
    if (columns.cols() == 0) return;
    const bool good = attempt([&] {
      if (form == Form::stored)
        solver_->solve(columns.data(), columns.data(), columns.cols());
      else
        solver_->solve_transpose(columns.data(), columns.data(), columns.cols());
    });
    if (!good) columns.setConstant(Scalar(std::numeric_limits<RealScalar>::quiet_NaN()));
  }

  bool keep(Eigen::ComputationInfo info, const char* message) const {
    info_ = info;
    message_ = message;
    return info == Eigen::Success;
  }
  /// Runs `work`. Of its errors only a text that finds no memory gets out.
  template <class Work>
  bool attempt(const Work& work) const {
    try {
      work();
      return keep(Eigen::Success, "");
    } catch (const AccuracyNotReached& e) {
      return keep(Eigen::NoConvergence, e.what());
    } catch (const SingularMatrix& e) {
      return keep(Eigen::NumericalIssue, e.what());
    } catch (const OutOfMemory& e) {
      return keep(Eigen::NumericalIssue, e.what());
    } catch (const BackendError& e) {
      return keep(Eigen::NumericalIssue, e.what());
    } catch (const Error& e) {
      return keep(Eigen::InvalidInput, e.what());
    }
  }

  std::unique_ptr<BasicSolver<Scalar>> solver_;
  Eigen::Index size_ = 0;
  mutable Eigen::ComputationInfo info_ = Eigen::InvalidInput;
  mutable std::string message_;
};

}  // namespace mfs
