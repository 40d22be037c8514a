#include "kernels/cuda/segment_copies.hpp"

#include <algorithm>

namespace mfs::cuda {

SegmentCopies::SegmentCopies(const SegmentPlan& plan, Offset entry_bytes)
    : plan_(plan),
      entry_bytes_(entry_bytes),
      memory_((plan.host_entries + plan.leaving_entries) * entry_bytes),
      done_(std::make_unique<Event[]>(plan.segments.size())),
      moved_(std::make_unique<Event[]>(plan.segments.size())) {}

void SegmentCopies::begin_factor(Vertex t, const Stream& main) {
  if (t == 0) last_ = -1;
  const Vertex first = plan_.segments[t].leaves_first;
  if (first > 0) main.wait_for(moved_[first - 1]);
}

void SegmentCopies::end_factor(Vertex t, const Stream& main, const void* storage) {
  const auto of_others = [](const LeavingBlock& block, Vertex from) { return block.from < from; };
  const auto blocks = std::lower_bound(plan_.leaving.begin(), plan_.leaving.end(), t, of_others);
  const auto end = std::lower_bound(blocks, plan_.leaving.end(), t + 1, of_others);
  if (blocks == end) return;
  done_[t].record(main);
  stream_.wait_for(done_[t]);
  for (auto block = blocks; block != end; ++block) {
    stream_.to_host(memory_.at<char>(block->host * entry_bytes_),
                    static_cast<const char*>(storage) + block->place * entry_bytes_,
                    block->entries * entry_bytes_);
  }
  moved_[t].record(stream_);
  last_ = t;
}

void SegmentCopies::end_factorization(const Stream& main) const {
  if (last_ >= 0) main.wait_for(moved_[last_]);
}

void SegmentCopies::begin_solve(const Stream& main) {
  begun_.record(main);
}

void SegmentCopies::begin_forward(Vertex t, const Stream& main, void* storage, bool transposed) {
  const Segment& segment = plan_.segments[t];
  if (!segment.comes()) return;
  stream_.wait_for(segment.forward_after < 0 ? begun_ : done_[segment.forward_after]);
  if (segment.backward_after < 0) {  // it stays for the other pass
    come_whole(t, storage);
  } else {
    come(t, transposed ? Side::upper : Side::lower, storage);
  }
  moved_[t].record(stream_);
  main.wait_for(moved_[t]);
}

void SegmentCopies::begin_backward(Vertex t, const Stream& main, void* storage, bool transposed) {
  const Segment& segment = plan_.segments[t];
  if (!segment.comes() || segment.backward_after < 0) return;
  stream_.wait_for(done_[segment.backward_after]);
  come(t, transposed ? Side::lower : Side::upper, storage);
  moved_[t].record(stream_);
  main.wait_for(moved_[t]);
}

void SegmentCopies::come_whole(Vertex t, void* storage) const {
  const Segment& segment = plan_.segments[t];
  stream_.to_device(static_cast<char*>(storage) + segment.solve_place * entry_bytes_,
                    memory_.at<char>(segment.host * entry_bytes_), segment.entries * entry_bytes_);
}

void SegmentCopies::come(Vertex t, Side side, void* storage) const {
  const Segment& segment = plan_.segments[t];
  const SideBlocks& all = plan_.side(side);
  char* const to = static_cast<char*>(storage) + segment.solve_place * entry_bytes_;
  const char* const from = memory_.at<char>(segment.host * entry_bytes_);
  for (std::size_t i = all.begin[t]; i < all.begin[t + 1]; ++i) {
    const SegmentBlock& block = all.blocks[i];
    const Offset begin = block.begin * entry_bytes_, pitch = block.ld * entry_bytes_;
    if (block.columns == 1) {
      stream_.to_device(to + begin, from + begin, block.rows * entry_bytes_);
    } else {
      stream_.copy_columns(to + begin, pitch, from + begin, pitch, block.rows * entry_bytes_,
                           static_cast<Vertex>(block.columns));
    }
  }
}

}  // namespace mfs::cuda
