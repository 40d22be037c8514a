// The executor in a space, for the file that compiles it and for tests of single spaces.
#pragma once

#include <algorithm>
#include <vector>

#include "kernels/lanes/space_kernels.hpp"
#include "kernels/lanes/space_lanes.hpp"
#include "kernels/space/space.hpp"
#include "ordering/number_parts.hpp"

namespace mfs::lanes {

/// Lanes of a group: neighbours on a device, one on the host, where neighbours are no faster.
template <class Exec>
constexpr int kSpaceLanes = kOnHost<Exec> ? 1 : 32;

/// A kernel that goes from column to column waits for memory most of the time. Teams of so few threads find
/// their places on all processors of a device where there are few systems.
constexpr unsigned kFewThreads = 32, kManyThreads = 128;

/// Where arrays lie, for so many groups of lanes.
template <class Real, int kParts, int kLanes>
struct SpaceLayout {
  SpaceLayout(const ProgramView& program, Offset parts, Offset columns, Offset groups, Offset shares) {
    const Offset real = static_cast<Offset>(sizeof(Real)), lanes = groups * kLanes;
    const auto numbers = [&](Offset count) { return arena.add(count * kParts * lanes * real); };
    values = numbers(program.slots);
    factors = numbers(program.entries);
    for (Offset* vector : {&b, &r, &y, &x}) *vector = numbers(program.n * columns);
    largest = arena.add(shares * lanes * real);
    failed = arena.add(parts * lanes * real);
    open = arena.add(columns * lanes * real);
    share_errors = arena.add(columns * shares * lanes * static_cast<Offset>(sizeof(double)));
    errors = arena.add(columns * lanes * static_cast<Offset>(sizeof(double)));
  }
  ArenaLayout arena;
  Offset values, factors, b, r, y, x, largest, failed, open, share_errors, errors;
};

template <class Exec, class Scalar, int kLanes = kSpaceLanes<Exec>>
class SpaceLanesIn final : public SpaceLanes<Scalar> {
  using Real = typename NumberParts<Scalar>::type;
  static constexpr int kParts = NumberParts<Scalar>::count;
  static constexpr int kRows = kOnHost<Exec> ? 1 : 8;
  using Kind = LaneKind<Real, kParts, kLanes, kRows>;
  using Layout = SpaceLayout<Real, kParts, kLanes>;
  using Arena = typename Space<Exec>::Arena;

 public:
  SpaceLanesIn(const LaneProgram& program, const LaneRules& rules, Offset nrhs, Offset count,
               Offset most_bytes)
      : rules_(rules), nrhs_(nrhs), stage_begin_(program.program.stage_begin) {
    const ProgramView view = program.view();
    at_.shares = shares_for(view);
    at_.program = copied(program);
    at_.sizes = rules.pivots;
    const Offset staged = kOnHost<Exec> ? 0 : bytes_of(view.values + 2 * view.n * nrhs) * kLanes;
    const auto needed = [&](Offset groups) {
      return Layout(view, parts(), nrhs, groups, at_.shares).arena.total() + groups * staged;
    };
    const Offset room = std::min<Offset>(most_bytes, kMostBytes);
    Offset groups = std::max<Offset>(1, (std::min(count, kMostSystems) + kLanes - 1) / kLanes);
    if (needed(groups) > room) groups = std::max<Offset>(1, room / needed(1));
    if (needed(groups) > room && !kOnHost<Exec>)
      throw OutOfMemory(MemorySpace::device, static_cast<std::size_t>(needed(groups)),
                        static_cast<std::size_t>(room));
    place_arrays(view, groups);
  }

  Offset capacity() const override { return capacity_; }
  Offset nrhs() const override { return nrhs_; }
  Offset bytes() const override {
    return arena_->bytes() + program_->bytes() + (staging_ ? staging_->bytes() : 0);
  }

  void solve(const LaneSystems<Scalar>& systems, bool resident, void* stream, LaneOutcome* outcome) override {
    if (resident) queue_.follow(stream);
    for (Offset first = 0; first < systems.count; first += capacity_) {
      LaneSystems<Scalar> part = systems;
      part.count = std::min(capacity_, systems.count - first);
      part.values += first * systems.values_stride;
      part.b += first * systems.b_stride;
      part.x += first * systems.x_stride;
      if (resident || kOnHost<Exec>) {
        solve_part(part, outcome + first);
      } else {
        solve_staged(part, outcome + first);
      }
    }
  }

 private:
  // Numbers of systems are 32-bit numbers there. On the host, so few that they stay in the caches.
  static constexpr Offset kMostSystems = kOnHost<Exec> ? 128 : Offset{1} << 20;
  static constexpr Offset kMostBytes = Offset{1} << 40;

  int parts() const { return stage_begin_.back(); }
  static Offset bytes_of(Offset count) { return count * static_cast<Offset>(sizeof(Scalar)); }
  // Enough to keep a device busy with few systems.
  static int shares_for(const ProgramView& view) {
    return kOnHost<Exec> || view.slot_of_value ? 1 : static_cast<int>(std::clamp<Offset>(view.n / 32, 1, 32));
  }

  // The program in the memory of the space.
  ProgramView copied(const LaneProgram& program) {
    ProgramView view = program.view();
    const ScalarProgram& made = program.program;
    const Pattern& pattern = *program.pattern;
    const auto for_all = [&](const auto& each) {
      each(made.row_of, view.row_of), each(made.column_of, view.column_of);
      each(made.column_begin, view.column_begin), each(made.pivot, view.pivot), each(made.row, view.row);
      each(made.place, view.place), each(made.fill, view.fill), each(made.target, view.target);
      each(made.width, view.width), each(made.target_begin, view.target_begin);
      each(made.part_begin, view.part_begin), each(pattern.slot_of_entry, view.slot_of_value);
      each(pattern.offsets, view.matrix_begin), each(pattern.columns, view.matrix_column);
      each(program.slot_scale, view.slot_scale), each(program.row_scale, view.row_scale);
      each(program.column_scale, view.column_scale);
    };
    const auto size = [](const auto& array) { return static_cast<Offset>(array.size() * sizeof(array[0])); };
    ArenaLayout layout;
    for_all([&](const auto& array, const auto*&) { layout.add(size(array)); });
    program_ = std::make_unique<Arena>(layout.total());
    ArenaLayout places;
    for_all([&](const auto& array, auto& pointer) {
      using Entry = std::remove_const_t<std::remove_pointer_t<std::remove_reference_t<decltype(pointer)>>>;
      Entry* const place = program_->template at<Entry>(places.add(size(array)));
      queue_.to_space(place, array.data(), size(array));
      if (pointer) pointer = place;
    });
    queue_.wait();
    return view;
  }

  void place_arrays(const ProgramView& view, Offset groups) {
    const Layout layout(view, parts(), nrhs_, groups, at_.shares);
    arena_ = std::make_unique<Arena>(layout.arena.total());
    const auto reals = [&](Offset place) { return arena_->template at<Real>(place); };
    at_.values = reals(layout.values), at_.factors = reals(layout.factors);
    at_.b = reals(layout.b), at_.r = reals(layout.r), at_.y = reals(layout.y), at_.x = reals(layout.x);
    at_.largest = reals(layout.largest), at_.failed = reals(layout.failed), at_.open = reals(layout.open);
    at_.share_errors = arena_->template at<double>(layout.share_errors);
    at_.errors = arena_->template at<double>(layout.errors);
    capacity_ = groups * kLanes;
    const auto numbers = static_cast<std::size_t>(capacity_ * nrhs_);
    measured_.resize(numbers);
    before_.resize(numbers);
    flags_.resize(numbers);
  }

  template <unsigned threads, class Kernel>
  void launch(const char* label, Offset each, const Kernel& kernel) {
    static_assert(kOnHost<Exec> || sizeof(Kernel) <= 512, "Kokkos waits for launches of more");
    using Policy = Kokkos::RangePolicy<Exec, Kokkos::IndexType<Offset>, Kokkos::LaunchBounds<threads>>;
    Kokkos::parallel_for(label, Policy(queue_.exec(), 0, at_.groups * kLanes * each), kernel);
  }

  void solve_part(const LaneSystems<Scalar>& systems, LaneOutcome* outcome) {
    const CallersArrays<Real> arrays{reinterpret_cast<const Real*>(systems.values),
                                     systems.values_stride * kParts,
                                     reinterpret_cast<const Real*>(systems.b),
                                     reinterpret_cast<Real*>(systems.x),
                                     systems.ldb * kParts,
                                     systems.ldx * kParts,
                                     systems.b_stride * kParts,
                                     systems.x_stride * kParts,
                                     static_cast<int>(systems.count),
                                     static_cast<int>(nrhs_)};
    at_.groups = static_cast<int>((systems.count + kLanes - 1) / kLanes);
    const Offset lanes = static_cast<Offset>(at_.groups) * kLanes;
    const LaneKernel<Kind> base{at_};
    launch<kManyThreads>("mfs::lane_values", at_.shares, TakeValues<Kind>{base, arrays});
    for (std::size_t stage = 0; stage + 1 < stage_begin_.size(); ++stage) {
      const Vertex first = stage_begin_[stage];
      launch<kFewThreads>("mfs::lane_factor", stage_begin_[stage + 1] - first,
                          FactorLanes<Kind>{base, first});
    }
    launch<kManyThreads>("mfs::lane_failed", 1, GatherFailures<Kind>{base, parts()});
    launch<kManyThreads>("mfs::lane_rhs", at_.shares * nrhs_, TakeRhs<Kind>{base, arrays});
    launch<kFewThreads>("mfs::lane_solve", nrhs_, SubstituteLanes<Kind>{base, false});
    queue_.to_host(flags_.data(), at_.failed, lanes * static_cast<Offset>(sizeof(Real)));
    queue_.wait();
    for (Offset k = 0; k < systems.count; ++k) {
      outcome[k] = LaneOutcome();
      outcome[k].solved = flags_[static_cast<std::size_t>(k)] == 0;
    }
    refine(base, systems.count, lanes, outcome);
    std::fill(flags_.begin(), flags_.begin() + lanes, Real(0));
    for (Offset k = 0; k < systems.count; ++k)
      flags_[static_cast<std::size_t>(k)] = outcome[k].solved ? 1 : 0;
    send_flags(lanes);
    launch<kManyThreads>("mfs::lane_give", at_.shares * nrhs_, GiveSolutions<Kind>{base, arrays});
    queue_.wait();
  }

  void refine(const LaneKernel<Kind>& base, Offset count, Offset lanes, LaneOutcome* outcome) {
    std::fill(before_.begin(), before_.end(), kNotMeasured);
    for (int step = 0;; ++step) {
      launch<kManyThreads>("mfs::lane_error", at_.shares * nrhs_, MeasureLanes<Kind>{base});
      launch<kManyThreads>("mfs::lane_errors", nrhs_, GatherErrors<Kind>{base});
      queue_.to_host(measured_.data(), at_.errors, lanes * nrhs_ * static_cast<Offset>(sizeof(double)));
      queue_.wait();
      bool more = false;
      std::fill(flags_.begin(), flags_.end(), Real(0));
      for (Offset column = 0; column < nrhs_; ++column) {
        for (Offset k = 0; k < count; ++k) {
          const auto place = static_cast<std::size_t>(column * lanes + k);
          if (!stays_open(rules_, step, measured_[place], before_[place], outcome[k])) continue;
          flags_[place] = 1;
          more = true;
        }
      }
      if (!more) return;
      send_flags(lanes * nrhs_);
      launch<kFewThreads>("mfs::lane_correct", nrhs_, SubstituteLanes<Kind>{base, true});
    }
  }
  void send_flags(Offset count) {
    queue_.to_space(at_.open, flags_.data(), count * static_cast<Offset>(sizeof(Real)));
    queue_.wait();
  }

  // Arrays of the host by way of the space, without the gaps in them.
  void solve_staged(const LaneSystems<Scalar>& systems, LaneOutcome* outcome) {
    const Offset n = at_.program.n, values = at_.program.values, vectors = n * nrhs_;
    if (!staging_) staging_ = std::make_unique<Arena>(bytes_of((values + 2 * vectors) * capacity_));
    Scalar* const to_values = staging_->template at<Scalar>(0);
    Scalar *const to_b = to_values + values * capacity_, *const to_x = to_b + vectors * capacity_;
    const auto send = [&](const Scalar* from, Offset stride, Offset length, Offset count, Scalar* to) {
      const bool whole = stride == length;
      for (Offset k = 0; k < (whole ? 1 : count); ++k)
        queue_.to_space(to + k * length, from + k * stride, bytes_of(whole ? count * length : length));
    };
    send(systems.values, systems.values_stride, values, systems.count, to_values);
    if (systems.ldb == n) {
      send(systems.b, systems.b_stride, vectors, systems.count, to_b);
    } else {
      for (Offset k = 0; k < systems.count; ++k)
        send(systems.b + k * systems.b_stride, systems.ldb, n, nrhs_, to_b + k * vectors);
    }
    solve_part({systems.count, to_values, values, to_b, to_x, nrhs_, n, n, vectors, vectors}, outcome);
    solutions_.resize(static_cast<std::size_t>(vectors * capacity_));
    queue_.to_host(solutions_.data(), to_x, bytes_of(vectors * systems.count));
    queue_.wait();
    for (Offset k = 0; k < systems.count; ++k) {
      if (!outcome[k].solved) continue;
      for (Offset column = 0; column < nrhs_; ++column)
        std::copy_n(solutions_.data() + k * vectors + column * n, n,
                    systems.x + k * systems.x_stride + column * systems.ldx);
    }
  }

  const LaneRules rules_;
  const Offset nrhs_;
  const std::vector<Vertex> stage_begin_;  // into the parts of the program
  typename Space<Exec>::Queue queue_;
  SpaceArrays<Real> at_{};
  Offset capacity_ = 0;
  std::unique_ptr<Arena> program_, arena_, staging_;
  std::vector<double> measured_, before_;  // by column and lane
  std::vector<Real> flags_;
  std::vector<Scalar> solutions_;
};

}  // namespace mfs::lanes
