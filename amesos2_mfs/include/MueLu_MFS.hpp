// MFS as the direct solver of MueLu's coarsest grid, also where MueLu's library keeps its calls of
// Amesos2::create inside (it is linked with -Bsymbolic-functions, as all of Ubuntu's are). Elsewhere
// Amesos2_MFS.hpp is enough.
//
//   #include <MueLu_MFS.hpp>          // in one unit of the program, before MueLu's other headers
//   parameters.set("coarse: type", "MFS");
#pragma once

#include "Amesos2_MFS.hpp"

#include <MueLu_Amesos2Smoother_def.hpp>

// The library makes such smoothers with the virtual table of the program, which holds the functions of this
// unit: they call what Amesos2_MFS.hpp has made of create.
#define MUELU_MFS_INSTANTIATE(LO, GO, NODE) \
  template class __attribute__((visibility("default"))) MueLu::Amesos2Smoother<double, LO, GO, NODE>;
TPETRA_ETI_MANGLING_TYPEDEFS()
TPETRA_INSTANTIATE_LGN(MUELU_MFS_INSTANTIATE)
#undef MUELU_MFS_INSTANTIATE
