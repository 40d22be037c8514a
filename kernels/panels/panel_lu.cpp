#include "kernels/panels/panel_lu.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "kernels/lanes/lane_numbers.hpp"
#include "kernels/runtime/simd_clones.hpp"
#include "ordering/number_parts.hpp"

namespace mfs::panels {

namespace {

template <class Scalar>
using KindOf = lanes::LaneKind<typename NumberParts<Scalar>::type, NumberParts<Scalar>::count, 1>;

// Parts of numbers, as std::complex has them by definition.
template <class Scalar>
auto* reals(Scalar* numbers) {
  return reinterpret_cast<typename KindOf<Scalar>::Real*>(numbers);
}
template <class Scalar>
const auto* reals(const Scalar* numbers) {
  return reinterpret_cast<const typename KindOf<Scalar>::Real*>(numbers);
}

template <class Real, int count>
struct Registers {
  typedef Real type __attribute__((vector_size(count * sizeof(Real))));
};

using Run = PanelProgram::Run;

// So that a body is compiled for the processor of the function that it is in.
#define MFS_ALWAYS __attribute__((always_inline))

/// Calls body(std::integral_constant) for as many columns as a panel has.
template <class Body>
MFS_LANES void with_columns(Vertex columns, const Body& body) {
  static_assert(kMostTogether == 4);
  switch (columns) {
    case 1:
      return body(std::integral_constant<int, 1>());
    case 2:
      return body(std::integral_constant<int, 2>());
    case 3:
      return body(std::integral_constant<int, 3>());
    default:
      return body(std::integral_constant<int, 4>());
  }
}

template <class Scalar>
struct Steps {
  using Kind = KindOf<Scalar>;
  using Real = typename Kind::Real;
  using Number = typename Kind::Number;
  static constexpr Offset kStep = Kind::kStep;

  /// A panel, and where its numbers are.
  struct Panel : PanelProgram::Panel {
    Real* at_first;

    MFS_LANES Panel(const System<Scalar>& system, Vertex index)
        : PanelProgram::Panel(system.program.panels[index]),
          at_first(reals(system.numbers) + numbers * kStep) {}
    MFS_LANES Real* at(Vertex column, Vertex row) const {
      return at_first + (static_cast<Offset>(column) * rows + row) * kStep;
    }
    MFS_LANES Number load(Vertex column, Vertex row) const { return Kind::load(at(column, row)); }
    /// One column of it, as a panel.
    MFS_LANES Panel only(Vertex column) const {
      Panel one = *this;
      one.at_first = at(column, 0);
      one.first += column;
      one.before += column;
      one.columns = 1;
      return one;
    }
  };

  static MFS_LANES bool factor(const System<Scalar>& system, const PivotBounds& bounds) {
    const SymbolicPlan& plan = system.plan;
    const Vertex *panel_begin = system.program.panel_begin.data(), *pivot_begin = plan.pivot_begin.data();
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      for (Vertex k = pivot_begin[f]; k < pivot_begin[f + 1]; ++k) system.local_row[k] = k - pivot_begin[f];
      system.moved[f] = 0;
      for (Vertex index = panel_begin[f]; index < panel_begin[f + 1]; ++index) {
        const Panel panel(system, index);
        for (Vertex s = panel.source_begin; s <= panel.source_end; ++s)
          subtract_front(system, index, s, panel);
        if (!eliminate(system, index, panel, bounds)) return false;
      }
    }
    return true;
  }

  template <int width>
  static MFS_LANES void substitute(const System<Scalar>& system, bool transposed, Real* y) {
    if (!system.plan.triangle.empty()) return substitute_blocks<width>(system, transposed, y);
    const Vertex fronts = system.plan.num_fronts;
    for (Vertex f = 0; f < fronts; ++f) forward<width>(system, transposed, f, y);
    for (Vertex f = fronts - 1; f >= 0; --f) backward<width>(system, transposed, f, y);
  }

 private:
  template <int width>
  static MFS_LANES void forward(const System<Scalar>& system, bool transposed, Vertex f, Real* y) {
    transposed ? pass_front<width, true, true>(system, f, y) : pass_front<width, true, false>(system, f, y);
  }
  template <int width>
  static MFS_LANES void backward(const System<Scalar>& system, bool transposed, Vertex f, Real* y) {
    transposed ? pass_front<width, false, true>(system, f, y) : pass_front<width, false, false>(system, f, y);
  }

  // One block after the other; from each position what its couplings make of blocks before is taken.
  template <int width>
  static MFS_LANES void substitute_blocks(const System<Scalar>& system, bool transposed, Real* y) {
    const BlockTriangle& triangle = system.plan.triangle;
    const BlockTriangle::Couplings& lists = transposed ? triangle.by_column : triangle.by_row;
    const Vertex *const front = triangle.front.data(), *const block_begin = triangle.block_begin.data();
    const Vertex blocks = triangle.blocks();
    for (Vertex i = 0; i < blocks; ++i) {
      const Vertex b = transposed ? blocks - 1 - i : i;
      for (Vertex k = block_begin[b]; k < block_begin[b + 1]; ++k) {
        couple<width>(system, lists, front[k], y);
        forward<width>(system, transposed, front[k], y);
      }
      for (Vertex k = block_begin[b + 1]; k-- > block_begin[b];)
        backward<width>(system, transposed, front[k], y);
    }
  }
  template <int width>
  static MFS_LANES void couple(const System<Scalar>& system, const BlockTriangle::Couplings& lists, Vertex f,
                               Real* y) {
    const Offset *const begin = lists.begin.data(), *const number = lists.number.data();
    const Vertex *const others = lists.others.data(), *const pivot_begin = system.plan.pivot_begin.data();
    const Real* const numbers = reals(system.numbers) + system.program.couplings * kStep;
    for (Vertex p = pivot_begin[f]; p < pivot_begin[f + 1]; ++p) {
      if (begin[p] == begin[p + 1]) continue;
      Row<width> row = Row<width>::at(y, p);
      for (Offset k = begin[p]; k < begin[p + 1]; ++k)
        row.subtract_product(Kind::load(numbers + number[k] * kStep), Row<width>::at(y, others[k]));
      row.put(y, p);
    }
  }

  // The rows of a front's pivots as these came to them.
  static MFS_LANES void exchange_rows(const System<Scalar>& system, Vertex front, Vertex row,
                                      const Panel& panel) {
    if (!system.moved[front]) return;
    const Vertex begin = system.plan.pivot_begin[front], count = system.plan.pivot_begin[front + 1] - begin;
    Real* const work = reals(system.work);
    for (Vertex c = 0; c < panel.columns; ++c) {
      Real* const at = panel.at(c, row);
      for (Vertex i = 0; i < count; ++i) Kind::store(Kind::load(at + i * kStep), work + i * kStep);
      for (Vertex i = 0; i < count; ++i)
        Kind::store(Kind::load(work + system.local_row[begin + i] * kStep), at + i * kStep);
    }
  }

  // What comes from one source, or, after the last of them, from the panels of the same front.
  static MFS_LANES void subtract_front(const System<Scalar>& system, Vertex index, Vertex s,
                                       const Panel& panel) {
    const PanelProgram& program = system.program;
    const bool own = s == panel.source_end;
    const PanelProgram::Source source =
        own ? PanelProgram::Source{panel.front, panel.pivot_row, 0, 0} : program.sources[s];
    exchange_rows(system, source.front, source.row, panel);
    const Vertex rows_end = own ? panel.rows : source.row + system.plan.pivots(source.front);
    const Vertex end = own ? index : program.panel_begin[source.front + 1];
    const Run* const runs = program.runs.data();
    for (Vertex k = program.panel_begin[source.front]; k < end; ++k) {
      const Panel by(system, k);
      const Vertex u = source.row + by.before, below = u + by.columns;
      subtract_panel(by, u, {below, rows_end - below}, runs + source.run_begin, runs + source.run_end, panel);
    }
  }

  // From `panel`, the columns of L of `by` times what the panel has in rows u, u + 1, ...; the first run of
  // rows, then others.
  static MFS_LANES void subtract_panel(const Panel& by, Vertex u, const Run& first, const Run* run,
                                       const Run* end, const Panel& panel) {
    if constexpr (Kind::kParts > 1) {  // which have no registers to share
      for (Vertex c = 0; c < panel.columns; ++c) subtract_from<1>(by, u, first, run, end, panel.only(c));
    } else {
      with_columns(panel.columns,
                   [&](auto columns) MFS_ALWAYS { subtract_from<columns()>(by, u, first, run, end, panel); });
    }
  }
  template <int columns>
  static MFS_LANES void subtract_from(const Panel& by, Vertex u, const Run& first, const Run* run,
                                      const Run* end, const Panel& panel) {
    with_columns(by.columns, [&](auto width) MFS_ALWAYS {
      subtract_columns<columns, width()>(by, u, first, run, end, panel);
    });
  }
  // Each number takes its products in the order of the columns.
  template <int columns, int width>
  static MFS_LANES void subtract_columns(const Panel& by, Vertex u, const Run& first, const Run* run,
                                         const Run* end, const Panel& panel) {
    Number factors[columns][width];
    for (int t = 0; t < columns; ++t) {
      for (int c = 0; c < width; ++c) {
        factors[t][c] = panel.load(t, u + c);
        for (int before = 0; before < c; ++before)
          factors[t][c].subtract_product(by.load(before, diagonal_row(by) + c), factors[t][before]);
        if (c > 0) Kind::store(factors[t][c], panel.at(t, u + c));
      }
    }
    const Real* l[width];
    for (int c = 0; c < width; ++c) l[c] = by.at(c, diagonal_row(by) + width);
    subtract_run<columns, width>(first, l, factors, panel);
    for (; run != end; ++run) subtract_run<columns, width>(*run, l, factors, panel);
  }
  template <int columns, int width>
  static MFS_LANES void subtract_run(const Run& run, const Real** l, const Number (*factors)[width],
                                     const Panel& panel) {
    Vertex rows = run.rows;
    Real* to = panel.at(0, run.row);
    const Offset column = panel.rows * kStep;
    if constexpr (Kind::kParts == 1) {
      for (; rows >= 8; rows -= 8) subtract_rows<columns, width, 8>(to, column, l, factors);
      if (rows >= 4) subtract_rows<columns, width, 4>(to, column, l, factors);
      if (rows % 4 >= 2) subtract_rows<columns, width, 2>(to, column, l, factors);
      rows %= 2;
    }
    for (; rows > 0; --rows) {
      for (int t = 0; t < columns; ++t) {
        Number number = Kind::load(to + t * column);
        for (int c = 0; c < width; ++c) number.subtract_product(Kind::load(l[c]), factors[t][c]);
        Kind::store(number, to + t * column);
      }
      to += kStep;
      for (int c = 0; c < width; ++c) l[c] += kStep;
    }
  }
  template <int columns, int width, int rows>
  static MFS_LANES void subtract_rows(Real*& to, Offset column, const Real** l,
                                      const Number (*factors)[width]) {
    typename Registers<Real, rows>::type numbers, by[width];
    for (int c = 0; c < width; ++c) {
      std::memcpy(&by[c], l[c], sizeof numbers);
      l[c] += rows;
    }
    for (int t = 0; t < columns; ++t) {
      std::memcpy(&numbers, to + t * column, sizeof numbers);
      for (int c = 0; c < width; ++c) numbers -= by[c] * factors[t][c].value;
      std::memcpy(to + t * column, &numbers, sizeof numbers);
    }
    to += rows;
  }

  // Of the panel's first pivot, as its own rows are numbered.
  static MFS_LANES Vertex diagonal_row(const Panel& panel) { return panel.pivot_row + panel.before; }

  // LU of a panel that has all products with columns before it.
  static MFS_LANES bool eliminate(const System<Scalar>& system, Vertex index, const Panel& panel,
                                  const PivotBounds& bounds) {
    const Vertex pivots_end = panel.pivot_row + system.plan.pivots(panel.front);
    for (Vertex c = 0; c < panel.columns; ++c) {
      const Vertex diagonal = diagonal_row(panel) + c;
      subtract_before(panel, c);
      const Vertex pivot = pivot_row(panel, c, diagonal, pivots_end, static_cast<Real>(bounds.preference));
      if (pivot != diagonal)
        exchange(system, index, panel, diagonal - panel.pivot_row, pivot - panel.pivot_row);
      const Real size = size_of(panel.at(c, diagonal)) * Real(Kind::kParts == 1 ? 1 : 0.707);
      if (!(size > static_cast<Real>(bounds.tiny)) || !(size <= std::numeric_limits<Real>::max()))
        return false;
      const Number inverse = panel.load(c, diagonal).inverse();
      Kind::store(inverse, panel.at(c, diagonal));
      for (Real* at = panel.at(c, diagonal + 1); at < panel.at(c, panel.rows); at += kStep) {
        Number l = Kind::load(at);
        l.multiply(inverse);
        Kind::store(l, at);
      }
      const bool suspect = size < static_cast<Real>(bounds.bound);
      const auto part = static_cast<Real>(bounds.border_part);
      if (suspect && !(largest_size(panel, c, pivots_end) * part <= 1)) return false;
    }
    return true;
  }
  // Columns of the panel before column c.
  static MFS_LANES void subtract_before(const Panel& panel, Vertex c) {
    const Vertex u = diagonal_row(panel);
    const Run below{u + c, panel.rows - u - c};
    switch (c) {
      case 1:
        return subtract_columns<1, 1>(panel, u, below, nullptr, nullptr, panel.only(c));
      case 2:
        return subtract_columns<1, 2>(panel, u, below, nullptr, nullptr, panel.only(c));
      case 3:
        return subtract_columns<1, 3>(panel, u, below, nullptr, nullptr, panel.only(c));
      default:
        return;
    }
  }
  // Of a complex number the sum of its parts' sizes, up to the root of 2 times its own.
  static MFS_LANES Real size_of(const Real* number) {
    if constexpr (Kind::kParts == 1) {
      return std::abs(number[0]);
    } else {
      return std::abs(number[0]) + std::abs(number[1]);
    }
  }
  // The first row counts `preference` times.
  static MFS_LANES Vertex pivot_row(const Panel& panel, Vertex c, Vertex first, Vertex end, Real preference) {
    Vertex found = first;
    Real most = size_of(panel.at(c, first)) * preference;
    for (Vertex row = first + 1; row < end; ++row) {
      const Real size = size_of(panel.at(c, row));
      if (size > most) {
        most = size;
        found = row;
      }
    }
    return found;
  }
  static MFS_LANES Real largest_size(const Panel& panel, Vertex c, Vertex first) {
    Real most = 0;
    for (Vertex row = first; row < panel.rows; ++row) most = std::max(most, size_of(panel.at(c, row)));
    return most;
  }
  // Rows of the front's pivot block in this panel and those before it.
  static MFS_LANES void exchange(const System<Scalar>& system, Vertex index, const Panel& panel, Vertex one,
                                 Vertex other) {
    for (Vertex p = system.program.panel_begin[panel.front]; p <= index; ++p) {
      const Panel of(system, p);
      for (Vertex c = 0; c < of.columns; ++c) {
        const Number kept = of.load(c, of.pivot_row + one);
        Kind::store(of.load(c, of.pivot_row + other), of.at(c, of.pivot_row + one));
        Kind::store(kept, of.at(c, of.pivot_row + other));
      }
    }
    Vertex* const local_row = system.local_row + system.plan.pivot_begin[panel.front];
    std::swap(local_row[one], local_row[other]);
    system.moved[panel.front] = 1;
  }

  // The numbers of one position.
  template <int width>
  struct Row {
    Number numbers[width];

    static MFS_LANES Row at(const Real* y, Offset position) {
      Row row;
      std::memcpy(&row, y + position * kStep * width, sizeof row);
      return row;
    }
    MFS_LANES void put(Real* y, Offset position) const {
      std::memcpy(y + position * kStep * width, this, sizeof *this);
    }
    MFS_LANES void subtract_product(const Number& a, const Row& b) {
      for (int c = 0; c < width; ++c) numbers[c].subtract_product(a, b.numbers[c]);
    }
    MFS_LANES void multiply(const Number& a) {
      for (int c = 0; c < width; ++c) numbers[c].multiply(a);
    }
  };

  // With L forward and U backward, for A^T with U forward and L backward.
  template <int width, bool forward, bool transposed>
  static MFS_LANES void pass_front(const System<Scalar>& system, Vertex f, Real* y) {
    const Vertex begin = system.program.panel_begin[f], end = system.program.panel_begin[f + 1];
    if (forward && !transposed) exchange_positions<width, true>(system, f, y);
    for (Vertex k = 0; k < end - begin; ++k) {
      const Panel panel(system, forward ? begin + k : end - 1 - k);
      if constexpr (Kind::kParts > 1) {
        for (Vertex c = 0; c < panel.columns; ++c)
          pass<width, 1, forward, transposed>(system, panel.only(forward ? c : panel.columns - 1 - c), y);
      } else {
        with_columns(panel.columns, [&](auto columns) MFS_ALWAYS {
          pass<width, columns(), forward, transposed>(system, panel, y);
        });
      }
    }
    if (!forward && transposed) exchange_positions<width, false>(system, f, y);
  }
  // As exchange_rows, and back.
  template <int width, bool there>
  static MFS_LANES void exchange_positions(const System<Scalar>& system, Vertex f, Real* y) {
    if (!system.moved[f]) return;
    const Vertex begin = system.plan.pivot_begin[f], count = system.plan.pivot_begin[f + 1] - begin;
    Real *const work = reals(system.work), *const at = y + static_cast<Offset>(begin) * width * kStep;
    for (Vertex i = 0; i < count; ++i) Row<width>::at(at, i).put(work, i);
    for (Vertex i = 0; i < count; ++i) {
      const Vertex row = system.local_row[begin + i];
      Row<width>::at(work, there ? row : i).put(at, there ? i : row);
    }
  }
  template <int width, int columns, bool forward, bool transposed>
  static MFS_LANES void pass(const System<Scalar>& system, const Panel& panel, Real* y) {
    constexpr bool lower = forward != transposed;
    Row<width> at[columns];
    for (int t = 0; t < columns; ++t) at[t] = Row<width>::at(y, panel.first + t);
    if constexpr (transposed) visit_others<width, columns, lower, true>(system, panel, at, y);
    const Vertex diagonal = diagonal_row(panel);
    for (int step = 0; step < columns; ++step) {
      const int t = forward ? step : columns - 1 - step;
      for (int s = forward ? 0 : columns - 1; s != t; s += forward ? 1 : -1) {
        // What L or U have in the column of one and the row of the other.
        const Number number = transposed ? panel.load(t, diagonal + s) : panel.load(s, diagonal + t);
        at[t].subtract_product(number, at[s]);
      }
      if constexpr (!lower) at[t].multiply(panel.load(t, diagonal + t));
      at[t].put(y, panel.first + t);
    }
    if constexpr (!transposed) visit_others<width, columns, lower, false>(system, panel, at, y);
  }
  // Other positions than the panel's give to it, or take from it.
  template <int width, int columns, bool lower, bool give>
  static MFS_LANES void visit_others(const System<Scalar>& system, const Panel& panel, Row<width>* at,
                                     Real* y) {
    const SymbolicPlan& plan = system.plan;
    const Vertex* const pivot_begin = plan.pivot_begin.data();
    const Vertex begin = pivot_begin[panel.front], end = pivot_begin[panel.front + 1];
    if constexpr (lower) {
      const Vertex next = panel.first + columns, pivots_end = panel.pivot_row + end - begin;
      visit<width, columns, give>(panel, panel.pivot_row + next - begin, end - next, next, at, y);
      const Vertex* const border = plan.border.data() + plan.border_begin[panel.front];
      for (Vertex row = pivots_end; row < panel.rows; ++row)
        visit<width, columns, give>(panel, row, 1, border[row - pivots_end], at, y);
    } else {
      visit<width, columns, give>(panel, panel.pivot_row, panel.first - begin, begin, at, y);
      for (Vertex s = panel.source_begin; s < panel.source_end; ++s) {
        const PanelProgram::Source& source = system.program.sources[s];
        const Vertex first = pivot_begin[source.front];
        visit<width, columns, give>(panel, source.row, pivot_begin[source.front + 1] - first, first, at, y);
      }
    }
  }
  // Rows of the panel that belong to neighbouring positions.
  template <int width, int columns, bool give>
  static MFS_LANES void visit(const Panel& panel, Vertex row, Vertex rows, Vertex position, Row<width>* at,
                              Real* y) {
    for (Vertex i = 0; i < rows; ++i) {
      Row<width> other = Row<width>::at(y, position + i);
      for (int t = 0; t < columns; ++t) {
        if constexpr (give) {
          at[t].subtract_product(panel.load(t, row + i), other);
        } else {
          other.subtract_product(panel.load(t, row + i), at[t]);
        }
      }
      if constexpr (!give) other.put(y, position + i);
    }
  }
};

// Each step for processors of one kind.
#define MFS_STEPS_FOR(TARGET, S)                                                  \
  TARGET bool factor_panels(const System<S>& system, const PivotBounds& bounds) { \
    return Steps<S>::factor(system, bounds);                                      \
  }                                                                               \
  TARGET void substitute_one(const System<S>& system, bool transposed, S* y) {    \
    Steps<S>::substitute<1>(system, transposed, reals(y));                        \
  }                                                                               \
  TARGET void substitute_many(const System<S>& system, bool transposed, S* y) {   \
    Steps<S>::substitute<kSideBySide>(system, transposed, reals(y));              \
  }

MFS_FOR_SIMD_TARGETS(MFS_STEPS_FOR, float)
MFS_FOR_SIMD_TARGETS(MFS_STEPS_FOR, double)
MFS_FOR_SIMD_TARGETS(MFS_STEPS_FOR, std::complex<float>)
MFS_FOR_SIMD_TARGETS(MFS_STEPS_FOR, std::complex<double>)

/// The largest of some sizes. Each of its parts waits for its own comparison before only.
template <class Real>
class Largest {
 public:
  static constexpr int kParts = 4;
  void take(int part, Real size) { parts_[part] = size > parts_[part] ? size : parts_[part]; }
  Real value() const { return *std::max_element(parts_, parts_ + kParts); }

 private:
  Real parts_[kParts] = {};
};

}  // namespace

template <class Value, class Scalar>
double take_values(const System<Scalar>& system, const Value* values, const double* row_scale,
                   const double* column_scale) {
  using Kind = KindOf<Value>;
  using Target = KindOf<Scalar>;
  const auto* const from = reals(values);
  auto* const to = reals(system.numbers);
  const Vertex* const places = system.program.place.data();
  const Vertex* const columns = system.pattern.columns.data();
  const Offset* const offsets = system.pattern.offsets.data();
  std::fill(system.numbers, system.numbers + system.program.numbers, Scalar(0));
  using Sizes = Largest<typename Kind::Real>;
  Sizes largest;
  for (Vertex i = 0; i < system.pattern.n; ++i) {
    const double scale = row_scale[i];
    const auto take = [&](Offset slot, int part) {
      auto value = Kind::load(from + slot * Kind::kStep);
      value.scale(static_cast<typename Kind::Real>(scale * column_scale[columns[slot]]));
      largest.take(part, value.bound());
      auto* const place = to + places[slot] * Target::kStep;
      if constexpr (Kind::kParts == 1) {
        place[0] = static_cast<typename Target::Real>(value.value);
      } else {
        place[0] = static_cast<typename Target::Real>(value.re);
        place[1] = static_cast<typename Target::Real>(value.im);
      }
    };
    const Offset end = offsets[i + 1];
    Offset slot = offsets[i];
    for (; slot + Sizes::kParts <= end; slot += Sizes::kParts) {
      for (int part = 0; part < Sizes::kParts; ++part) take(slot + part, part);
    }
    for (; slot < end; ++slot) take(slot, 0);
  }
  return largest.value();
}

template <class Scalar>
bool factor(const System<Scalar>& system, const PivotBounds& bounds) {
  return factor_panels(system, bounds);
}

template <class Scalar>
void substitute(const System<Scalar>& system, bool transposed, bool side_by_side, Scalar* y) {
  side_by_side ? substitute_many(system, transposed, y) : substitute_one(system, transposed, y);
}

#define MFS_INSTANTIATE(S)                                       \
  template bool factor<S>(const System<S>&, const PivotBounds&); \
  template void substitute<S>(const System<S>&, bool, bool, S*); \
  template double take_values<S, S>(const System<S>&, const S*, const double*, const double*);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)
template double take_values<double, float>(const System<float>&, const double*, const double*, const double*);
template double take_values<std::complex<double>, std::complex<float>>(const System<std::complex<float>>&,
                                                                       const std::complex<double>*,
                                                                       const double*, const double*);

}  // namespace mfs::panels
