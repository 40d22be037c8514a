// Numbers of several systems that are reckoned with at the same time, a *lane* for each system. `V` holds one
// real number of each lane: a vector of the host's, or, where a thread works for one lane, one plain
// number. An array of lanes has number after number, and of each the real parts of all its lanes, then the
// imaginary parts; kLanes is the distance between parts.
//
//     entry 0: Re, lanes 0 1 2 ... | Im, lanes 0 1 2 ... || entry 1: Re ... | Im ... || ...
//
// The code is for any compiler and any space: files for Kokkos' spaces include Kokkos before this.
#pragma once

#include <cmath>
#include <type_traits>

#include "ordering/types.hpp"

#ifdef KOKKOS_FORCEINLINE_FUNCTION
#define MFS_LANES_OF_SPACES
#define MFS_LANES KOKKOS_FORCEINLINE_FUNCTION
#else
#define MFS_LANES inline __attribute__((always_inline))
#endif

namespace mfs::lanes {

/// What V is made of, the V of the same lanes in double precision, and what depends on it. This one is for
/// one lane; host_lanes.cpp has that of vectors.
template <class V>
struct LaneTraits {
  using Real = V;
  using Wide = double;
  static MFS_LANES V read(const Real* from) { return *from; }
  static MFS_LANES void write(const V& value, Real* to) { *to = value; }
  static MFS_LANES Wide widen(const V& value) { return value; }
  static MFS_LANES V narrow(const Wide& value) { return static_cast<V>(value); }
  static MFS_LANES V root(const V& value) { return sqrt(value); }
};

template <class V>
MFS_LANES V every_lane(typename LaneTraits<V>::Real value) {
  return V{} + value;
}
template <class V>
MFS_LANES V larger(const V& a, const V& b) {
  return a > b ? a : b;
}
template <class V>
MFS_LANES V size_of(const V& a) {
  return a < 0 ? -a : a;
}

template <class V>
struct RealLanes {
  static constexpr int kParts = 1;
  V value;

  MFS_LANES void subtract_product(const RealLanes& a, const RealLanes& b) { value -= a.value * b.value; }
  MFS_LANES void multiply(const RealLanes& a) { value *= a.value; }
  MFS_LANES void scale(const V& factor) { value *= factor; }
  MFS_LANES void add(const RealLanes& a) { value += a.value; }
  MFS_LANES void subtract(const RealLanes& a) { value -= a.value; }
  MFS_LANES RealLanes inverse() const { return {1 / value}; }
  /// A bound of the magnitude, at most twice as large.
  MFS_LANES V bound() const { return size_of(value); }
  MFS_LANES V magnitude() const { return size_of(value); }
};

template <class V>
struct ComplexLanes {
  static constexpr int kParts = 2;
  V re, im;

  MFS_LANES void subtract_product(const ComplexLanes& a, const ComplexLanes& b) {
    re -= a.re * b.re;
    re += a.im * b.im;
    im -= a.re * b.im;
    im -= a.im * b.re;
  }
  MFS_LANES void multiply(const ComplexLanes& a) {
    const V product = re * a.re - im * a.im;
    im = re * a.im + im * a.re;
    re = product;
  }
  MFS_LANES void scale(const V& factor) {
    re *= factor;
    im *= factor;
  }
  MFS_LANES void add(const ComplexLanes& a) {
    re += a.re;
    im += a.im;
  }
  MFS_LANES void subtract(const ComplexLanes& a) {
    re -= a.re;
    im -= a.im;
  }
  MFS_LANES ComplexLanes inverse() const {
    const V size = bound(), unit = 1 / size, x = re * unit, y = im * unit, squared = x * x + y * y;
    return {x / squared * unit, -y / squared * unit};
  }
  MFS_LANES V bound() const { return size_of(re) + size_of(im); }
  // Squares of the parts may be out of range where the magnitude is not.
  MFS_LANES V magnitude() const {
    const V x = size_of(re), y = size_of(im), most = larger(x, y), least = x + y - most;
    const V ratio = most > 0 ? least / most : least;
    return most * LaneTraits<V>::root(1 + ratio * ratio);
  }
};

/// Numbers of the kind of the matrix and those in double precision, and arrays of lanes of them.
template <class V, int parts, int lanes>
struct LaneKind {
  using Vector = V;
  using Traits = LaneTraits<V>;
  using Real = typename LaneTraits<V>::Real;
  using Wide = typename LaneTraits<V>::Wide;
  using Number = std::conditional_t<parts == 1, RealLanes<V>, ComplexLanes<V>>;
  using WideNumber = std::conditional_t<parts == 1, RealLanes<Wide>, ComplexLanes<Wide>>;
  static constexpr Offset kStep = static_cast<Offset>(parts) * lanes;  // from number to number
  static constexpr int kParts = parts;
  static constexpr int kLanes = lanes;

  static MFS_LANES Number load(const Real* from) {
    if constexpr (parts == 1) {
      return {Traits::read(from)};
    } else {
      return {Traits::read(from), Traits::read(from + lanes)};
    }
  }
  static MFS_LANES void store(const Number& number, Real* to) {
    if constexpr (parts == 1) {
      Traits::write(number.value, to);
    } else {
      Traits::write(number.re, to);
      Traits::write(number.im, to + lanes);
    }
  }
  static MFS_LANES WideNumber widen(const Number& number) {
    if constexpr (parts == 1) {
      return {Traits::widen(number.value)};
    } else {
      return {Traits::widen(number.re), Traits::widen(number.im)};
    }
  }
  static MFS_LANES Number narrow(const WideNumber& number) {
    if constexpr (parts == 1) {
      return {Traits::narrow(number.value)};
    } else {
      return {Traits::narrow(number.re), Traits::narrow(number.im)};
    }
  }
};

}  // namespace mfs::lanes
