// Whether the factors of a plan lie on the device as a whole or in segments (plan/segments.hpp), decided by
// the plan and the bytes that there are. Definition of plan_factors for the files that instantiate it.
#pragma once

#include "kernels/cuda/cuda_factors_def.hpp"
#include "plan/segment_clock.hpp"

namespace mfs::cuda {

/// Of one matrix; copies share what has been planned.
template <class Value, class Scalar>
class FactorPlanner {
  using Made = CudaFactors<Value, Scalar>;
  using Stages = DeviceStages<DeviceScalar<Scalar>, DeviceScalar<Value>>;
  static constexpr Offset kEntry = static_cast<Offset>(sizeof(Scalar));

 public:
  FactorPlanner(std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern,
                const DeviceRoom& room)
      : plan_(std::move(plan)), pattern_(std::move(pattern)), room_(room) {}

  Planned<Factors<Value>> run() {
    take(plan_, std::make_shared<DevicePlan>(Stages::lists_for(*plan_)));
    small_rows_ = lists_->small_rows;
    solve_places_ = lists_->solve_places;
    for (const bool on_host : {true, false}) measure_rest(on_host);
    // So little is not worth a question, which would wait for the device to be there.
    constexpr Offset kLittle = Offset(1) << 28, kShare = 8;
    const Offset needed = bytes_.total();
    bool early = true;
    if (room_.limit > 0 || needed > kLittle) {
      const Offset available = available_bytes(room_.held);
      early = needed <= available / kShare;
      if (needed > available) divide(available);
    }
    return {bytes_,       flops_.done, movement_, [planner = *this]() mutable { return planner.make(); },
            flops_.steps, false,       early};
  }

 private:
  void take(std::shared_ptr<const SymbolicPlan> placed, std::shared_ptr<DevicePlan> lists) {
    bytes_ = Made::bytes_for(*placed, *pattern_, *lists);
    flops_ = count_flops(*placed, *lists, true);
    movement_ = Made::movement_of(*placed, *lists);
    placed_ = std::move(placed);
    lists_ = std::move(lists);
  }

  // All but the region and right-hand sides, at most: the lists of segments tell twice which tiles are
  // factored.
  void measure_rest(bool matrix_on_host) {
    lists_->matrix_on_host = matrix_on_host;
    const auto bytes_of = [](const auto& list) {
      return static_cast<Offset>(list.size() * sizeof(*list.data()));
    };
    constexpr Offset kRounding = 4096;
    const Offset row_place = plan_->n * static_cast<Offset>(sizeof(Vertex)) + plan_->num_fronts;
    beside_[matrix_on_host] = Made::bytes_for(*plan_, *pattern_, *lists_).other + bytes_of(lists_->steps) +
                              bytes_of(plan_->lower_begin) + bytes_of(plan_->upper_begin) +
                              bytes_of(plan_->contribution_begin) + row_place +
                              Stages::library_bytes(*lists_) + kRounding;
  }
  Offset beside(Vertex columns, bool matrix_on_host) const {
    return beside_[matrix_on_host] + Made::bytes_later(*plan_, columns);
  }

  Offset available_bytes(Offset held) const {
    const Offset free = free_memory() + held;
    return room_.limit > 0 ? std::min(free, room_.limit - counted_context()) : free;
  }

  // A limit is one for all that the process holds, code of kernels that have not been launched yet included.
  Offset counted_context() const {
    constexpr Offset kCodeToCome = Offset(64) << 20;
    return room_.limit > 0 ? bytes_of_context() + kCodeToCome : 0;
  }

  // For so many bytes of the device: with the matrix there, if that can be. Where no segments fit, placed_
  // becomes null, and bytes_ what would do.
  void divide(Offset available) {
    constexpr Offset kLeast = Offset(256) << 20, kShare = 64;
    constexpr double kClearly = 0.9;  // the clock errs by a tenth
    constexpr Offset kPart = 2;       // of the region, which vectors of many columns may have in a solve
    if (room_.limit == 0) available -= std::max(kLeast, available / kShare);  // the driver loads more later
    placed_ = nullptr;
    lists_ = nullptr;
    const auto segments_for = [&](Vertex columns, bool on_host) {
      const Offset entries = std::max<Offset>(available - beside(columns, on_host), 0) / kEntry;
      const Offset region = entries / kAlignment * kAlignment, spare = spare_for(columns);
      const bool too_many = columns > kFewColumns && spare > region / kPart;
      return too_many ? SegmentPlan() : make_segments(*plan_, region, spare, small_rows_);
    };
    const auto segments_beside = [&](bool on_host) {
      SegmentPlan segments = segments_for(kSolveColumns, on_host);
      return segments.empty() ? segments_for(kFewColumns, on_host) : segments;
    };
    bool on_host = false;  // the matrix
    SegmentPlan segments = segments_beside(on_host);
    // The room of the matrix is worth a look where contribution blocks would leave.
    if (segments.empty() || segments.blocks_out() > 0) {
      const SegmentClock clock(*plan_, Outside::memory);
      SegmentPlan roomier = segments_beside(true);
      on_host = !roomier.empty() && (segments.empty() || clock.seconds(roomier) + clock.seconds_of_matrix() <
                                                             kClearly * clock.seconds(segments));
      if (on_host) segments = std::move(roomier);
    }
    if (segments.empty()) {
      bytes_ = {};
      bytes_.other = least_region(*plan_, spare_for(kFewColumns), small_rows_) * kEntry +
                     beside(kFewColumns, true) + counted_context();
      return;
    }
    auto placed = std::make_shared<SymbolicPlan>(placed_by(segments, *plan_));
    auto lists = std::make_shared<DevicePlan>(Stages::lists_for(*placed, std::move(segments)));
    lists->matrix_on_host = on_host;
    placed->entry_target = {};
    placed->entry_row = {};
    take(std::move(placed), std::move(lists));
  }

  // Beside what bytes_ has of them already.
  Offset room_for_vectors() const {
    return room_.limit > 0 ? room_.limit - counted_context() - bytes_.total()
                           : std::numeric_limits<Offset>::max();
  }

  // Entries of the region for the vectors of so many columns.
  Offset spare_for(Vertex columns) const {
    DevicePlan counts;
    counts.border_places = static_cast<Offset>(plan_->border.size());
    counts.solve_places = solve_places_;
    return aligned((Made::spare_for(*plan_, counts, columns) + kEntry - 1) / kEntry);
  }

  // Once. Where there is less memory than there was for the plan, it is made anew for what is left.
  std::unique_ptr<Factors<Value>> make() {
    for (bool again = true;; again = false) {
      if (!placed_)
        throw OutOfMemory(MemorySpace::device, static_cast<std::size_t>(bytes_.total()),
                          static_cast<std::size_t>(available_bytes(0) + counted_context()));
      try {
        return std::make_unique<Made>(placed_, pattern_, std::move(*lists_), room_for_vectors());
      } catch (const OutOfMemory& error) {
        const bool is_short = error.space() == MemorySpace::device && error.needed() > error.available();
        if (!again || !is_short) throw;
      }
      divide(available_bytes(0));
    }
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  DeviceRoom room_;
  std::shared_ptr<const SymbolicPlan> placed_;  // plan_, or by segments
  std::shared_ptr<DevicePlan> lists_;
  NumericBytes bytes_;
  DeviceFlops flops_;
  Movement movement_;
  Offset beside_[2] = {0, 0};  // with the matrix on the device, on the host
  Offset solve_places_ = 0;
  Vertex small_rows_ = 0;
};

template <class Value, class Scalar>
Planned<Factors<Value>> plan_factors(std::shared_ptr<const SymbolicPlan> plan,
                                     std::shared_ptr<const Pattern> pattern, const DeviceRoom& room) {
  return FactorPlanner<Value, Scalar>(std::move(plan), std::move(pattern), room).run();
}

}  // namespace mfs::cuda
