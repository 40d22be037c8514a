// Kinds of numbers, and a number in double precision and back, as code for any execution space can reckon
// with it.
#pragma once

#include <cmath>
#include <complex>
#include <type_traits>

#include <Kokkos_Core.hpp>

#include "ordering/number_parts.hpp"

namespace mfs {

template <class Scalar>
struct RealOfTrait {
  using type = Scalar;
};
template <class Real>
struct RealOfTrait<std::complex<Real>> {
  using type = Real;
};
// std::complex has no device functions: device code uses Kokkos::complex, of the same layout.
template <class Real>
struct RealOfTrait<Kokkos::complex<Real>> {
  using type = Real;
};
/// float for float and complex<float>, double for the others.
template <class Scalar>
using RealOf = typename RealOfTrait<Scalar>::type;

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

template <class Scalar>
Scalar from_parts(double real, double imaginary) {
  if constexpr (std::is_same_v<Scalar, RealOf<Scalar>>) {
    (void)imaginary;
    return static_cast<Scalar>(real);
  } else {
    return Scalar(static_cast<RealOf<Scalar>>(real), static_cast<RealOf<Scalar>>(imaginary));
  }
}
template <class Scalar>
struct WideTrait {
  using type = double;
};
template <class Real>
struct WideTrait<std::complex<Real>> {
  using type = std::complex<double>;
};
/// The same kind of number, real or complex, in double precision: what sums are taken in.
template <class Scalar>
using Wide = typename WideTrait<Scalar>::type;

/// A number in double precision, as code for any execution space can reckon with it, and back. The parts of a
/// std::complex are read as the array that it is by definition: its functions are for the host only.
template <class Real>
KOKKOS_INLINE_FUNCTION std::enable_if_t<std::is_floating_point_v<Real>, double> widened(Real value) {
  return value;
}
template <class Real>
KOKKOS_INLINE_FUNCTION Kokkos::complex<double> widened(const std::complex<Real>& value) {
  const Real* parts = reinterpret_cast<const Real*>(&value);
  return {parts[0], parts[1]};
}
template <class Real>
KOKKOS_INLINE_FUNCTION Kokkos::complex<double> widened(const Kokkos::complex<Real>& value) {
  return {value.real(), value.imag()};
}
template <class Real>
KOKKOS_INLINE_FUNCTION void narrow(double value, Real& to) {
  to = static_cast<Real>(value);
}
template <class Real>
KOKKOS_INLINE_FUNCTION void narrow(const Kokkos::complex<double>& value, std::complex<Real>& to) {
  Real* parts = reinterpret_cast<Real*>(&to);
  parts[0] = static_cast<Real>(value.real());
  parts[1] = static_cast<Real>(value.imag());
}
template <class Real>
KOKKOS_INLINE_FUNCTION void narrow(const Kokkos::complex<double>& value, Kokkos::complex<Real>& to) {
  to = Kokkos::complex<Real>(static_cast<Real>(value.real()), static_cast<Real>(value.imag()));
}

/// a b, rounded. Compilers for devices join a product with the sum behind it, unless it is no product.
KOKKOS_FORCEINLINE_FUNCTION double rounded_product(double a, double b) {
#if defined(__CUDA_ARCH__) || defined(__HIP_DEVICE_COMPILE__)
  return std::fma(a, b, 0.0);
#else
  return a * b;
#endif
}

KOKKOS_INLINE_FUNCTION double magnitude(double value) {
  return std::abs(value);
}
KOKKOS_INLINE_FUNCTION double magnitude(float value) {
  return std::abs(static_cast<double>(value));
}
template <class Real>
double magnitude(const std::complex<Real>& value) {
  return std::abs(value);
}
template <class Real>
KOKKOS_INLINE_FUNCTION double magnitude(const Kokkos::complex<Real>& value) {
  return hypot(static_cast<double>(value.real()), static_cast<double>(value.imag()));
}

/// The same kind of number in single precision: what the factors of mixed precision are.
template <class Scalar>
using Narrow = std::conditional_t<std::is_same_v<Scalar, RealOf<Scalar>>, float, std::complex<float>>;

}  // namespace mfs
