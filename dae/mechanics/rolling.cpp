#include "dae/mechanics/rolling.hpp"

#include <cmath>
#include <memory>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/frame_pair.hpp"
#include "dae/mechanics/joint_equations.hpp"
#include "dae/mechanics/single_element.hpp"

namespace mfs::dae {
namespace {

template <class T>
Triple<T> cross(const Triple<T>& x, const Triple<T>& y) {
  return {T(x[1] * y[2] - x[2] * y[1]), T(x[2] * y[0] - x[0] * y[2]), T(x[0] * y[1] - x[1] * y[0])};
}

struct RollingBase {
  FramePair sides;
  double radius;
  Roller roller;
  std::vector<std::string> directions;

  std::string direction(int i) const { return directions[static_cast<std::size_t>(i)]; }

  template <class T>
  Triple<T> arm(const T* q) const {
    using std::sqrt;
    const Triple<T> n = sides.a.axis(q, 2);
    if (roller == Roller::ball) return {T(-radius * n[0]), T(-radius * n[1]), T(-radius * n[2])};
    const Triple<T> e = sides.b.axis(q, 2);
    const T along = dot(n, e);
    const T square = 1.0 - along * along;
    const T factor = -radius / sqrt(square);
    return {T(factor * (n[0] - along * e[0])), T(factor * (n[1] - along * e[1])),
            T(factor * (n[2] - along * e[2]))};
  }
};

struct Touching : RollingBase {
  static constexpr bool kNormalizes = false;
  int count() const { return 1; }

  template <class T>
  void positions(double, const T* q, T* x) const {
    *x = dot(sides.a.axis(q, 2), sides.b.place(q) + arm(q) - sides.a.place(q));
  }
};

struct Sticking : RollingBase {
  int count() const { return 2; }

  template <class T>
  void rates(double, const T* q, const T* v, T* x) const {
    const Triple<T> place = sides.b.place(q) + arm(q);
    const Triple<T> u = velocity(sides.b, place, q, v) - velocity(sides.a, place, q, v);
    for (int k = 0; k < 2; ++k) x[k] = dot(sides.a.axis(q, k), u);
  }

 private:
  /// Of the material of a side's frame at a place: w = 2 (p0 p' - p0' p + p x p') in ground axes.
  template <class T>
  static Triple<T> velocity(const Side& side, const Triple<T>& place, const T* q, const T* v) {
    if (side.first < 0) return {T(0.0), T(0.0), T(0.0)};
    const T *r = q + side.first, *p = r + 3, *r_rate = v + side.first, *p_rate = r_rate + 3;
    const Triple<T> e{p[1], p[2], p[3]}, e_rate{p_rate[1], p_rate[2], p_rate[3]}, turn = cross(e, e_rate);
    Triple<T> w;
    for (int i = 0; i < 3; ++i) w[i] = 2.0 * (p[0] * e_rate[i] - p_rate[0] * e[i] + turn[i]);
    return Triple<T>{r_rate[0], r_rate[1], r_rate[2]} + cross(w, place - Triple<T>{r[0], r[1], r[2]});
  }
};

}  // namespace

Eigen::Vector3d contact_arm(const Eigen::Vector3d& normal, const Eigen::Vector3d& axle, double radius,
                            Roller roller) {
  if (roller == Roller::ball) return -radius * normal;
  const Eigen::Vector3d up = normal - normal.dot(axle) * axle;
  if (!(up.norm() > 1e-6)) throw InvalidInput("axis", "the wheel lies flat");
  return -radius * up.normalized();
}

void add_rolling(MultibodyBuilder& builder, const std::string& owner, const Attachment& a,
                 const Attachment& b, double radius, Roller roller) {
  if (!(radius > 0) || !std::isfinite(radius)) throw InvalidInput(owner, "its radius is not positive");
  FramePair sides(a, b, owner);
  builder.note_length(b.frame.first, radius);
  using Kind = JointEquation::Kind;
  const auto directions = [&](std::vector<JointEquation> equations) {
    return directions_of(builder, a, b, equations);
  };
  const RollingBase touching{sides, radius, roller, directions({{Kind::apart, 2}})};
  const RollingBase sticking{sides, radius, roller, directions({{Kind::apart, 0}, {Kind::apart, 1}})};
  builder.add(make_pair_element<ConstraintElement>(owner, a, b, Touching{touching}));
  builder.add(make_pair_element<VelocityConstraintElement>(owner, a, b, Sticking{sticking}));
}

}  // namespace mfs::dae
