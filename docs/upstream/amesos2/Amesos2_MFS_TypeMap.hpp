// Scalars of Amesos2 as numbers of MFS, and as numbers of the arrays that Amesos2 hands over.
#ifndef AMESOS2_MFS_TYPEMAP_HPP
#define AMESOS2_MFS_TYPEMAP_HPP

#include <Kokkos_Complex.hpp>
#include <complex>

#include "Amesos2_TypeMap.hpp"

namespace Amesos2 {

template <class, class>
class MFS;

// type: of the arrays; dtype: of mfs::BasicSolver. They have the same layout.
template <>
struct TypeMap<MFS, float> {
  typedef float type;
  typedef float dtype;
};
template <>
struct TypeMap<MFS, double> {
  typedef double type;
  typedef double dtype;
};

#ifdef HAVE_TEUCHOS_COMPLEX
template <>
struct TypeMap<MFS, std::complex<float>> {
  typedef Kokkos::complex<float> type;
  typedef std::complex<float> dtype;
};
template <>
struct TypeMap<MFS, std::complex<double>> {
  typedef Kokkos::complex<double> type;
  typedef std::complex<double> dtype;
};
template <>
struct TypeMap<MFS, Kokkos::complex<float>> {
  typedef Kokkos::complex<float> type;
  typedef std::complex<float> dtype;
};
template <>
struct TypeMap<MFS, Kokkos::complex<double>> {
  typedef Kokkos::complex<double> type;
  typedef std::complex<double> dtype;
};
#endif  // HAVE_TEUCHOS_COMPLEX

}  // namespace Amesos2

#endif  // AMESOS2_MFS_TYPEMAP_HPP
