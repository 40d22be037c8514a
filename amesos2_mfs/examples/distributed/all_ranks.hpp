// Errors of one rank become errors of all.
//
// A subdomain that is singular, or does not fit the memory, is an exception on one rank. The others would
// wait for that rank for ever in their next collective call. So each step of a distributed program runs
// inside such a check:
//
//   rank 0   work ----------------- check     every rank throws, with the text of the lowest failing rank
//   rank 1   work --- exception --- check
//
//   rank 0   work (waits in it for rank 1 ...
//   rank 1   work --- exception --- check     nobody comes: rank 1 says why and ends all with MPI_Abort
//
// The second case is FROSch's with two levels: its ranks talk to each other between the subdomain solvers.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include <mpi.h>

namespace distributed {

/// Thrown on all ranks at once: "rank 2: ...".
class ErrorOnAllRanks : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class AllRanks {
 public:
  /// Has a communicator of its own, so that its messages meet no others. Collective, as the destructor is.
  explicit AllRanks(MPI_Comm comm);
  ~AllRanks();
  AllRanks(const AllRanks&) = delete;
  AllRanks& operator=(const AllRanks&) = delete;

  /// Runs `work`. Throws ErrorOnAllRanks on every rank where `work` threw on one. Ends all ranks with exit
  /// code 1 where the others do not come to the check within three seconds. May be nested.
  void run(const std::function<void()>& work) const;

 private:
  int first_failing(bool failed, const std::string& text) const;

  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1;
};

}  // namespace distributed
