// The portable executor in Kokkos' HIP space, compiled by hip_test.cmake. Nothing of it has run on a device.
#include "kernels/portable/stages.hpp"

namespace mfs::portable {

using Hip = Kokkos::Experimental::HIP;
static_assert(!kOnHost<Hip> && std::is_same_v<DenseOf<Hip, double>, OwnDense<double>>);
template class PortableStages<Hip, double, double>;
template class PortableStages<Hip, Kokkos::complex<float>, Kokkos::complex<double>>;

}  // namespace mfs::portable
