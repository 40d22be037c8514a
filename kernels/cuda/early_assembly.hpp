// Segments whose contribution blocks lie in the memory of the host are assembled before it is their turn
// (plan/segments.hpp), beside the kernels of those before them: they wait for the link, and need few threads.
#pragma once

#include <memory>
#include <vector>

#include "kernels/cuda/segment_copies.hpp"

namespace mfs::cuda {

class EarlyAssembly {
 public:
  /// `plan` must outlive this.
  explicit EarlyAssembly(const SegmentPlan& plan)
      : plan_(plan),
        stream_(Stream::Priority::low),
        factors_(std::make_unique<Event[]>(plan.segments.size())),
        contribution_(std::make_unique<Event[]>(plan.segments.size())) {
    for (Vertex t = 0; t < static_cast<Vertex>(plan.segments.size()); ++t) {
      if (plan.is_assembled_early(t)) segments_.push_back(t);
    }
  }

  /// Where so many segments are done in `main`, begins those that may be assembled then. Calls factors(t,
  /// stream), which assembles [P; L] and U, and contribution(t, stream).
  template <class Factors, class Contribution>
  void begin(Vertex done, const Stream& main, SegmentCopies& copies, const Factors& factors,
             const Contribution& contribution) {
    if (done == 0) next_ = 0;
    bool waits = false;
    for (; next_ < segments_.size() && plan_.segments[segments_[next_]].assembled_after == done; ++next_) {
      const Vertex t = segments_[next_];
      if (!waits) {
        done_.record(main);
        stream_.wait_for(done_);
        waits = true;
      }
      copies.begin_factor(t, stream_);
      factors(t, stream_);
      factors_[t].record(stream_);
      contribution(t, stream_);
      contribution_[t].record(stream_);
    }
  }
  /// `main` waits for what was assembled of segment t, which is one of these.
  void join_factors(Vertex t, const Stream& main) const { main.wait_for(factors_[t]); }
  void join_contribution(Vertex t, const Stream& main) const { main.wait_for(contribution_[t]); }

  /// After a failure.
  void drain() noexcept { stream_.drain(); }

 private:
  const SegmentPlan& plan_;
  Stream stream_;
  Event done_;
  std::unique_ptr<Event[]> factors_, contribution_;  // by segment
  std::vector<Vertex> segments_;                     // those that are assembled early, ascending
  std::size_t next_ = 0;                             // of them
};

}  // namespace mfs::cuda
