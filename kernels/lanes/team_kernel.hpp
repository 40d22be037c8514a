// One kernel that solves systems from the caller's values to his solutions, for any space of Kokkos. A team
// of threads solves one system after the other in memory of its own. Threads divide the tasks of each level
// among them (plan/level_schedule.hpp); what is computed for a system depends neither on how many there are
// nor on which team has it.
#pragma once

#include <Kokkos_Core.hpp>

#include "kernels/lanes/lane_steps.hpp"
#include "plan/level_schedule.hpp"

#ifndef MFS_LANES_OF_SPACES
#error "kernels/lanes/lane_numbers.hpp was included before Kokkos: its functions are for the host alone"
#endif

namespace mfs::lanes {

/// What a team needs of a program, in the memory of a space; names are those of ProgramView and
/// LevelSchedule.
struct TeamProgram {
  Vertex n, entries, factor_levels, levels;
  const Vertex *row_of, *column_of, *pivot;
  const Vertex* slot;  // by entry of the factors; -1: no product has reached it yet
  const Vertex* level_begin;
  const std::uint64_t *tasks, *products;
  const Offset *value_begin, *value_of;  // by slot: its values; null where value k is slot k
  const Offset* matrix_begin;
  const Vertex* matrix_column;
  const double *slot_scale, *row_scale, *column_scale;
};

/// Systems in arrays of the caller, in the memory of the space, and in real numbers.
template <class Real>
struct CallersArrays {
  const Real* values;
  Offset values_stride;
  const Real* b;
  Real* x;
  Offset ldb, ldx, b_stride, x_stride;
  int count, columns;
};

/// Where the arrays of a team begin in its memory, in real numbers. `values` is empty where those of the
/// caller serve; x has all columns.
struct TeamArrays {
  TeamArrays() = default;
  TeamArrays(Offset n, Offset slots, Offset entries, Offset columns, Offset step) {
    const auto add = [&](Offset count) {
      const Offset place = numbers;
      numbers += (count * step + kLine - 1) / kLine * kLine;
      return place;
    };
    values = add(slots), factors = add(entries);
    r = add(n), y = add(n), x = add(n * columns);
  }
  static constexpr Offset kLine = 32;
  Offset values = 0, factors = 0, r = 0, y = 0, x = 0, numbers = 0;
};

/// Threads of a team, at most, and such teams that a processor has registers for. With registers for three,
/// threads keep a part of theirs in memory, and poisson2d:32 takes 1.5 times as long (H100, 2026-11-25).
constexpr unsigned kMostTeamThreads = 256, kLargeTeamsAtOnce = 2;

template <class Exec, class Kind>
struct SolveByTeams {
  using Real = typename Kind::Real;
  using Number = typename Kind::Number;
  using Policy = Kokkos::TeamPolicy<Exec, Kokkos::IndexType<int>,
                                    Kokkos::LaunchBounds<kMostTeamThreads, kLargeTeamsAtOnce>>;
  using Member = typename Policy::member_type;
  using Numbers = OwnLanes<Kind>;
  static_assert(Kind::kLanes == 1, "arrays of the caller are read as those of a team");
  static constexpr int kParts = Kind::kParts;
  /// Numbers that a thread asks for before it needs the first.
  static constexpr int kAhead = 4;

  TeamProgram p;
  TeamArrays at;
  CallersArrays<Real> callers;
  LaneRules rules;
  Real* arrays;        // of all teams
  double* of_threads;  // likewise, one of each thread
  LaneOutcome* outcome;

  KOKKOS_INLINE_FUNCTION void operator()(const Member& member) const {
    const Team team{member, member.team_rank(), member.team_size(),
                    arrays + member.league_rank() * at.numbers};
    for (int system = member.league_rank(); system < callers.count; system += member.league_size())
      solve_system(team, system);
  }

 private:
  /// One of its threads, and the memory of all.
  struct Team {
    const Member& member;
    int thread, threads;
    Real* memory;
  };

  KOKKOS_INLINE_FUNCTION void solve_system(const Team& team, int system) const {
    const Real largest = take_values(team, system);
    run_levels(team, 0, p.factor_levels, team.memory + at.factors);
    LaneOutcome lane;
    lane.solved = most_of_team(team, has_tiny_pivot(team, largest)) == 0;
    for (int column = 0; column < callers.columns && lane.solved; ++column)
      solve_column(team, system, column, lane);
    for (int column = 0; column < callers.columns && lane.solved; ++column) give(team, system, column);
    if (team.thread == 0) outcome[system] = lane;
    team.member.team_barrier();
  }

  KOKKOS_FORCEINLINE_FUNCTION Numbers callers_values(int system) const {
    return {callers.values + system * callers.values_stride};
  }
  KOKKOS_FORCEINLINE_FUNCTION Numbers values_of(const Team& team, int system) const {
    if (p.value_begin) return {team.memory + at.values};
    return callers_values(system);
  }
  /// The entries of the factors before any product. Returns the largest scaled value.
  KOKKOS_INLINE_FUNCTION Real take_values(const Team& team, int system) const {
    if (p.value_begin) sum_values(team, system);
    const Numbers values = values_of(team, system);
    Real largest{};
    Vertex entry = team.thread;
    for (; entry + (kAhead - 1) * team.threads < p.entries; entry += kAhead * team.threads)
      take_entries<kAhead>(team, values, entry, largest);
    for (; entry < p.entries; entry += team.threads) take_entries<1>(team, values, entry, largest);
    return static_cast<Real>(most_of_team(team, largest));
  }
  template <int count>
  KOKKOS_FORCEINLINE_FUNCTION void take_entries(const Team& team, const Numbers& values, Vertex first,
                                                Real& largest) const {
    Number value[count];
    Vertex slot[count];
    for (int k = 0; k < count; ++k) slot[k] = p.slot[first + k * team.threads];
    for (int k = 0; k < count; ++k) {
      value[k] = Number{};
      if (slot[k] < 0) continue;
      value[k] = values.load(slot[k]);
      value[k].scale(static_cast<Real>(p.slot_scale[slot[k]]));
    }
    for (int k = 0; k < count; ++k) {
      Kind::store(value[k], team.memory + at.factors + (first + k * team.threads) * kParts);
      largest = larger(value[k].bound(), largest);
    }
  }
  KOKKOS_INLINE_FUNCTION void sum_values(const Team& team, int system) const {
    const Numbers from = callers_values(system);
    for (Offset slot = team.thread; slot < p.matrix_begin[p.n]; slot += team.threads) {
      Number sum{};
      for (Offset k = p.value_begin[slot]; k < p.value_begin[slot + 1]; ++k)
        sum.add(from.load(p.value_of[k]));
      Kind::store(sum, team.memory + at.values + slot * kParts);
    }
    team.member.team_barrier();
  }

  KOKKOS_FORCEINLINE_FUNCTION void run_levels(const Team& team, Vertex first, Vertex last, Real* out) const {
    run_levels_with(team.member, p.level_begin + first, last - first, p.tasks, p.products, team.thread,
                    team.threads, team.memory + at.factors, out);
  }
  /// The tasks of some levels; s and targets are in `out`. A thread reads what it does next before it waits
  /// for the others, as it waits long for what comes from afar.
  static KOKKOS_FORCEINLINE_FUNCTION void run_levels_with(const Member& member, const Vertex* level_begin,
                                                          Vertex levels, const std::uint64_t* tasks,
                                                          const std::uint64_t* products, int thread,
                                                          int threads, const Real* factors, Real* out) {
    Items items{level_begin, tasks,          products,       thread,        threads,
                0,           level_begin[0], level_begin[1], level_begin[2]};
    Item now{}, next{}, then{};
    items.find(now);
    items.read_products(now);
    items.find(next);
    while (levels > 0) {
      items.read_products(next);
      items.find(then);
      if (now.task) run_task(items, now, factors, out);
      if (now.ends_level) {
        member.team_barrier();
        --levels;
      }
      now = next;
      next = then;
    }
  }

  /// What a thread does next: a task, or none, with its first products.
  struct Item {
    std::uint64_t task;
    int in_slice;
    bool ends_level;
    std::uint64_t product[kAhead];
  };
  /// Finds the items of one thread, one after the other, whatever their level. In each round all threads have
  /// one, be it none, so that they come to each barrier at the same place.
  struct Items {
    const Vertex* level_begin;
    const std::uint64_t *tasks, *products;
    int thread, threads;
    Vertex level, round, end, next_end;

    KOKKOS_FORCEINLINE_FUNCTION void find(Item& item) {
      const Vertex place = round + thread;
      item.task = place < end ? tasks[place] : 0;
      item.in_slice = place % kSliceTasks;
      round += threads;
      item.ends_level = round >= end;
      if (!item.ends_level) return;
      round = end;
      end = next_end;
      next_end = level_begin[++level + 2];
    }
    KOKKOS_FORCEINLINE_FUNCTION const std::uint64_t* first_product(const Item& item) const {
      const auto row = static_cast<int>(item.task >> (Packed::kNumber + 1 + Packed::kCount));
      return products + (row * kSliceTasks + item.in_slice);
    }
    KOKKOS_FORCEINLINE_FUNCTION void read_products(Item& item) const {
      read(first_product(item), products_of(item.task), item.product);
    }
  };
  static KOKKOS_FORCEINLINE_FUNCTION int products_of(std::uint64_t task) {
    return static_cast<int>(task >> (Packed::kNumber + 1)) & ((1 << Packed::kCount) - 1);
  }
  static KOKKOS_FORCEINLINE_FUNCTION int number(std::uint64_t packed, int which) {
    return (static_cast<int>(packed >> (which * Packed::kNumber)) & ((1 << Packed::kNumber) - 1)) * kParts;
  }
  static KOKKOS_FORCEINLINE_FUNCTION void read(const std::uint64_t* from, int count, std::uint64_t* to) {
    if (count > 0) to[0] = from[0];
    if (count > 1) to[1] = from[kSliceTasks];
    if (count > 2) to[2] = from[2 * kSliceTasks];
    if (count > 3) to[3] = from[3 * kSliceTasks];
  }
  static KOKKOS_FORCEINLINE_FUNCTION void run_task(const Items& items, const Item& item, const Real* factors,
                                                   Real* out) {
    Real* const target = out + number(item.task, 0);
    Number sum = Kind::load(target);
    int left = products_of(item.task);
    subtract(item.product, left, factors, out, sum);
    const std::uint64_t* more = items.first_product(item);
    while (left > kAhead) {
      left -= kAhead;
      more += kAhead * kSliceTasks;
      std::uint64_t product[kAhead] = {};
      read(more, left, product);
      subtract(product, left, factors, out, sum);
    }
    if (item.task >> Packed::kNumber & 1) sum = sum.inverse();
    Kind::store(sum, target);
  }
  /// `left` of the products, if they are fewer than all. Their numbers are all asked for before one is
  /// needed.
  static KOKKOS_FORCEINLINE_FUNCTION void subtract(const std::uint64_t* product, int left,
                                                   const Real* factors, const Real* out, Number& sum) {
    Triple a{}, b{}, c{}, d{};
    if (left > 0) a.load(product[0], factors, out);
    if (left > 1) b.load(product[1], factors, out);
    if (left > 2) c.load(product[2], factors, out);
    if (left > 3) d.load(product[3], factors, out);
    if (left > 0) a.subtract_from(sum);
    if (left > 1) b.subtract_from(sum);
    if (left > 2) c.subtract_from(sum);
    if (left > 3) d.subtract_from(sum);
  }
  struct Triple {
    Number m, d, s;
    KOKKOS_FORCEINLINE_FUNCTION void load(std::uint64_t product, const Real* factors, const Real* out) {
      m = Kind::load(factors + number(product, 0));
      d = Kind::load(factors + number(product, 1));
      s = Kind::load(out + number(product, 2));
    }
    KOKKOS_FORCEINLINE_FUNCTION void subtract_from(Number& sum) {
      m.multiply(d);
      sum.subtract_product(m, s);
    }
  };

  /// Whether a pivot is noise. Any other may do, as every solution is measured.
  KOKKOS_INLINE_FUNCTION double has_tiny_pivot(const Team& team, Real largest) const {
    const Real tiny = largest * static_cast<Real>(rules.pivots.tiny);
    bool found = false;
    for (Vertex k = team.thread; k < p.n; k += team.threads) {
      const Number inverse = Kind::load(team.memory + at.factors + p.pivot[k] * kParts);
      found = found || !(1 / inverse.bound() > tiny);
    }
    return found ? 1 : 0;
  }

  KOKKOS_INLINE_FUNCTION void solve_column(const Team& team, int system, int column,
                                           LaneOutcome& lane) const {
    const Numbers values = values_of(team, system),
                  b{callers.b + system * callers.b_stride + column * callers.ldb}, r{team.memory + at.r};
    Real* const x = x_of(team, column);
    double error = kNotMeasured;
    for (int step = 0;; ++step) {
      substitute(team, step == 0 ? b : r, x, step > 0);
      const Share share{team.thread, team.threads};
      const double now =
          most_of_team(team, LaneSteps<Kind>::residual(p, values, b, x, team.memory + at.r, share));
      if (!stays_open(rules, step, now, error, lane)) return;
    }
  }
  KOKKOS_FORCEINLINE_FUNCTION Real* x_of(const Team& team, int column) const {
    return team.memory + at.x + static_cast<Offset>(column) * p.n * kParts;
  }

  /// x = the solution for what is in r, both by row and column of A, or x += that.
  KOKKOS_INLINE_FUNCTION void substitute(const Team& team, const Numbers& r, Real* x, bool add) const {
    Real* const y = team.memory + at.y;
    for (Vertex k = team.thread; k < p.n; k += team.threads) {
      Number value = r.load(p.row_of[k]);
      value.scale(static_cast<Real>(p.row_scale[p.row_of[k]]));
      Kind::store(value, y + k * kParts);
    }
    team.member.team_barrier();
    run_levels(team, p.factor_levels, p.levels, y);
    for (Vertex k = team.thread; k < p.n; k += team.threads) {
      Number value = Kind::load(y + k * kParts);
      value.multiply(Kind::load(team.memory + at.factors + p.pivot[k] * kParts));
      Real* const to = x + p.column_of[k] * kParts;
      value.scale(static_cast<Real>(p.column_scale[p.column_of[k]]));
      if (add) value.add(Kind::load(to));
      Kind::store(value, to);
    }
    team.member.team_barrier();
  }

  KOKKOS_INLINE_FUNCTION void give(const Team& team, int system, int column) const {
    Real* const to = callers.x + system * callers.x_stride + column * callers.ldx;
    const Real* const x = x_of(team, column);
    for (Vertex i = team.thread; i < p.n * kParts; i += team.threads) to[i] = x[i];
  }

  /// The largest of what the threads have, and 0. All of them have come so far.
  KOKKOS_INLINE_FUNCTION double most_of_team(const Team& team, double own) const {
    double* const all = of_threads + static_cast<Offset>(team.member.league_rank()) * team.threads;
    all[team.thread] = own;
    team.member.team_barrier();
    double most = 0;
    for (int k = 0; k < team.threads; ++k) most = larger(all[k], most);
    team.member.team_barrier();
    return most;
  }
};

}  // namespace mfs::lanes
