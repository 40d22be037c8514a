#include "rank_gather.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

#include <Teuchos_CommHelpers.hpp>

namespace mfs::amesos2 {
namespace {

/// Message lengths are ints in MPI.
constexpr std::int64_t kMessageBytes = std::int64_t{1} << 30;

void send(const Teuchos::Comm<int>& comm, const char* data, std::int64_t bytes, int destination) {
  for (std::int64_t done = 0; done < bytes; done += kMessageBytes)
    comm.send(static_cast<int>(std::min(kMessageBytes, bytes - done)), data + done, destination);
}

void receive(const Teuchos::Comm<int>& comm, char* data, std::int64_t bytes, int source) {
  for (std::int64_t done = 0; done < bytes; done += kMessageBytes)
    comm.receive(source, static_cast<int>(std::min(kMessageBytes, bytes - done)), data + done);
}

}  // namespace

RankGather::RankGather(Teuchos::RCP<const Teuchos::Comm<int>> comm, std::int64_t local_count)
    : comm_(std::move(comm)), counts_(comm_->getSize()) {
  const long long mine = local_count;
  std::vector<long long> all(counts_.size());
  Teuchos::gatherAll(*comm_, 1, &mine, static_cast<int>(all.size()), all.data());
  std::copy(all.begin(), all.end(), counts_.begin());
}

std::int64_t RankGather::total() const {
  return std::accumulate(counts_.begin(), counts_.end(), std::int64_t{0});
}

void RankGather::bytes_to_root(const char* local, char* all, std::size_t size) const {
  const auto bytes = [&](int rank) { return counts_[rank] * static_cast<std::int64_t>(size); };
  if (comm_->getRank() != 0) {
    send(*comm_, local, bytes(comm_->getRank()), 0);
    return;
  }
  std::copy_n(local, bytes(0), all);
  for (int rank = 1; rank < ranks(); ++rank) {
    all += bytes(rank - 1);
    receive(*comm_, all, bytes(rank), rank);
  }
}

void RankGather::bytes_from_root(const char* all, char* local, std::size_t size) const {
  const auto bytes = [&](int rank) { return counts_[rank] * static_cast<std::int64_t>(size); };
  if (comm_->getRank() != 0) {
    receive(*comm_, local, bytes(comm_->getRank()), 0);
    return;
  }
  std::copy_n(all, bytes(0), local);
  for (int rank = 1; rank < ranks(); ++rank) {
    all += bytes(rank - 1);
    send(*comm_, all, bytes(rank), rank);
  }
}

}  // namespace mfs::amesos2
