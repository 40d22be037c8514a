#include "plan/block_schedule.hpp"

#include <algorithm>

namespace mfs {

namespace {

// In entries that a solve reads; some tenths of a nanosecond each. What a front costs beside its own:
constexpr Offset kFront = 200;
// Levels with less are not worth a list: threads wait some microseconds for each other.
constexpr Offset kList = 20'000;
// A block with more is worked on by several threads.
constexpr Offset kLargeBlock = 100'000;
// Each thread finds so many groups, so that they end at about the same time.
constexpr Offset kGroups = 4;

class BlockScheduleMaker {
 public:
  BlockScheduleMaker(const SymbolicPlan& plan, int threads)
      : plan_(plan), triangle_(plan.triangle), threads_(threads) {
    for (Vertex b = 0; b < triangle_.blocks(); ++b) {
      entries_.push_back(0);
      for_fronts_of(b, [&](Vertex f) { entries_[b] += entries_of(f); });
    }
  }

  BlockSchedule make() {
    for (Vertex k = 0; k < triangle_.levels(); ++k)
      add_level(triangle_.level_begin[k], triangle_.level_begin[k + 1]);
    end_chain();
    make_lists();
    return std::move(made_);
  }

 private:
  Offset entries_of(Vertex f) const {
    const Offset p = plan_.pivots(f), b = plan_.border_rows(f);
    const Vertex begin = plan_.pivot_begin[f], end = plan_.pivot_begin[f + 1];
    return kFront + p * (p + 2 * b) + triangle_.by_row.begin[end] - triangle_.by_row.begin[begin];
  }
  template <class Visit>
  void for_fronts_of(Vertex b, const Visit& visit) const {
    for (Vertex k = triangle_.block_begin[b]; k < triangle_.block_begin[b + 1]; ++k)
      visit(triangle_.front[k]);
  }
  bool is_large(Vertex b) const { return threads_ > 1 && entries_[b] > kLargeBlock; }

  // Levels with little to do wait for those behind them; all of them do for one thread.
  void add_level(Vertex begin, Vertex end) {
    Offset small = 0;
    bool has_large = false;
    for (Vertex b = begin; b < end; ++b) {
      has_large |= is_large(b);
      if (!is_large(b)) small += entries_[b];
    }
    if (threads_ == 1 || (!has_large && small < kList)) {
      chain_.end = end;
      return;
    }
    end_chain();
    chain_ = {end, end};
    BlockSchedule::Step step;
    cut(begin, end, small / (kGroups * threads_), step);
    std::vector<Vertex> fronts;
    for (Vertex b = begin; b < end; ++b) {
      if (is_large(b)) for_fronts_of(b, [&](Vertex f) { fronts.push_back(f); });
    }
    std::sort(fronts.begin(), fronts.end());
    step.depths = make_schedule(plan_, fronts, threads_);
    made_.steps.push_back(std::move(step));
  }

  // The small blocks among these, neighbours together until there are enough entries.
  void cut(Vertex begin, Vertex end, Offset enough, BlockSchedule::Step& step) const {
    BlockSchedule::Group next{begin, begin};
    Offset entries = 0;
    const auto close = [&](Vertex from) {
      if (next.end > next.begin) step.groups.push_back(next);
      next = {from, from};
      entries = 0;
    };
    for (Vertex b = begin; b < end; ++b) {
      if (is_large(b)) {
        close(b + 1);
        continue;
      }
      next.end = b + 1;
      entries += entries_[b];
      if (entries > enough) close(b + 1);
    }
    close(end);
  }

  void end_chain() {
    if (chain_.end == chain_.begin) return;
    BlockSchedule::Step step;
    step.groups.push_back(chain_);
    made_.steps.push_back(std::move(step));
  }

  void make_lists() {
    const auto steps = static_cast<Vertex>(made_.steps.size());
    for (Vertex s = 0; s < steps; ++s) {
      add_lists(s, made_.lists[0]);
      add_lists(steps - 1 - s, made_.lists[1]);
    }
  }
  void add_lists(Vertex s, std::vector<BlockSchedule::List>& lists) const {
    const BlockSchedule::Step& step = made_.steps[s];
    const auto depths = static_cast<Vertex>(step.depths.size());
    if (!step.groups.empty()) lists.push_back({s, -1, false});
    for (Vertex d = 0; d < depths; ++d) lists.push_back({s, d, false});
    for (Vertex d = depths - 1; d >= 0; --d) lists.push_back({s, d, true});
  }

  const SymbolicPlan& plan_;
  const BlockTriangle& triangle_;
  const int threads_;
  std::vector<Offset> entries_;  // by block
  BlockSchedule::Group chain_{0, 0};
  BlockSchedule made_;
};

}  // namespace

BlockSchedule make_block_schedule(const SymbolicPlan& plan, int threads) {
  if (plan.triangle.empty()) return {};
  return BlockScheduleMaker(plan, threads).make();
}

}  // namespace mfs
