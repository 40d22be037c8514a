#include "dae/mechanics/measures.hpp"

#include <cmath>

#include <mfs/error.hpp>

#include "dae/mechanics/frame_pair.hpp"
#include "dae/mechanics/motions.hpp"
#include "dae/mechanics/single_element.hpp"

namespace mfs::dae {
namespace {

template <class T>
std::pair<T, T> sine_and_cosine(const T& x) {
  using std::cos, std::sin;
  return {T(sin(x)), T(cos(x))};
}
/// Eigen's own do not nest.
template <int N>
std::pair<Dual2<N>, Dual2<N>> sine_and_cosine(const Dual2<N>& x) {
  const auto [s, c] = sine_and_cosine(x.value());
  Dual2<N> sine = x, cosine = x;
  sine.value() = s;
  cosine.value() = c;
  for (int k = 0; k < N; ++k) {
    sine.derivatives()[k] = c * x.derivatives()[k];
    cosine.derivatives()[k] = -1.0 * s * x.derivatives()[k];
  }
  return {sine, cosine};
}

struct MeasureFormulas {
  static constexpr bool kNormalizes = false;
  std::string name;
  FramePair sides;
  Measure measure;
  int own;  // where the measure's coordinate is in the element's

  int count() const { return 1; }
  std::string direction(int) const { return {}; }

  template <class T>
  void positions(double, const T* q, T* x) const {
    const Side &a = sides.a, &b = sides.b;
    if (measure == Measure::angle) {
      const Triple<T> of_b = b.axis(q, 0);
      const std::pair<T, T> turn = sine_and_cosine(q[own]);
      *x = T(turn.second * dot(a.axis(q, 1), of_b) - turn.first * dot(a.axis(q, 0), of_b));
      return;
    }
    const Triple<T> d = b.place(q) - a.place(q);
    *x = T(length(a, d, q) - q[own]);
  }

 private:
  template <class T>
  T length(const Side& a, const Triple<T>& d, const T* q) const {
    using std::sqrt;
    if (measure == Measure::travel) return dot(a.axis(q, 2), d);
    if (measure != Measure::distance) return d[static_cast<int>(measure) - static_cast<int>(Measure::x)];
    const T square = dot(d, d);
    if (!(value_of(square) > 0)) throw InvalidInput(name, "its points have come together");
    return T(sqrt(square));
  }
};

/// N coordinates of frames.
template <int N>
int add_with(MultibodyBuilder& builder, const std::string& name, const std::vector<int>& frames,
             const FramePair& sides, Measure measure) {
  MeasureFormulas formulas{name, sides, measure, N};
  std::array<Taylor<double>, N + 1> q;
  std::array<int, N + 1> coordinates{};
  for (int k = 0; k < N; ++k) {
    coordinates[k] = frames[k];
    q[k] = {builder.initial_q()[frames[k]], builder.initial_v()[frames[k]], 0.0};
  }
  Taylor<double> w;
  if (measure == Measure::angle) {
    const Triple<Taylor<double>> of_b = sides.b.axis(q.data(), 0);
    w = atan2(dot(sides.a.axis(q.data(), 1), of_b), dot(sides.a.axis(q.data(), 0), of_b));
  } else {
    formulas.positions(0.0, q.data(), &w);  // with the coordinate 0
  }
  coordinates[N] = builder.add_measure_coordinate(name, w.c0, w.c1, measure != Measure::angle);
  builder.add(std::make_shared<ConstraintElement<MeasureFormulas, N + 1>>(name, coordinates, formulas));
  return coordinates[N];
}

}  // namespace

int add_measure(MultibodyBuilder& builder, const std::string& name, const Attachment& a, const Attachment& b,
                Measure measure) {
  const FramePair sides(a, b, name);
  std::vector<int> frames;
  for (const Attachment* side : {&a, &b})
    for (int k = 0; k < 7 && !side->frame.is_ground(); ++k) frames.push_back(side->frame.first + k);
  return frames.size() == 7 ? add_with<7>(builder, name, frames, sides, measure)
                            : add_with<14>(builder, name, frames, sides, measure);
}

int add_coordinate_measure(MultibodyBuilder& builder, const std::string& name, int coordinate) {
  const double q = builder.initial_q()[coordinate], v = builder.initial_v()[coordinate];
  const int own = builder.add_measure_coordinate(name, q, v, true);
  add_coordinate_motion(
      builder, name, {own},
      StateFunction(Expression("x"), {{StateFunction::Argument::Kind::coordinate, 0.0, coordinate}}),
      MotionFrom::zero);
  return own;
}

}  // namespace mfs::dae
