// The executor in a space, for the file that compiles it and for tests of single spaces.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "kernels/lanes/space_lanes.hpp"
#include "kernels/lanes/team_kernel.hpp"
#include "kernels/space/space.hpp"
#include "ordering/number_parts.hpp"

namespace mfs::lanes {

/// Threads that work at the same time on each of a device's processors, which has registers for so many of
/// SolveByTeams.
constexpr Offset kThreadsAtOnce = 512, kThreadsOfProcessor = 2048;
/// Tasks of a level for each thread of a team, in the mean. Fewer threads wait less for each other; chain:91
/// took 3.4 us a system with 128 threads, 4.1 with 256 and 4.2 with 64 (`perf_batch`, H100, 2026-11-25).
constexpr Offset kTasksOfThread = 4;

template <class Exec, class Scalar>
class SpaceLanesIn final : public SpaceLanes<Scalar> {
  using Real = typename NumberParts<Scalar>::type;
  static constexpr int kParts = NumberParts<Scalar>::count;
  using Teams = SolveByTeams<Exec, LaneKind<Real, kParts, 1>>;
  using Arena = typename Space<Exec>::Arena;

 public:
  /// `threads`: of a team; 0: as many as the levels occupy, one on the host.
  SpaceLanesIn(const LaneProgram& program, const LevelSchedule& levels, const LaneRules& rules, Offset nrhs,
               Offset count, Offset most_bytes, int threads = 0)
      : nrhs_(nrhs),
        values_(program.pattern->num_entries),
        threads_(threads > 0 ? threads : threads_for(levels)) {
    copy_program(program, levels);
    kernel_.rules = rules;
    const TeamProgram& p = kernel_.p;
    kernel_.at = TeamArrays(p.n, p.value_begin ? program.pattern->nnz() : 0, p.entries, nrhs, kParts);
    const Offset of_team = kernel_.at.numbers * kReal + threads_ * kDouble;
    const Offset staged = kOnHost<Exec> ? 0 : bytes_of(values_ + 2 * p.n * nrhs);
    const Offset of_system = kOutcome + staged;
    const Offset room = std::min(most_bytes, kMostBytes) - program_->bytes() - kAlignment;
    if (room < of_team + of_system && !kOnHost<Exec>)
      throw OutOfMemory(MemorySpace::device,
                        static_cast<std::size_t>(most_bytes - room + of_team + of_system),
                        static_cast<std::size_t>(most_bytes));
    capacity_ = std::clamp<Offset>(count, 1, kMostSystems);
    teams_ = std::clamp<Offset>(std::min(threads_at_once() / threads_, room / 2 / of_team), 1, capacity_);
    capacity_ = std::clamp<Offset>((room - teams_ * of_team) / of_system, 1, capacity_);
    ArenaLayout layout;
    const Offset arrays = layout.add(teams_ * kernel_.at.numbers * kReal),
                 of_threads = layout.add(teams_ * threads_ * kDouble),
                 outcome = layout.add(capacity_ * kOutcome);
    arena_ = std::make_unique<Arena>(layout.total());
    kernel_.arrays = arena_->template at<Real>(arrays);
    kernel_.of_threads = arena_->template at<double>(of_threads);
    kernel_.outcome = arena_->template at<LaneOutcome>(outcome);
  }

  Offset capacity() const override { return capacity_; }
  Offset nrhs() const override { return nrhs_; }
  Offset bytes() const override {
    return arena_->bytes() + program_->bytes() + (staging_ ? staging_->bytes() : 0);
  }

  void solve(const LaneSystems<Scalar>& systems, bool resident, void* stream, LaneOutcome* outcome) override {
    if (resident) {
      Space<Exec>::require_reachable(systems.values, "values");
      Space<Exec>::require_reachable(systems.b, "b");
      Space<Exec>::require_reachable(systems.x, "x");
      queue_.follow(stream);
    }
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
  // Numbers of systems are 32-bit numbers there.
  static constexpr Offset kMostSystems = Offset{1} << 20, kMostBytes = Offset{1} << 40;
  // What alignment of three arrays may add.
  static constexpr Offset kAlignment = 3 * kRegionAlignment;
  static constexpr Offset kReal = sizeof(Real), kDouble = sizeof(double), kOutcome = sizeof(LaneOutcome);

  static Offset bytes_of(Offset count) { return count * static_cast<Offset>(sizeof(Scalar)); }
  static int threads_for(const LevelSchedule& levels) {
    if (kOnHost<Exec>) return 1;
    const Offset tasks = levels.level_begin[levels.factor_levels] / levels.factor_levels;
    int threads = kSliceTasks;
    while (threads * kTasksOfThread < tasks && 2 * threads <= static_cast<int>(kMostTeamThreads))
      threads *= 2;
    return threads;
  }
  Offset threads_at_once() const {
    const auto all = static_cast<Offset>(queue_.exec().concurrency());
    return kOnHost<Exec> ? all : all * kThreadsAtOnce / kThreadsOfProcessor;
  }

  // The program in the memory of the space.
  void copy_program(const LaneProgram& program, const LevelSchedule& levels) {
    TeamProgram& to = kernel_.p;
    const ScalarProgram& made = program.program;
    const Pattern& pattern = *program.pattern;
    to.n = made.n, to.entries = static_cast<Vertex>(made.entries());
    to.factor_levels = levels.factor_levels, to.levels = levels.levels;
    std::vector<Vertex> slot(made.row.size(), -1);
    for (std::size_t k = 0; k < made.place.size(); ++k) slot[made.place[k]] = static_cast<Vertex>(k);
    std::vector<Offset> value_begin, value_of;
    values_by_slot(pattern, value_begin, value_of);
    const auto for_all = [&](const auto& each) {
      each(made.row_of, to.row_of), each(made.column_of, to.column_of);
      each(made.pivot, to.pivot), each(slot, to.slot);
      each(levels.level_begin, to.level_begin), each(levels.tasks, to.tasks);
      each(levels.products, to.products);
      each(value_begin, to.value_begin), each(value_of, to.value_of);
      each(pattern.offsets, to.matrix_begin), each(pattern.columns, to.matrix_column);
      each(program.slot_scale, to.slot_scale), each(program.row_scale, to.row_scale);
      each(program.column_scale, to.column_scale);
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
      pointer = array.empty() ? nullptr : place;
    });
    queue_.wait();
  }
  // Empty where value k is slot k.
  static void values_by_slot(const Pattern& pattern, std::vector<Offset>& begin,
                             std::vector<Offset>& values) {
    if (pattern.slot_of_entry.empty()) return;
    begin.resize(static_cast<std::size_t>(pattern.nnz() + 2));
    values.resize(pattern.slot_of_entry.size());
    for (const Offset slot : pattern.slot_of_entry) ++begin[slot + 2];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (std::size_t k = 0; k < values.size(); ++k)
      values[begin[pattern.slot_of_entry[k] + 1]++] = static_cast<Offset>(k);
    begin.pop_back();
  }

  void solve_part(const LaneSystems<Scalar>& systems, LaneOutcome* outcome) {
    kernel_.callers = {reinterpret_cast<const Real*>(systems.values),
                       systems.values_stride * kParts,
                       reinterpret_cast<const Real*>(systems.b),
                       reinterpret_cast<Real*>(systems.x),
                       systems.ldb * kParts,
                       systems.ldx * kParts,
                       systems.b_stride * kParts,
                       systems.x_stride * kParts,
                       static_cast<int>(systems.count),
                       static_cast<int>(nrhs_)};
    static_assert(kOnHost<Exec> || sizeof(Teams) <= 384, "Kokkos waits for launches of more");
    const Offset teams = std::min(teams_, systems.count);
    Kokkos::parallel_for(
        "mfs::lanes", typename Teams::Policy(queue_.exec(), static_cast<int>(teams), threads_, 1), kernel_);
    queue_.to_host(outcome, kernel_.outcome, systems.count * kOutcome);
    queue_.wait();
  }

  // Arrays of the host by way of the space, without the gaps in them.
  void solve_staged(const LaneSystems<Scalar>& systems, LaneOutcome* outcome) {
    const Offset n = kernel_.p.n, values = values_, vectors = n * nrhs_;
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

  const Offset nrhs_, values_;  // of a system, as the caller has them
  const int threads_;           // of a team
  typename Space<Exec>::Queue queue_;
  Teams kernel_{};
  Offset teams_ = 0, capacity_ = 0;
  std::unique_ptr<Arena> program_, arena_, staging_;
  std::vector<Scalar> solutions_;
};

}  // namespace mfs::lanes
