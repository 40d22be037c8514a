// Numbers as device code sees them: std::complex has no device functions, Kokkos::complex has, and the same
// layout.
#pragma once

#include <complex>

#include <Kokkos_Core.hpp>

#include "kernels/front_store.hpp"

namespace mfs {

namespace cuda {

template <class Scalar>
struct DeviceScalarTrait {
  using type = Scalar;
};
template <class Real>
struct DeviceScalarTrait<std::complex<Real>> {
  using type = Kokkos::complex<Real>;
};
/// What Scalar is called in device code.
template <class Scalar>
using DeviceScalar = typename DeviceScalarTrait<Scalar>::type;

/// The sum over a warp, with every lane, added in the same order always.
template <class Real>
__device__ std::enable_if_t<std::is_floating_point_v<Real>, Real> warp_sum(Real value) {
  for (int step = 16; step > 0; step /= 2) value += __shfl_xor_sync(0xffffffffu, value, step);
  return value;
}
template <class Real>
__device__ Kokkos::complex<Real> warp_sum(const Kokkos::complex<Real>& value) {
  return {warp_sum(value.real()), warp_sum(value.imag())};
}

/// A load that does not look into the multiprocessor's own cache: what other blocks of the same kernel wrote.
__device__ inline double load_shared(const double* place) { return __ldcg(place); }
__device__ inline float load_shared(const float* place) { return __ldcg(place); }
template <class Real>
__device__ Kokkos::complex<Real> load_shared(const Kokkos::complex<Real>* place) {
  const Real* parts = reinterpret_cast<const Real*>(place);
  return {__ldcg(parts), __ldcg(parts + 1)};
}

}  // namespace cuda
}  // namespace mfs
