// Follows a plan of segments on the host: factors leave for another array and come back as late or as early
// as the plan allows, and whatever it does not need any more becomes NaN at once.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "test/stages/list_interpreter.hpp"

namespace mfs::test {

/// When copies run that may run beside segments.
using Copies = ListInterpreter::Concurrent;

class SegmentInterpreter {
 public:
  SegmentInterpreter(const StageProblem<double>& problem, const SegmentPlan& segments,
                     const DeviceLimits& limits, Copies copies, bool assembles_early = true)
      : placed_(with_plan(problem, placed_by(segments, *problem.plan))),
        lists_(executable(make_device_plan(*placed_.plan, limits, segments))),
        in_solve_(with_plan(problem, solve_plan())),
        copies_(copies),
        interpreter_(placed_, lists_, copies, limits.waiting_tiles),
        solver_(in_solve_, lists_, copies, limits.waiting_tiles),
        host_(static_cast<std::size_t>(segments.host_entries + segments.leaving_entries), kNothing) {
    solver_.take_whole_fronts();
    if (assembles_early) interpreter_.assemble_early();
  }

  /// Calls visit(front, its blocks) for each front when its segments are done.
  template <class Visit>
  void factor(const Visit& visit) {
    left_ = 0;
    interpreter_.read_blocks_at([&](Vertex child) { return read_on_host(child); });
    interpreter_.factor([&](Vertex t) { leave_until(segments()[t].leaves_first); },
                        [&](Vertex t) {
                          visit_segment(t, visit);
                          if (copies_ == Copies::at_once) leave_until(t + 1);
                        });
    leave_until(count());
    std::vector<double>& region = solver_.storage();
    std::fill(region.begin(), region.end(), kNothing);
    for (const Segment& own : segments()) {
      if (own.stays()) std::copy_n(&interpreter_.storage()[own.place], own.entries, &region[own.solve_place]);
    }
    // The memory of the host lies behind the region.
    region.resize(static_cast<std::size_t>(lists_.segments.region_entries));
    region.insert(region.end(), host_.begin(), host_.end());
  }

  /// The factors of a front as they lie in the end: [P; L], U.
  FrontBlocks<double> left(Vertex f) {
    const Segment& own = segments()[lists_.segments.segment[f]];
    const SymbolicPlan& plan = *in_solve_.plan;
    const double* const from =
        own.comes() ? host_.data() + own.host - own.solve_place : solver_.storage().data();
    return {packed(from + plan.lower_begin[f], plan.rows(f), plan.pivots(f), plan.lower_ld(f)),
            packed(from + plan.upper_begin[f], plan.pivots(f), plan.border_rows(f), plan.pivots(f)),
            {}};
  }

  void solve(std::vector<double>& v) {
    next_ = 0;
    // What a solve has there of its own.
    const SegmentPlan& all = lists_.segments;
    std::fill_n(solver_.storage().begin() + all.spare_begin, all.spare_entries, kSpare);
    solver_.solve(v, [&](bool forward, std::size_t launch) {
      const Vertex i = static_cast<Vertex>(launch);
      if (forward) {
        come_forward(i);
      } else {
        if (i == 0) next_ = count() - 1;
        come_backward(count() - 1 - i);
      }
    });
    for (Offset i = 0; i < all.spare_entries; ++i)
      EXPECT_EQ(solver_.storage()[all.spare_begin + i], kSpare) << "factors where vectors are";
  }

  const DevicePlan& lists() const { return lists_; }

 private:
  static constexpr double kNothing = std::numeric_limits<double>::quiet_NaN(), kSpare = 17;

  static StageProblem<double> with_plan(StageProblem<double> problem, SymbolicPlan plan) {
    problem.plan = std::make_shared<SymbolicPlan>(std::move(plan));
    return problem;
  }
  // With the places of the memory of the host, behind the region.
  static DevicePlan executable(DevicePlan lists) {
    const SegmentPlan& all = lists.segments;
    for (std::size_t f = 0; f < lists.solve_lower.size(); ++f) {
      if (!all.solved_on_host(static_cast<Vertex>(f))) continue;
      lists.solve_lower[f] += all.region_entries;
      lists.solve_upper[f] += all.region_entries;
    }
    for (SolvePart& part : lists.solve) {
      part.where.lower = lists.solve_lower[part.front];
      part.where.upper = lists.solve_upper[part.front];
    }
    return lists;
  }
  SymbolicPlan solve_plan() const {
    SymbolicPlan plan = *placed_.plan;
    plan.lower_begin = lists_.solve_lower;
    plan.upper_begin = lists_.solve_upper;
    return plan;
  }
  const std::vector<Segment>& segments() const { return lists_.segments.segments; }
  Vertex count() const { return static_cast<Vertex>(segments().size()); }
  template <class Visit>
  void for_fronts(Vertex t, const Visit& visit) const {
    for (Vertex i = segments()[t].begin; i < segments()[t].end; ++i) visit(lists_.segments.order[i]);
  }

  template <class Visit>
  void visit_segment(Vertex t, const Visit& visit) {
    for (const BorderColumns& columns : lists_.segments.border_columns) {
      if (columns.segment == t) visit_columns(columns, visit);
    }
    for_fronts(t, [&](Vertex f) {
      if (segments()[t].divided) {
        const SymbolicPlan& plan = *placed_.plan;
        const double* const from = &interpreter_.storage()[plan.lower_begin[f]];
        done_[f] = {packed(from, plan.rows(f), plan.pivots(f), plan.lower_ld(f)), {}, {}};
      } else {
        visit(f, interpreter_.front(f));
        forget_children(f);
      }
    });
  }
  template <class Visit>
  void visit_columns(const BorderColumns& own, const Visit& visit) {
    const SymbolicPlan& plan = *placed_.plan;
    const Vertex f = own.front, p = plan.pivots(f), b = plan.border_rows(f), width = own.end - own.begin;
    const Offset ld = plan.contribution_ld(f), before = own.begin - p;
    const auto add = [](std::vector<double>& to, const std::vector<double>& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    const double* const storage = interpreter_.storage().data();
    add(done_[f].upper, packed(storage + own.upper + before * p, p, width, p));
    add(done_[f].contribution, packed(storage + own.contribution + before * ld, b, width, ld));
    if (own.end < plan.rows(f)) return;
    visit(f, done_[f]);
    forget_children(f);
  }

  void leave_until(Vertex end) {
    for (; left_ < end; ++left_) {
      for (const LeavingBlock& block : lists_.segments.leaving) {
        if (block.from == left_) leave(block.place, block.entries, block.host);
      }
    }
  }
  void leave(Offset place, Offset entries, Offset host) {
    double* const from = interpreter_.storage().data() + place;
    std::copy_n(from, entries, host_.data() + host);
    std::fill_n(from, entries, kNothing);
  }
  // Where a segment reads contribution blocks that have left.
  const double* read_on_host(Vertex child) const {
    const Offset place = lists_.segments.read_on_host[child];
    return place < 0 ? nullptr : host_.data() + place;
  }
  void forget_children(Vertex f) {
    const SymbolicPlan& plan = *placed_.plan;
    for (Vertex c = plan.child_begin[f]; c < plan.child_begin[f + 1]; ++c) {
      const Vertex child = plan.children[c], b = plan.border_rows(child);
      const Offset on_host = lists_.segments.read_on_host[child];
      double* const block = on_host < 0 ? interpreter_.storage().data() + plan.contribution_begin[child]
                                        : host_.data() + on_host;
      if (b > 0) std::fill_n(block, static_cast<Offset>(b) * plan.contribution_ld(child), kNothing);
    }
  }

  void come_whole(Vertex t) {
    const Segment& own = segments()[t];
    std::copy_n(host_.data() + own.host, own.entries, solver_.storage().data() + own.solve_place);
  }
  void come(Vertex t, Side side) {
    const Segment& own = segments()[t];
    const SideBlocks& all = lists_.segments.side(side);
    if (all.empty()) return come_whole(t);
    double* const to = solver_.storage().data() + own.solve_place;
    std::fill_n(to, own.entries, kNothing);
    for (std::size_t i = all.begin[t]; i < all.begin[t + 1]; ++i) {
      const SegmentBlock& block = all.blocks[i];
      for (Offset j = 0; j < block.columns; ++j)
        std::copy_n(host_.data() + own.host + block.begin + j * block.ld, block.rows,
                    to + block.begin + j * block.ld);
    }
  }
  // In the order of segments, all that may come before segment t is done with, or that one alone.
  void come_forward(Vertex t) {
    for (; next_ < count(); ++next_) {
      const Segment& own = segments()[next_];
      const bool may = own.forward_after < t && (next_ <= t || copies_ == Copies::at_once);
      if (!may) break;
      if (own.comes()) own.backward_after < 0 ? come_whole(next_) : come(next_, Side::lower);
    }
    EXPECT_GT(next_, t) << "a segment that does not come in time";
  }
  void come_backward(Vertex t) {
    for (; next_ >= 0; --next_) {
      const Segment& own = segments()[next_];
      const bool is_there = !own.comes() || own.backward_after < 0;
      const bool may = is_there || (own.backward_after > t && (next_ >= t || copies_ == Copies::at_once));
      if (!may) break;
      if (!is_there) come(next_, Side::upper);
    }
    EXPECT_LT(next_, t) << "a segment that does not come in time";
  }

  const StageProblem<double> placed_;
  const DevicePlan lists_;
  const StageProblem<double> in_solve_;
  const Copies copies_;
  ListInterpreter interpreter_, solver_;
  std::vector<double> host_;
  std::map<Vertex, FrontBlocks<double>> done_;  // of divided fronts, as they grow
  Vertex left_ = 0, next_ = 0;
};

}  // namespace mfs::test
