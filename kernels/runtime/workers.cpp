#include "kernels/runtime/workers.hpp"

#include <thread>

namespace mfs {

void Backoff::wait() {
  // Up to about 50 us of looking, more than what a tile's end or the next depth usually takes to come.
  constexpr int kSpins = 1000;
  if (looks_ < kSpins) {
    ++looks_;
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  } else {
    std::this_thread::yield();
  }
}

// The loop's data are read before it is known whether a tile is got. If it is, they were those of the ticket:
// the owner writes the next loop's data only when all tiles of this one are done, ours among them, and we
// count it as done after reading (the exchange releases, so the reads cannot come later). If it is not, they
// are not used.
bool PublishedLoop::take_tile() {
  std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
  for (;;) {
    const Vertex untaken = static_cast<Vertex>(static_cast<std::uint32_t>(ticket));
    if (untaken == 0) return false;
    const void* const body = body_.load(std::memory_order_relaxed);
    const Call call = call_.load(std::memory_order_relaxed);
    const Vertex tile = count_.load(std::memory_order_relaxed) - untaken;
    if (!ticket_.compare_exchange_weak(ticket, ticket - 1, std::memory_order_acq_rel,
                                       std::memory_order_acquire))
      continue;
    call(body, tile);
    left_.fetch_sub(1, std::memory_order_release);
    return true;
  }
}

bool Workers::help(std::size_t me) {
  bool helped = false;
  for (std::size_t k = 1; k < loops_.size() && !helped; ++k) {
    while (loops_[(me + k) % loops_.size()].take_tile()) helped = true;
  }
  return helped;
}

}  // namespace mfs
