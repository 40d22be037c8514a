// What direct solvers of the host have in common as perf_host measures them: the rows of the matrix with
// indices of their kind, vectors in the memory of the host only.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "perf/candidate.hpp"

namespace mfs::perf {

template <class Index>
class HostPeer : public Candidate {
 public:
  /// `system` must outlive it.
  explicit HostPeer(const System& system)
      : system_(system),
        offsets_(system.a.offsets.begin(), system.a.offsets.end()),
        indices_(system.a.column_indices.begin(), system.a.column_indices.end()),
        x_(system.b.size()) {}
  void read_solution(int columns, double* x) override { std::copy_n(x_.data(), system_.a.n * columns, x); }
  std::int64_t caller_bytes(int) const override { return 0; }

 protected:
  Index n() const { return static_cast<Index>(system_.a.n); }
  // Solvers in C want numbers without const, and only read them.
  double* values() const { return const_cast<double*>(system_.a.values.data()); }
  double* right_hand_sides() const { return const_cast<double*>(system_.b.data()); }
  static Facts facts_of(const std::string& version) {
    Facts facts;
    facts.version = version;
    facts.vectors = "host";
    return facts;
  }

  const System& system_;
  std::vector<Index> offsets_, indices_;
  std::vector<double> x_;
};

}  // namespace mfs::perf
