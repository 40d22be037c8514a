// A complex number as two real ones, for code that works on their parts.
#pragma once

#include <complex>

namespace mfs {

/// Real numbers of type `type` that a number is made of, `count` of them.
template <class Scalar>
struct NumberParts {
  using type = Scalar;
  static constexpr int count = 1;
};
template <class Real>
struct NumberParts<std::complex<Real>> {
  using type = Real;
  static constexpr int count = 2;
};

template <class Real>
Real conjugated(Real value) {
  return value;
}
template <class Real>
std::complex<Real> conjugated(std::complex<Real> value) {
  return std::conj(value);
}

}  // namespace mfs
