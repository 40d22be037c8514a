// The steps of lanes as kernels for any space of Kokkos. Every thread is a lane of a group; neighbours of a
// group are neighbours in memory. Steps that need not go from column to column are divided into shares, a
// thread for each.
#pragma once

#include <Kokkos_Core.hpp>

#include "kernels/lanes/lane_steps.hpp"

namespace mfs::lanes {

/// Arrays of lanes in the memory of a space: those of a group lie together. `c`: right-hand sides.
template <class Real>
struct SpaceArrays {
  ProgramView program;
  PivotSizes sizes;
  Real *values, *factors;         // by group
  Real *b, *r, *y, *x;            // by column and group
  Real* largest;                  // by group and share
  Real* failed;                   // by part and group
  Real* open;                     // by column and group
  double *share_errors, *errors;  // by column, group and share; by column and group
  int groups, shares;
};

/// Arrays of callers in the memory of a space, of real numbers.
template <class Real>
struct CallersArrays {
  const Real* values;
  Offset values_stride;  // in real numbers, as all here
  const Real* b;
  Real* x;
  Offset ldb, ldx, b_stride, x_stride;
  int count, columns;
};

/// What all kernels share: where the arrays of a lane begin.
template <class Kind>
struct LaneKernel {
  using Real = typename Kind::Real;
  using Steps = LaneSteps<Kind>;
  static constexpr int kLanes = Kind::kLanes;

  SpaceArrays<Real> at;

  /// Thread `index` has a lane of a group, and a share or a column of what remains.
  struct Place {
    int lane, group, rest;
  };
  KOKKOS_INLINE_FUNCTION Place place(Offset index) const {
    const Offset lane = index % kLanes, group = index / kLanes % at.groups, rest = index / kLanes / at.groups;
    return {static_cast<int>(lane), static_cast<int>(group), static_cast<int>(rest)};
  }
  KOKKOS_INLINE_FUNCTION int system(const Place& p, int count) const {
    const int system = p.group * kLanes + p.lane;
    return system < count ? system : count - 1;
  }
  /// The lane's array of `size` numbers in an array by column and group.
  KOKKOS_INLINE_FUNCTION Real* array(Real* all, Offset size, int group, int lane, int column = 0) const {
    return all + (static_cast<Offset>(column) * at.groups + group) * (size * Kind::kStep) + lane;
  }
  /// One real number of each lane.
  template <class Number>
  KOKKOS_INLINE_FUNCTION Number& number(Number* all, int group, int lane, int other = 0) const {
    return all[(static_cast<Offset>(other) * at.groups + group) * kLanes + lane];
  }
};

template <class Kind>
struct TakeValues : LaneKernel<Kind> {
  CallersArrays<typename Kind::Real> from;

  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto& at = this->at;
    const auto p = this->place(index);
    const CallersLanes<Kind> lane{from.values + this->system(p, from.count) * from.values_stride, 0, 1};
    this->number(at.largest, p.group, p.lane, p.rest) = LaneSteps<Kind>::take_values(
        at.program, lane, this->array(at.values, at.program.slots, p.group, p.lane),
        this->array(at.factors, at.program.entries, p.group, p.lane), Share{p.rest, at.shares});
  }
};

/// The parts of one stage, a thread for each of a lane.
template <class Kind>
struct FactorLanes : LaneKernel<Kind> {
  int first_part;

  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto& at = this->at;
    const auto p = this->place(index);
    const int part = first_part + p.rest;
    typename Kind::Vector largest = 0;
    for (int share = 0; share < at.shares; ++share)
      largest = larger(this->number(at.largest, p.group, p.lane, share), largest);
    this->number(at.failed, p.group, p.lane, part) = LaneSteps<Kind>::factor_columns(
        at.program, at.program.part_begin[part], at.program.part_begin[part + 1], at.sizes, largest,
        this->array(at.factors, at.program.entries, p.group, p.lane));
  }
};

/// Whether any part of a lane has failed, to the place of its first part.
template <class Kind>
struct GatherFailures : LaneKernel<Kind> {
  int parts;

  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto p = this->place(index);
    auto& failed = this->number(this->at.failed, p.group, p.lane);
    for (int part = 1; part < parts; ++part)
      failed = larger(this->number(this->at.failed, p.group, p.lane, part), failed);
  }
};

/// Right-hand sides to the lanes; a share of each column.
template <class Kind>
struct TakeRhs : LaneKernel<Kind> {
  CallersArrays<typename Kind::Real> from;

  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto& at = this->at;
    const auto p = this->place(index);
    const int column = p.rest / at.shares;
    const Share share{p.rest % at.shares, at.shares};
    const CallersLanes<Kind> lane{from.b + this->system(p, from.count) * from.b_stride + column * from.ldb, 0,
                                  1};
    auto* const b = this->array(at.b, at.program.n, p.group, p.lane, column);
    for (Offset i = share.begin(at.program.n), end = share.end(at.program.n); i < end; ++i)
      Kind::store(lane.load(i), b + i * Kind::kStep);
  }
};

/// x = what solves for b, or x += what solves for r where the lane is open.
template <class Kind>
struct SubstituteLanes : LaneKernel<Kind> {
  bool correct;

  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto& at = this->at;
    const auto p = this->place(index);
    const auto open = correct ? this->number(at.open, p.group, p.lane, p.rest) : typename Kind::Real(1);
    if (open == 0) return;
    const Vertex n = at.program.n;
    LaneSteps<Kind>::substitute(at.program, this->array(at.factors, at.program.entries, p.group, p.lane),
                                this->array(correct ? at.r : at.b, n, p.group, p.lane, p.rest),
                                this->array(at.y, n, p.group, p.lane, p.rest),
                                this->array(at.x, n, p.group, p.lane, p.rest), correct ? &open : nullptr);
  }
};

/// Residuals and errors; a share of each column.
template <class Kind>
struct MeasureLanes : LaneKernel<Kind> {
  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto& at = this->at;
    const auto p = this->place(index);
    const int column = p.rest / at.shares;
    const Vertex n = at.program.n;
    this->number(at.share_errors, p.group, p.lane, p.rest) = LaneSteps<Kind>::residual(
        at.program, this->array(at.values, at.program.slots, p.group, p.lane),
        this->array(at.b, n, p.group, p.lane, column), this->array(at.x, n, p.group, p.lane, column),
        this->array(at.r, n, p.group, p.lane, column), Share{p.rest % at.shares, at.shares});
  }
};

/// The largest error of all shares of a column.
template <class Kind>
struct GatherErrors : LaneKernel<Kind> {
  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto& at = this->at;
    const auto p = this->place(index);
    double most = 0;
    for (int share = 0; share < at.shares; ++share)
      most = larger(this->number(at.share_errors, p.group, p.lane, p.rest * at.shares + share), most);
    this->number(at.errors, p.group, p.lane, p.rest) = most;
  }
};

/// Solutions of lanes whose first column is open to the arrays of the caller; a share of each column.
template <class Kind>
struct GiveSolutions : LaneKernel<Kind> {
  CallersArrays<typename Kind::Real> to;

  KOKKOS_INLINE_FUNCTION void operator()(Offset index) const {
    const auto& at = this->at;
    const auto p = this->place(index);
    const int column = p.rest / at.shares, system = p.group * Kind::kLanes + p.lane;
    const Share share{p.rest % at.shares, at.shares};
    if (system >= to.count || this->number(at.open, p.group, p.lane) == 0) return;
    auto* const out = to.x + system * to.x_stride + column * to.ldx;
    const auto* const x = this->array(at.x, at.program.n, p.group, p.lane, column);
    for (Offset i = share.begin(at.program.n), end = share.end(at.program.n); i < end; ++i) {
      for (int part = 0; part < Kind::kParts; ++part)
        out[i * Kind::kParts + part] = x[i * Kind::kStep + part * Kind::kLanes];
    }
  }
};

}  // namespace mfs::lanes
