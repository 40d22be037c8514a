// How the factors of segments (plan/segments.hpp) leave the device and come back, and how contribution blocks
// leave that are read in the memory of the host, in a stream of its own beside the kernels. Everything here
// can be recorded: it waits for events, never on the host.
#pragma once

#include <memory>

#include "kernels/cuda/runtime/device.hpp"
#include "plan/segments.hpp"

namespace mfs::cuda {

class SegmentCopies {
 public:
  /// Takes the page-locked memory. Throws std::bad_alloc, BackendError. `plan` must outlive this.
  SegmentCopies(const SegmentPlan& plan, Offset entry_bytes);

  /// In a factorization, around the work of segment t in `main`, whose region begins at `storage`.
  void begin_factor(Vertex t, const Stream& main);
  void end_factor(Vertex t, const Stream& main, const void* storage);
  /// `main` waits for the last copy.
  void end_factorization(const Stream& main) const;

  /// In a solve, before and after that of segment t in `main`: forward, then backward. The transposed system
  /// takes the upper side forward.
  void begin_solve(const Stream& main);
  void begin_forward(Vertex t, const Stream& main, void* storage, bool transposed);
  void begin_backward(Vertex t, const Stream& main, void* storage, bool transposed);
  void end_pass(Vertex t, const Stream& main) { done_[t].record(main); }

  /// Where entries of factors and contribution blocks that have left begin, for the host and the device.
  const void* host() const { return memory_.at<char>(0); }
  /// Of page-locked memory.
  Offset bytes() const { return memory_.bytes(); }
  /// After a failure.
  void drain() noexcept { stream_.drain(); }

 private:
  void come_whole(Vertex t, void* storage) const;
  void come(Vertex t, Side side, void* storage) const;

  const SegmentPlan& plan_;
  const Offset entry_bytes_;
  PinnedArena memory_;
  Stream stream_;
  Event begun_;
  std::unique_ptr<Event[]> done_, moved_;  // by segment: its work, its copy
  Vertex last_ = -1;                       // segment of which something leaves
};

}  // namespace mfs::cuda
