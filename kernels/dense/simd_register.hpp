// What the kernels for small blocks and for few columns have of a vector register. Complex numbers are pairs
// of real ones there. The functions are inlined into callers that are compiled for one kind of processor
// (kernels/runtime/simd_clones.hpp); no vector is passed by value.
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

#include "kernels/runtime/inlined.hpp"
#include "ordering/number_parts.hpp"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed between inlined functions only
#endif

namespace mfs::small {

/// A vector register of kBytes.
template <class Scalar, int kBytes>
struct Register {
  using Real = typename NumberParts<Scalar>::type;
  static constexpr int kParts = NumberParts<Scalar>::count;
  static constexpr int kLanes = kBytes / static_cast<int>(sizeof(Real));
  static constexpr int kRows = kLanes / kParts;  // of Scalar in a register
  typedef Real Vector __attribute__((vector_size(kBytes)));
  using Index = std::conditional_t<sizeof(Real) == 8, std::int64_t, std::int32_t>;
  typedef Index Places __attribute__((vector_size(kBytes)));

  static MFS_INLINE void load(const Real* from, Vector& to) { std::memcpy(&to, from, kBytes); }
  static MFS_INLINE void store(const Vector& from, Real* to) { std::memcpy(to, &from, kBytes); }
  static MFS_INLINE void exchange_pairs(const Vector& from, Vector& to) {
#ifdef __clang__
    for (int i = 0; i < kLanes; ++i) to[i] = from[i ^ 1];
#else
    Places places;
    for (int i = 0; i < kLanes; ++i) places[i] = i ^ 1;
    to = __builtin_shuffle(from, places);
#endif
  }
  /// Times i: (x, y) becomes (-y, x).
  static MFS_INLINE void turn(const Vector& from, Vector& to) {
    Vector sign = {};  // for a compiler that does not unroll the loop, and warns
    for (int i = 0; i < kLanes; ++i) sign[i] = static_cast<Real>(i % 2 == 0 ? -1 : 1);
    exchange_pairs(from, to);
    to *= sign;
  }
  /// x *= factor, of which there are kParts parts.
  static MFS_INLINE void multiply(const Real* factor, Vector& x) {
    if constexpr (kParts == 1) {
      x *= factor[0];
    } else {
      Vector turned;
      turn(x, turned);
      x = x * factor[0] + turned * factor[1];
    }
  }
  /// to -= x * factor.
  static MFS_INLINE void subtract(const Vector& x, const Real* factor, Vector& to) {
    to -= x * factor[0];
    if constexpr (kParts == 2) {
      Vector turned;
      turn(x, turned);
      to -= turned * factor[1];
    }
  }
};

}  // namespace mfs::small
