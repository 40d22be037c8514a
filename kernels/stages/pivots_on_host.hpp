// What a factorization in the memory of a device did to the pivots, on the host: brought once per
// factorization that is asked about them.
#pragma once

#include <cstddef>
#include <vector>

#include "kernels/stages/front_store.hpp"

namespace mfs {

template <class Scalar>
class PivotsOnHost {
 public:
  void forget() { known_ = false; }
  /// `to_host(to, from, bytes)` copies, `wait()` waits for the copies.
  template <class S, class Value, class Copy, class Wait>
  void bring(const FrontStore<S, Value>& from, const Copy& to_host, const Wait& wait) {
    if (known_) return;
    const Offset n = from.n;
    local_row_.resize(static_cast<std::size_t>(n));
    shift_.resize(static_cast<std::size_t>(n));
    to_host(local_row_.data(), from.local_row, n * static_cast<Offset>(sizeof(Vertex)));
    to_host(shift_.data(), from.shift, n * static_cast<Offset>(sizeof(Scalar)));
    wait();
    known_ = true;
  }
  Vertex local_row(Vertex position) const { return local_row_[static_cast<std::size_t>(position)]; }
  Scalar shift(Vertex position) const { return shift_[static_cast<std::size_t>(position)]; }

 private:
  bool known_ = false;
  std::vector<Vertex> local_row_;
  std::vector<Scalar> shift_;
};

}  // namespace mfs
