// What is done for the systems of some lanes with the operations of a scalar program: values and right-hand
// sides come to the lanes, are factored, substituted and measured. All lanes do the same; what a lane
// computes depends on its own numbers alone, and a lane that has failed goes on with whatever numbers it has.
//
// The matrix is scaled as by the solver, by powers of two. A pivot is too small by the rule of the fronts
// (kernels/dense/pivot_rule.hpp): then the lane has failed, as it has where the backward error is missed.
#pragma once

#include <limits>

#include "kernels/lanes/lane_numbers.hpp"
#include "kernels/lanes/lane_outcome.hpp"
#include "kernels/lanes/lane_program.hpp"

namespace mfs::lanes {

/// Values or right-hand sides of all lanes in arrays of the caller, from the first lane's on, with `stride`
/// numbers from lane to lane. Lanes from `count` on have the numbers of the last one.
template <class Kind>
struct CallersLanes {
  const typename Kind::Real* first;
  Offset stride;
  int count;

  MFS_LANES typename Kind::Number load(Offset index) const {
    if constexpr (Kind::kParts == 1) {
      return {part(index)};
    } else {
      return {part(2 * index), part(2 * index + 1)};
    }
  }

 private:
  MFS_LANES typename Kind::Vector part(Offset place) const {
    return Kind::Traits::gather(first, stride * Kind::kParts, count, place);
  }
};

/// Numbers in an array of lanes.
template <class Kind>
struct OwnLanes {
  const typename Kind::Real* first;

  MFS_LANES typename Kind::Number load(Offset index) const { return Kind::load(first + index * Kind::kStep); }
};

/// A part of the work of a lane: some of the entries or rows.
struct Share {
  int index = 0, count = 1;
  MFS_LANES Offset begin(Offset all) const { return all * index / count; }
  MFS_LANES Offset end(Offset all) const { return all * (index + 1) / count; }
};

/// A sum in blocks, as BlockedSum of kernels/stages/residual.hpp.
template <class Number>
struct LaneSum {
  static constexpr int kBlock = 256;
  Number block, high, low;

  MFS_LANES void close() {
    Number sum = high, added, rest, lost = block;
    sum.add(block);
    added = sum;
    added.subtract(high);
    rest = sum;
    rest.subtract(added);
    low.add(high);
    low.subtract(rest);
    lost.subtract(added);
    low.add(lost);
    high = sum;
    block = Number{};
  }
  MFS_LANES Number value() const {
    Number sum = high;
    sum.add(block);
    sum.add(low);
    return sum;
  }
};

template <class Kind>
struct LaneSteps {
  using Real = typename Kind::Real;
  using V = typename Kind::Vector;
  using Wide = typename Kind::Wide;
  using Number = typename Kind::Number;
  using WideNumber = typename Kind::WideNumber;
  static constexpr Offset kStep = Kind::kStep;

  /// a [slots] = the values, and the entries of the factors before any product. Returns the largest scaled
  /// value.
  static MFS_LANES V take_values(const ProgramView& p, const CallersLanes<Kind>& from, Real* a,
                                 Real* factors) {
    if (p.slot_of_value) sum_values(p, from, a);
    for (Offset k = 0; k < p.fills; ++k) Kind::store(Number{}, factors + p.fill[k] * kStep);
    V largest{};
    for (Offset slot = 0; slot < p.slots; ++slot) {
      Number value;
      if (p.slot_of_value) {
        value = Kind::load(a + slot * kStep);
      } else {
        value = from.load(slot);
        Kind::store(value, a + slot * kStep);
      }
      value.scale(every_lane<V>(static_cast<Real>(p.slot_scale[slot])));
      Kind::store(value, factors + p.place[slot] * kStep);
      largest = larger(value.bound(), largest);
    }
    return largest;
  }

  /// Factors what take_values left. The inverses of the pivots take their place. Returns 1 for lanes with a
  /// pivot that is too small, 0 for the others.
  static MFS_LANES V factor(const ProgramView& p, const PivotSizes& sizes, const V& largest, Real* factors) {
    const V tiny = largest * static_cast<Real>(sizes.tiny), bound = largest * static_cast<Real>(sizes.bound);
    const Real most = static_cast<Real>(1 / sizes.border_part);
    const Vertex* target = p.target;
    V failed{};
    for (Vertex k = 0; k < p.n; ++k) {
      const Vertex begin = p.column_begin[k], pivot = p.pivot[k], end = p.column_begin[k + 1];
      Real* const column = factors + begin * kStep;
      for (Vertex e = begin; e < pivot; e += p.width[e])
        target = subtract_columns(p, p.row[e], p.width[e], target, factors, factors + e * kStep, column);
      const Number diagonal = Kind::load(factors + pivot * kStep), inverse = diagonal.inverse();
      Kind::store(inverse, factors + pivot * kStep);
      V border{};
      for (Vertex e = pivot + 1; e < end; ++e) {
        Number l = Kind::load(factors + e * kStep);
        l.multiply(inverse);
        Kind::store(l, factors + e * kStep);
        border = larger(l.bound(), border);
      }
      const V size = diagonal.bound();
      failed = size > tiny ? failed : every_lane<V>(1);
      failed = size < bound ? (border > most ? every_lane<V>(1) : failed) : failed;
    }
    return failed;
  }

  /// x [n] = the solution for what is in r [n], both by row and column of A; or x += that where `add` is not
  /// zero. `y` [n] is workspace.
  static MFS_LANES void substitute(const ProgramView& p, const Real* factors, const Real* r, Real* y, Real* x,
                                   const V* add) {
    for (Vertex k = 0; k < p.n; ++k) {
      Number value = Kind::load(r + p.row_of[k] * kStep);
      value.scale(every_lane<V>(static_cast<Real>(p.row_scale[p.row_of[k]])));
      Kind::store(value, y + k * kStep);
    }
    for (Vertex k = 0; k < p.n; ++k)
      subtract_entries(p, p.pivot[k] + 1, p.column_begin[k + 1], Kind::load(y + k * kStep), factors, y);
    for (Vertex k = p.n - 1; k >= 0; --k) {
      Number value = Kind::load(y + k * kStep);
      value.multiply(Kind::load(factors + p.pivot[k] * kStep));
      subtract_entries(p, p.column_begin[k], p.pivot[k], value, factors, y);
      Real* const to = x + p.column_of[k] * kStep;
      value.scale(every_lane<V>(static_cast<Real>(p.column_scale[p.column_of[k]])));
      if (add) value = sum_where(*add, Kind::load(to), value);
      Kind::store(value, to);
    }
  }

  /// r = b - A x, and the largest componentwise backward error of each lane, infinite for NaN.
  template <class Program, class From>
  static MFS_LANES Wide residual(const Program& p, const From& a, const From& b, const Real* x, Real* r,
                                 const Share& share = {}) {
    Wide most{};
    for (Offset i = share.begin(p.n), last = share.end(p.n); i < last; ++i) {
      LaneSum<WideNumber> terms{Kind::widen(b.load(i)), {}, {}};
      Wide size = terms.block.magnitude();
      const Offset end = p.matrix_begin[i + 1];
      for (Offset begin = p.matrix_begin[i], stop = 0; begin < end; begin = stop) {
        stop = begin + LaneSum<WideNumber>::kBlock < end ? begin + LaneSum<WideNumber>::kBlock : end;
        for (Offset k = begin; k < stop; ++k) {
          WideNumber product = Kind::widen(a.load(k));
          product.multiply(Kind::widen(Kind::load(x + p.matrix_column[k] * kStep)));
          terms.block.subtract(product);
          size += product.magnitude();
        }
        if (stop < end) terms.close();
      }
      const WideNumber off = terms.value();
      Kind::store(Kind::narrow(off), r + i * kStep);
      most = larger(row_error(off.magnitude(), size), most);
    }
    return most;
  }

 private:
  static MFS_LANES void sum_values(const ProgramView& p, const CallersLanes<Kind>& from, Real* a) {
    for (Offset slot = 0; slot < p.slots; ++slot) Kind::store(Number{}, a + slot * kStep);
    for (Offset k = 0; k < p.values; ++k) {
      Real* const to = a + p.slot_of_value[k] * kStep;
      Number sum = Kind::load(to);
      sum.add(from.load(k));
      Kind::store(sum, to);
    }
  }
  static MFS_LANES const Vertex* subtract_columns(const ProgramView& p, Vertex j, int width,
                                                  const Vertex* target, const Real* factors, Real* u,
                                                  Real* column) {
    switch (width) {
      case 1:
        return subtract_together<1>(p, j, target, factors, u, column);
      case 2:
        return subtract_together<2>(p, j, target, factors, u, column);
      case 3:
        return subtract_together<3>(p, j, target, factors, u, column);
      default:
        return subtract_together<kMostWidth>(p, j, target, factors, u, column);
    }
  }
  // Columns j ... j + width - 1 of L times the entries from u on. Each entry takes its products in the order
  // of the columns.
  template <int width>
  static MFS_LANES const Vertex* subtract_together(const ProgramView& p, Vertex j, const Vertex* target,
                                                   const Real* factors, Real* u, Real* column) {
    Number by[width];
    const Real* l[width];
    for (int c = 0; c < width; ++c) {
      by[c] = Kind::load(u + c * kStep);
      l[c] = factors + (p.pivot[j + c] + Offset{1}) * kStep;
      for (int before = 0; before < c; ++before, l[before - 1] += kStep)
        by[c].subtract_product(Kind::load(l[before]), by[before]);
      if (c > 0) Kind::store(by[c], u + c * kStep);
    }
    const Vertex count = p.column_begin[j + width] - p.pivot[j + width - 1] - 1;
    subtract_range<width>(target, l, by, column, 0, count);
    return target + count;
  }
  // Rows first ... last - 1.
  template <int width>
  static MFS_LANES void subtract_range(const Vertex* target, const Real* const* l, const Number* by,
                                       Real* column, Vertex first, Vertex last) {
    for (; first < last; ++first) {
      Real* const to = column + target[first] * kStep;
      Number entry = Kind::load(to);
      for (int c = 0; c < width; ++c) entry.subtract_product(Kind::load(l[c] + first * kStep), by[c]);
      Kind::store(entry, to);
    }
  }
  static MFS_LANES void subtract_entries(const ProgramView& p, Vertex begin, Vertex end, const Number& by,
                                         const Real* factors, Real* y) {
    const Real* const l[1] = {factors};
    subtract_range<1>(p.row, l, &by, y, begin, end);
  }
  // Lanes where `add` is 0 keep what they have, whatever the other is.
  static MFS_LANES Number sum_where(const V& add, const Number& have, const Number& other) {
    Number sum = have;
    sum.add(other);
    if constexpr (Kind::kParts == 1) {
      return {add != 0 ? sum.value : have.value};
    } else {
      return {add != 0 ? sum.re : have.re, add != 0 ? sum.im : have.im};
    }
  }
  // As row_error of kernels/stages/residual.hpp.
  static MFS_LANES Wide row_error(const Wide& off, const Wide& size) {
    constexpr double kMost = 1.7976931348623157e308, kInfinite = __builtin_huge_val();
    const Wide infinite = every_lane<Wide>(kInfinite);
    const Wide ratio = off == 0 ? Wide{} : (size <= kMost ? off / size : infinite);
    return ratio <= 1e300 ? ratio : infinite;
  }
};

constexpr double kNotMeasured = std::numeric_limits<double>::infinity();

/// Notes the error `now` of one column of a lane after so many steps of refinement. `error` is what it was,
/// from kNotMeasured on. Whether the column is to be refined: each step must halve the error.
MFS_LANES bool stays_open(const LaneRules& rules, int step, double now, double& error, LaneOutcome& lane) {
  if (!lane.solved || error <= rules.tolerance) return false;
  const double before = error;
  error = now;
  if (now <= rules.tolerance) {
    lane.backward_error = larger(now, lane.backward_error);
    lane.steps = lane.steps < step ? step : lane.steps;
    return false;
  }
  const bool improved = step == 0 ? now < before : now < 0.5 * before;
  lane.solved = improved && step < rules.max_steps;
  return lane.solved;
}

}  // namespace mfs::lanes
