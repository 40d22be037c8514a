#include "kernels/lanes/host_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>

#include "kernels/lanes/lane_steps.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs::lanes {

typedef double DoubleLanes __attribute__((vector_size(kHostLanes * sizeof(double))));
typedef float FloatLanes __attribute__((vector_size(kHostLanes * sizeof(float))));

template <class V, class R>
struct VectorTraits {
  using Real = R;
  using Wide = DoubleLanes;
  static MFS_LANES V read(const Real* from) {
    V value;
    std::memcpy(&value, from, sizeof value);
    return value;
  }
  static MFS_LANES void write(const V& value, Real* to) { std::memcpy(to, &value, sizeof value); }
  static MFS_LANES Wide widen(const V& value) { return __builtin_convertvector(value, Wide); }
  static MFS_LANES V narrow(const Wide& value) { return __builtin_convertvector(value, V); }
  static MFS_LANES V root(const V& value) {
    V found = value;
    for (int lane = 0; lane < kHostLanes; ++lane) found[lane] = std::sqrt(value[lane]);
    return found;
  }
  static MFS_LANES V gather(const Real* first, Offset stride, int count, Offset place) {
    V value{};
    if (count == kHostLanes) {
      for (int lane = 0; lane < kHostLanes; ++lane) value[lane] = first[lane * stride + place];
    } else {
      for (int lane = 0; lane < kHostLanes; ++lane)
        value[lane] = first[std::min(lane, count - 1) * stride + place];
    }
    return value;
  }
};
template <>
struct LaneTraits<DoubleLanes> : VectorTraits<DoubleLanes, double> {};
template <>
struct LaneTraits<FloatLanes> : VectorTraits<FloatLanes, float> {};

namespace {

template <class Scalar>
using KindOf = LaneKind<
    std::conditional_t<std::is_same_v<typename NumberParts<Scalar>::type, double>, DoubleLanes, FloatLanes>,
    NumberParts<Scalar>::count, kHostLanes>;

// Each step for processors of one kind.
#define MFS_LANES_FOR(TARGET, S)                                                                    \
  TARGET void factor_lanes(const LaneArrays<S>& at, const PivotSizes& sizes,                        \
                           const CallersLanes<KindOf<S>>& from) {                                   \
    using Steps = LaneSteps<KindOf<S>>;                                                             \
    const auto largest = Steps::take_values(at.program, from, at.values, at.factors);               \
    KindOf<S>::Traits::write(Steps::factor(at.program, sizes, largest, at.factors), at.failed);     \
  }                                                                                                 \
  TARGET void substitute_lanes(const LaneArrays<S>& at, const CallersLanes<KindOf<S>>& from,        \
                               KindOf<S>::Real* x) {                                                \
    using Kind = KindOf<S>;                                                                         \
    for (Offset i = 0; i < at.program.n; ++i) Kind::store(from.load(i), at.b + i * Kind::kStep);    \
    LaneSteps<Kind>::substitute(at.program, at.factors, at.b, at.y, x, nullptr);                    \
  }                                                                                                 \
  TARGET void correct_lanes(const LaneArrays<S>& at, KindOf<S>::Real* x) {                          \
    const auto open = KindOf<S>::Traits::read(at.open);                                             \
    LaneSteps<KindOf<S>>::substitute(at.program, at.factors, at.r, at.y, x, &open);                 \
  }                                                                                                 \
  TARGET void measure_lanes(const LaneArrays<S>& at, const KindOf<S>::Real* x) {                    \
    using Own = OwnLanes<KindOf<S>>;                                                                \
    KindOf<double>::Traits::write(                                                                  \
        LaneSteps<KindOf<S>>::residual(at.program, Own{at.values}, Own{at.b}, x, at.r), at.errors); \
  }

MFS_FOR_SIMD_TARGETS(MFS_LANES_FOR, float)
MFS_FOR_SIMD_TARGETS(MFS_LANES_FOR, double)
MFS_FOR_SIMD_TARGETS(MFS_LANES_FOR, std::complex<float>)
MFS_FOR_SIMD_TARGETS(MFS_LANES_FOR, std::complex<double>)

struct Places {
  Places(const ProgramView& program, Offset number_bytes, Offset nrhs) {
    const Offset bytes = number_bytes * kHostLanes;
    values = layout.add(program.slots * bytes);
    factors = layout.add(program.entries * bytes);
    for (Offset* vector : {&b, &r, &y}) *vector = layout.add(program.n * bytes);
    x = layout.add(program.n * nrhs * bytes);
    failed = layout.add(bytes);
    open = layout.add(bytes);
    errors = layout.add(kHostLanes * static_cast<Offset>(sizeof(double)));
  }
  ArenaLayout layout;
  Offset values, factors, b, r, y, x, failed, open, errors;
};

// Number `index` of a lane of an array of lanes.
template <class Scalar, class Real>
Scalar number_of(const Real* array, Offset index, int lane) {
  const Real* const place = array + index * KindOf<Scalar>::kStep + lane;
  if constexpr (KindOf<Scalar>::kParts == 1) {
    return *place;
  } else {
    return {place[0], place[kHostLanes]};
  }
}

}  // namespace

Offset lane_bytes(const ProgramView& program, Offset number_bytes, Offset nrhs) {
  return Places(program, number_bytes, nrhs).layout.total();
}

template <class Scalar>
HostLanes<Scalar>::HostLanes(const ProgramView& program, const LaneRules& rules, Offset nrhs)
    : rules_(rules), nrhs_(nrhs), arena_(lane_bytes(program, static_cast<Offset>(sizeof(Scalar)), nrhs)) {
  const Places places(program, static_cast<Offset>(sizeof(Scalar)), nrhs);
  const auto at = [&](Offset place) { return arena_.template at<Real>(place); };
  at_ = {program,           at(places.values), at(places.factors),
         at(places.b),      at(places.r),      at(places.y),
         at(places.failed), at(places.open),   arena_.template at<double>(places.errors)};
  x_ = at(places.x);
}

template <class Scalar>
void HostLanes<Scalar>::solve(const LaneSystems<Scalar>& systems, LaneOutcome* outcome) {
  factor_lanes(at_, rules_.pivots,
               {reinterpret_cast<const Real*>(systems.values), systems.values_stride,
                static_cast<int>(systems.count)});
  for (int lane = 0; lane < systems.count; ++lane) {
    outcome[lane] = LaneOutcome();
    outcome[lane].solved = at_.failed[lane] == 0;
  }
  for (Offset column = 0; column < systems.nrhs; ++column) solve_column(systems, column, outcome);
  const Offset n = at_.program.n;
  for (int lane = 0; lane < systems.count; ++lane) {
    if (!outcome[lane].solved) continue;
    for (Offset column = 0; column < systems.nrhs; ++column) {
      Scalar* const to = systems.x + lane * systems.x_stride + column * systems.ldx;
      for (Offset i = 0; i < n; ++i) to[i] = number_of<Scalar>(x_, column * n + i, lane);
    }
  }
}

template <class Scalar>
void HostLanes<Scalar>::solve_column(const LaneSystems<Scalar>& systems, Offset column,
                                     LaneOutcome* outcome) {
  const auto is_solved = [](const LaneOutcome& lane) { return lane.solved; };
  if (std::none_of(outcome, outcome + systems.count, is_solved)) return;
  Real* const x = x_ + column * at_.program.n * KindOf<Scalar>::kStep;
  substitute_lanes(at_,
                   {reinterpret_cast<const Real*>(systems.b + column * systems.ldb), systems.b_stride,
                    static_cast<int>(systems.count)},
                   x);
  double error[kHostLanes];
  std::fill(error, error + kHostLanes, kNotMeasured);
  for (int step = 0;; ++step) {
    measure_lanes(at_, x);
    std::fill(at_.open, at_.open + kHostLanes, Real(0));
    bool more = false;
    for (int lane = 0; lane < systems.count; ++lane) {
      if (!stays_open(rules_, step, at_.errors[lane], error[lane], outcome[lane])) continue;
      at_.open[lane] = 1;
      more = true;
    }
    if (!more) return;
    correct_lanes(at_, x);
  }
}

template class HostLanes<float>;
template class HostLanes<double>;
template class HostLanes<std::complex<float>>;
template class HostLanes<std::complex<double>>;

}  // namespace mfs::lanes
