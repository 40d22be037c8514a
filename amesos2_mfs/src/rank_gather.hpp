// Pieces of an array, one per rank, brought to rank 0 in rank order and back.
//
//   rank 0: a b c      rank 1: d e      rank 2: f
//                  to_root
//   rank 0: a b c d e f
#pragma once

#include <cstdint>
#include <vector>

#include <Teuchos_Comm.hpp>
#include <Teuchos_RCP.hpp>

namespace mfs::amesos2 {

class RankGather {
 public:
  RankGather() = default;
  /// `local_count`: entries of this rank's piece. Collective.
  RankGather(Teuchos::RCP<const Teuchos::Comm<int>> comm, std::int64_t local_count);

  int ranks() const { return static_cast<int>(counts_.size()); }
  std::int64_t count(int rank) const { return counts_[rank]; }
  /// Entries of all pieces together.
  std::int64_t total() const;

  /// `local`: this rank's piece; `all`: room for total() entries on rank 0, ignored elsewhere. Collective.
  template <class T>
  void to_root(const T* local, T* all) const {
    bytes_to_root(reinterpret_cast<const char*>(local), reinterpret_cast<char*>(all), sizeof(T));
  }
  /// The way back.
  template <class T>
  void from_root(const T* all, T* local) const {
    bytes_from_root(reinterpret_cast<const char*>(all), reinterpret_cast<char*>(local), sizeof(T));
  }

 private:
  void bytes_to_root(const char* local, char* all, std::size_t size) const;
  void bytes_from_root(const char* all, char* local, std::size_t size) const;

  Teuchos::RCP<const Teuchos::Comm<int>> comm_;
  std::vector<std::int64_t> counts_;  ///< of every rank, on every rank
};

}  // namespace mfs::amesos2
