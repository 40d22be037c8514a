// Errors on every rank. The matrix lives on rank 0 only, so a failure there would leave the other ranks
// waiting in the next collective call. Every step of the adapter that can fail runs inside on_all_ranks: if
// any rank throws, all ranks throw the same class of exception with the same text and the same place.
#pragma once

#include <functional>

#include <Teuchos_Comm.hpp>

namespace mfs::amesos2 {

/// Runs `work` on this rank, then lets all ranks of `comm` agree. Where it threw on several ranks, the error
/// of the lowest one is thrown everywhere. Collective; with one rank it is a plain call.
///
/// Thrown on each rank: the class of mfs/error.hpp that was thrown (std::bad_alloc becomes mfs::OutOfMemory),
/// std::invalid_argument, or std::runtime_error for everything else.
void on_all_ranks(const Teuchos::Comm<int>& comm, const std::function<void()>& work);

}  // namespace mfs::amesos2
