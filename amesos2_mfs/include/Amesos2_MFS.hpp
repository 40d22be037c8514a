// Makes "MFS" a name that Amesos2::create and Amesos2::query know.
//
//   #include <Amesos2_MFS.hpp>                                  // before any use of Amesos2::create
//   auto solver = Amesos2::create<MAT, MV>("MFS", A, X, B);     // "mfs" and "amesos2_mfs" are the same
//   solver->solve();
//
// Amesos2 has a fixed list of names and no registry. Its factory is a function template, though, so this
// header specialises create for the matrix types that Trilinos was built with (Tpetra with double values,
// Epetra where there is Epetra). The specialisations make an Amesos2::MFS for the names above and pass every
// other name to a copy of the installed factory. A type outside this list gets the factory's usual exception.
//
// Link the static library mfs_amesos2 (CMake target mfs::amesos2). Its definitions replace the ones that
// other translation units and Trilinos' own shared libraries have of the same functions, so that
// Trilinos::Details::getLinearSolver ("Amesos2", "MFS") and Ifpack2's AMESOS2 reach MFS too, also from units
// that never saw this header. It has to be linked into the program itself for that.
#pragma once

#include <TpetraCore_ETIHelperMacros.h>
#include <Amesos2.hpp>
#include <Tpetra_CrsMatrix.hpp>
#include <Tpetra_MultiVector.hpp>
#ifdef HAVE_AMESOS2_EPETRA
#include <Epetra_CrsMatrix.h>
#include <Epetra_MultiVector.h>
#endif

#include "Amesos2_MFS_decl.hpp"
#include "Amesos2_MFS_versions.hpp"

/// Calls to this are what brings the library's specialisations into a program.
extern "C" __attribute__((visibility("default"))) void amesos2_mfs_anchor();

namespace Amesos2 {

namespace Details {

/// The pairs of types that MFS is made for.
template <class LO, class GO, class Node>
struct MfsTpetra {
  using Matrix = Tpetra::CrsMatrix<double, LO, GO, Node>;
  using Vector = Tpetra::MultiVector<double, LO, GO, Node>;
};
#ifdef HAVE_AMESOS2_EPETRA
struct MfsEpetra {
  using Matrix = Epetra_CrsMatrix;
  using Vector = Epetra_MultiVector;
};
#endif

[[gnu::used]] static void (*const mfs_link)() = &amesos2_mfs_anchor;

}  // namespace Details

TPETRA_ETI_MANGLING_TYPEDEFS()

/// The argument is one of the pairs above. All forms with RCPs have to be specialised: an unspecialised one
/// would fix create's meaning for its types.
#define AMESOS2_MFS_DECLARE(...)                                                                        \
  template <>                                                                                           \
  __attribute__((visibility("default"))) Teuchos::RCP<Solver<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>> \
  create<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(                                                     \
      Details::MfsName name, const Teuchos::RCP<const __VA_ARGS__::Matrix> A,                           \
      const Teuchos::RCP<__VA_ARGS__::Vector> X, const Teuchos::RCP<const __VA_ARGS__::Vector> B);      \
  template <>                                                                                           \
  __attribute__((visibility("default"))) Teuchos::RCP<Solver<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>> \
  create<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(                                                     \
      const char* name, const Teuchos::RCP<const __VA_ARGS__::Matrix> A,                                \
      const Teuchos::RCP<__VA_ARGS__::Vector> X, const Teuchos::RCP<const __VA_ARGS__::Vector> B);      \
  template <>                                                                                           \
  __attribute__((visibility("default"))) Teuchos::RCP<Solver<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>> \
  create<__VA_ARGS__::Matrix, __VA_ARGS__::Vector>(Details::MfsName name,                               \
                                                   const Teuchos::RCP<const __VA_ARGS__::Matrix> A);
#define AMESOS2_MFS_DECLARE_TPETRA(LO, GO, NODE) AMESOS2_MFS_DECLARE(Details::MfsTpetra<LO, GO, NODE>)

TPETRA_INSTANTIATE_LGN(AMESOS2_MFS_DECLARE_TPETRA)
#ifdef HAVE_AMESOS2_EPETRA
AMESOS2_MFS_DECLARE(Details::MfsEpetra)
#endif

#undef AMESOS2_MFS_DECLARE_TPETRA
#undef AMESOS2_MFS_DECLARE

}  // namespace Amesos2
