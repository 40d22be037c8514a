// Which coordinates may be chosen freely.
//
// A sparse LU of Phi_q^T (n x m, UMFPACK) picks for each constraint one coordinate in which it is strong: its
// pivot row. These are the dependent coordinates, the others, as many as degrees of freedom, the independent
// ones; then [Phi_q; U^T] with U^T picking the independent coordinates is invertible and as sparse as Phi_q.
//
// The choice is good while dependent coordinates do not move much more than the independent ones: its growth
// is the largest row of Phi_d^-1 Phi_i, with coordinates in their own scales, estimated by random signs.
#pragma once

#include <memory>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

class Partition {
 public:
  /// Chooses. `values`: of `position_q`, whose rows are assumed to be independent; `scale`: per coordinate.
  /// `threads` 0: all.
  Partition(const Pattern& position_q, const std::vector<double>& values, std::vector<double> scale,
            int threads);
  ~Partition();
  Partition(Partition&&) noexcept;
  Partition& operator=(Partition&&) noexcept;

  /// One flag per coordinate.
  const std::vector<char>& independent() const;
  /// Whether, for these values of Phi_q, the growth is much larger than it was when the choice was made.
  bool degraded(const std::vector<double>& values);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mfs::dae
