#include "all_ranks.hpp"

#include <chrono>
#include <exception>
#include <iostream>
#include <thread>

namespace distributed {
namespace {

constexpr std::chrono::seconds kGrace{3};

}  // namespace

AllRanks::AllRanks(MPI_Comm comm) {
  MPI_Comm_dup(comm, &comm_);
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &size_);
}

AllRanks::~AllRanks() {
  MPI_Comm_free(&comm_);
}

void AllRanks::run(const std::function<void()>& work) const {
  bool failed = true;
  std::string text = "unknown exception";
  try {
    work();
    failed = false;
  } catch (const ErrorOnAllRanks&) {
    throw;  // of a check inside `work`: the others have it too
  } catch (const std::exception& e) {
    text = e.what();
  } catch (...) {
  }
  const int first = first_failing(failed, text);
  if (first == size_) return;
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, first, comm_);
  text.resize(static_cast<std::size_t>(length));
  MPI_Bcast(text.data(), length, MPI_CHAR, first, comm_);
  throw ErrorOnAllRanks("rank " + std::to_string(first) + ": " + text);
}

/// The lowest failing rank, or the number of ranks.
int AllRanks::first_failing(bool failed, const std::string& text) const {
  const int mine = failed ? rank_ : size_;
  int first = size_;
  MPI_Request request;
  MPI_Iallreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm_, &request);
  if (!failed) {
    MPI_Wait(&request, MPI_STATUS_IGNORE);
    return first;
  }
  const auto end = std::chrono::steady_clock::now() + kGrace;
  for (int done = 0;;) {
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done) return first;
    if (std::chrono::steady_clock::now() > end) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::cerr << "mfs_distributed: rank " << rank_ << ": " << text << std::endl;
  MPI_Abort(comm_, 1);
  return rank_;
}

}  // namespace distributed
