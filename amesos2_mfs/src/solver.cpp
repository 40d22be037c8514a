// Amesos2::MFS for every pair of types that Amesos2_MFS.hpp names.
#include "solver_def.hpp"

#include "Amesos2_MFS.hpp"

namespace Amesos2 {

#define AMESOS2_MFS_INSTANTIATE(LO, GO, NODE) \
  template class MFS<Details::MfsTpetra<LO, GO, NODE>::Matrix, Details::MfsTpetra<LO, GO, NODE>::Vector>;
TPETRA_INSTANTIATE_LGN(AMESOS2_MFS_INSTANTIATE)
#ifdef HAVE_AMESOS2_EPETRA
template class MFS<Details::MfsEpetra::Matrix, Details::MfsEpetra::Vector>;
#endif

Teuchos::RCP<const Teuchos::ParameterList> mfs_valid_parameters() {
  return mfs::amesos2::valid_parameters();
}

}  // namespace Amesos2
