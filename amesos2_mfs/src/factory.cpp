// Amesos2::create and Amesos2::query with the name MFS added.
//
// The other names go to create_installed: Amesos2's own factory, included a second time with `create` and the
// helpers around it under other names. It is a true copy of whatever is installed, and names that nobody here
// has heard of work.
#include "Amesos2_MFS.hpp"

#include <dlfcn.h>

#include <Amesos2_Details_LinearSolverFactory_decl.hpp>
#include <Amesos2_Details_LinearSolverFactory_def.hpp>

#undef AMESOS2_FACTORY_HPP
#define create create_installed
#define create_solver_with_supported_type create_installed_solver_with_supported_type
#define throw_no_scalar_support_exception throw_no_installed_scalar_support_exception
#define throw_no_matrix_support_exception throw_no_installed_matrix_support_exception
#define handle_solver_scalar_type_support handle_installed_solver_scalar_type_support
#define handle_solver_matrix_and_type_support handle_installed_solver_matrix_and_type_support
#include <Amesos2_Factory.hpp>
#undef create
#undef create_solver_with_supported_type
#undef throw_no_scalar_support_exception
#undef throw_no_matrix_support_exception
#undef handle_solver_scalar_type_support
#undef handle_solver_matrix_and_type_support

extern "C" void amesos2_mfs_anchor() {}

namespace Amesos2 {
namespace {

bool is_mfs(const std::string& name) {
  const std::string lower = tolower(name);
  return lower == "mfs" || lower == "amesos2_mfs";
}

template <class Matrix, class Vector>
Teuchos::RCP<Solver<Matrix, Vector>> make(const std::string& name, const Teuchos::RCP<const Matrix>& a,
                                          const Teuchos::RCP<Vector>& x,
                                          const Teuchos::RCP<const Vector>& b) {
  if (!is_mfs(name)) return create_installed<Matrix, Vector>(name, a, x, b);
  if (a.is_null()) throw std::invalid_argument("MFS: create was given no matrix");
  return Teuchos::rcp(new MFS<Matrix, Vector>(a, x, b));
}

/// Amesos2's own query, which the weak one below hides. Null where Trilinos is linked statically; then the
/// weak one is not used either.
bool query_installed(const std::string& name) {
  using Query = bool (*)(Details::MfsName);
  const auto installed = reinterpret_cast<Query>(dlsym(RTLD_NEXT, Details::kMfsQuerySymbol));
  return installed != nullptr && installed(name);
}

}  // namespace

// NOLINTBEGIN(performance-unnecessary-value-param): the signatures are Amesos2's.
__attribute__((weak, visibility("default"))) bool query(Details::MfsName name) {
  return is_mfs(name) || query_installed(name);
}
__attribute__((weak, visibility("default"))) bool query(const char* name) {
  return query(std::string(name));
}

#define AMESOS2_MFS_DEFINE(...)                                                                       \
  template <>                                                                                         \
  Teuchos::RCP<Solver<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>>                                      \
  create<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(                                                   \
      Details::MfsName name, const Teuchos::RCP<const __VA_ARGS__::Matrix> A,                         \
      const Teuchos::RCP<__VA_ARGS__::Vector> X, const Teuchos::RCP<const __VA_ARGS__::Vector> B) {   \
    return make<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(name, A, X, B);                             \
  }                                                                                                   \
  template <>                                                                                         \
  Teuchos::RCP<Solver<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>>                                      \
  create<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(                                                   \
      const char* name, const Teuchos::RCP<const __VA_ARGS__::Matrix> A,                              \
      const Teuchos::RCP<__VA_ARGS__::Vector> X, const Teuchos::RCP<const __VA_ARGS__::Vector> B) {   \
    return make<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(name, A, X, B);                             \
  }                                                                                                   \
  template <>                                                                                         \
  Teuchos::RCP<Solver<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>>                                      \
  create<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(Details::MfsName name,                             \
                                                   const Teuchos::RCP<const __VA_ARGS__::Matrix> A) { \
    return make<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(name, A, Teuchos::null, Teuchos::null);     \
  }
#define AMESOS2_MFS_DEFINE_TPETRA(LO, GO, NODE) AMESOS2_MFS_DEFINE(Details::MfsTpetra<LO, GO, NODE>)

TPETRA_INSTANTIATE_LGN(AMESOS2_MFS_DEFINE_TPETRA)
#ifdef HAVE_AMESOS2_EPETRA
AMESOS2_MFS_DEFINE(Details::MfsEpetra)
#endif
// NOLINTEND(performance-unnecessary-value-param)

// Trilinos' own libraries reach `create` from Details::LinearSolver, as a rule. Where they are linked with
// -Bsymbolic-functions, as all of Ubuntu's are, their calls stay inside; but they take virtual tables from
// the program, and so come to the functions here.
#define AMESOS2_MFS_LINEAR_SOLVERS(LO, GO, NODE)                                         \
  template class Details::LinearSolverFactory<Tpetra::MultiVector<double, LO, GO, NODE>, \
                                              Tpetra::Operator<double, LO, GO, NODE>, double>;
TPETRA_INSTANTIATE_LGN(AMESOS2_MFS_LINEAR_SOLVERS)
#ifdef HAVE_AMESOS2_EPETRA
template class Details::LinearSolverFactory<Epetra_MultiVector, Epetra_Operator, double>;
#endif

}  // namespace Amesos2
