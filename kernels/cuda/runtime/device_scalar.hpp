// Numbers as device code sees them: std::complex has no device functions, Kokkos::complex has, and the same
// layout.
#pragma once

#include <complex>

#include <Kokkos_Core.hpp>

#include "kernels/runtime/scalars.hpp"

namespace mfs {

namespace cuda {

using mfs::DeviceScalar;

/// The value itself, or a NaN whose other bits say nothing: operations hand those on, and some bits are
/// marks.
template <class Real>
__device__ std::enable_if_t<std::is_floating_point_v<Real>, Real> without_payload(Real value) {
  return value == value ? value : static_cast<Real>(__longlong_as_double(0x7ff8000000000000ll));
}
template <class Real>
__device__ Kokkos::complex<Real> without_payload(const Kokkos::complex<Real>& value) {
  return {without_payload(value.real()), without_payload(value.imag())};
}

/// The value of another lane of the warp.
template <class Real>
__device__ std::enable_if_t<std::is_floating_point_v<Real>, Real> shuffle(Real value, int lane) {
  return __shfl_sync(0xffffffffu, value, lane);
}
template <class Real>
__device__ Kokkos::complex<Real> shuffle(const Kokkos::complex<Real>& value, int lane) {
  return {shuffle(value.real(), lane), shuffle(value.imag(), lane)};
}

/// The sum over groups of `Lanes` neighbouring lanes, with every lane, added in the same order always.
template <int Lanes, class Real>
__device__ std::enable_if_t<std::is_floating_point_v<Real>, Real> group_sum(Real value) {
#pragma unroll
  for (int step = Lanes / 2; step > 0; step /= 2) value += __shfl_xor_sync(0xffffffffu, value, step);
  return value;
}
template <int Lanes, class Real>
__device__ Kokkos::complex<Real> group_sum(const Kokkos::complex<Real>& value) {
  return {group_sum<Lanes>(value.real()), group_sum<Lanes>(value.imag())};
}

}  // namespace cuda
}  // namespace mfs
