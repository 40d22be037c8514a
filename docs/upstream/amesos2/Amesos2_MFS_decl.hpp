// The interface to MFS, a multifrontal direct solver for unsymmetric systems with a checked backward error.
#ifndef AMESOS2_MFS_DECL_HPP
#define AMESOS2_MFS_DECL_HPP

#include <memory>
#include <mfs/mfs.hpp>
#include <string>

#include "Amesos2_MFS_TypeMap.hpp"
#include "Amesos2_SolverCore.hpp"
#include "Amesos2_SolverTraits.hpp"

namespace Amesos2 {

/** \brief Amesos2 interface to MFS.
 *
 * The matrix is gathered on rank 0, which solves; every rank throws where that fails. A pattern is analysed
 * by symbolicFactorization; later numeric factorizations of it repeat nothing and allocate nothing.
 *
 * \ingroup amesos2_solver_interfaces
 */
template <class Matrix, class Vector>
class MFS : public SolverCore<Amesos2::MFS, Matrix, Vector> {
  friend class SolverCore<Amesos2::MFS, Matrix, Vector>;

 public:
  /// Name of this solver interface.
  static const char* name;

  typedef MFS<Matrix, Vector> type;
  typedef SolverCore<Amesos2::MFS, Matrix, Vector> super_type;
  typedef typename super_type::scalar_type scalar_type;
  typedef typename super_type::local_ordinal_type local_ordinal_type;
  typedef typename super_type::global_ordinal_type global_ordinal_type;
  typedef typename super_type::global_size_type global_size_type;
  typedef TypeMap<Amesos2::MFS, scalar_type> type_map;
  typedef typename type_map::type mfs_type;
  typedef typename type_map::dtype mfs_dtype;

  /// \warning Should not be called directly! Use Amesos2::create().
  MFS(Teuchos::RCP<const Matrix> A, Teuchos::RCP<Vector> X, Teuchos::RCP<const Vector> B);
  ~MFS();

 private:
  int preOrdering_impl();
  int symbolicFactorization_impl();
  int numericFactorization_impl();
  int solve_impl(const Teuchos::Ptr<MultiVecAdapter<Vector>> X,
                 const Teuchos::Ptr<const MultiVecAdapter<Vector>> B) const;
  bool matrixShapeOK_impl() const;

  /**
   * "Trans": "NOTRANS" or "TRANS"; "IsContiguous"; and the options of MFS by their names (mfs::option_names):
   * "backend", "threads", "tolerance", ... as strings, numbers or flags.
   */
  void setParameters_impl(const Teuchos::RCP<Teuchos::ParameterList>& parameterList);
  Teuchos::RCP<const Teuchos::ParameterList> getValidParameters_impl() const;
  bool loadA_impl(EPhase current_phase);

  /// The rows of the gathered matrix.
  mfs::CsrView<mfs_dtype> view() const;
  EDistribution distribution() const { return is_contiguous_ ? ROOTED : CONTIGUOUS_AND_ROOTED; }
  /// Runs `work` on rank 0. Throws std::runtime_error on all ranks where it throws.
  template <class Work>
  void on_root(const char* phase, const Work& work) const;

  typedef Kokkos::DefaultHostExecutionSpace HostSpaceType;
  typedef Kokkos::View<local_ordinal_type*, HostSpaceType> host_ordinal_type_array;
  typedef Kokkos::View<mfs_type*, HostSpaceType> host_value_type_array;
  typedef Kokkos::View<mfs_type**, Kokkos::LayoutLeft, HostSpaceType> host_solve_array_t;

  host_value_type_array values_;
  host_ordinal_type_array columns_, offsets_;
  mutable host_solve_array_t x_, b_;
  mfs::Options options_;
  mutable std::unique_ptr<mfs::BasicSolver<mfs_dtype>> solver_;  // on rank 0
  bool transposed_, is_contiguous_;
};

template <>
struct solver_traits<MFS> {
#ifdef HAVE_TEUCHOS_COMPLEX
  typedef Meta::make_list6<float, double, Kokkos::complex<float>, Kokkos::complex<double>,
                           std::complex<float>, std::complex<double>>
      supported_scalars;
#else
  typedef Meta::make_list2<float, double> supported_scalars;
#endif
};

template <typename Scalar, typename LocalOrdinal, typename ExecutionSpace>
struct solver_supports_matrix<MFS, KokkosSparse::CrsMatrix<Scalar, LocalOrdinal, ExecutionSpace>> {
  static const bool value = true;
};

}  // namespace Amesos2

#endif  // AMESOS2_MFS_DECL_HPP
