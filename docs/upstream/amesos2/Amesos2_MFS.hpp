// MFS as a solver of Amesos2: Amesos2::create<Matrix, Vector>("MFS", A, X, B).
#ifndef AMESOS2_MFS_HPP
#define AMESOS2_MFS_HPP

#include "Amesos2_MFS_decl.hpp"
#ifndef HAVE_AMESOS2_EXPLICIT_INSTANTIATION
#include "Amesos2_MFS_def.hpp"
#endif

#endif  // AMESOS2_MFS_HPP
