// The few equations of which all joints and motions between two frames are made (Haug 1989, chapter 9). P and
// the axes x, y, z are those of the attachments on a and b, d = P_b - P_a, f a function of time:
//
//   apart_ground k      e_k . d           = f(t)    e_k an axis of the ground
//   apart k             a_k . d           = f(t)    "dot-2"
//   perpendicular k, l  a_k . b_l         = 0       "dot-1"
//   turned              2 tan((x - f(t)) / 2) = 0    b_x at the angle x = f(t) from a_x about a_z, from
//                                                    cos x = a_x . b_x and sin x = a_y . b_x
//
// A perpendicular pair has a second solution half a turn away, which a motion that begins at the first does
// not reach. The angle has none: there its equation has a pole.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "dae/mechanics/frame_pair.hpp"
#include "dae/mechanics/single_element.hpp"
#include "dae/mechanics/smooth_function.hpp"
#include "dae/mechanics/taylor.hpp"

namespace mfs::dae {

struct JointEquation {
  enum class Kind { apart_ground, apart, perpendicular, turned };
  Kind kind;
  int k = 0, l = 0;
  Function function = nullptr;  ///< none: zero
};

/// What each of `equations` between `a` and `b` holds, as an error message says it: "along ground x", "about
/// [0 0 1]" (in ground axes, when time begins).
std::vector<std::string> directions_of(const MultibodyBuilder& builder, const Attachment& a,
                                       const Attachment& b, const std::vector<JointEquation>& equations);

class JointEquations {
 public:
  static constexpr bool kNormalizes = false;

  /// `directions`: of each equation.
  JointEquations(FramePair sides, std::vector<JointEquation> equations, std::vector<std::string> directions)
      : sides_(std::move(sides)), equations_(std::move(equations)), directions_(std::move(directions)) {}

  std::string direction(int i) const { return directions_[static_cast<std::size_t>(i)]; }
  int count() const { return static_cast<int>(equations_.size()); }

  template <class T>
  void positions(double t, const T* q, T* x) const {
    for (const JointEquation& equation : equations_) *x++ = left_side(equation, t, q);
  }

 private:
  template <class T>
  T left_side(const JointEquation& equation, double t, const T* q) const {
    using Kind = JointEquation::Kind;
    const Side &a = sides_.a, &b = sides_.b;
    const Jet f = equation.function ? equation.function->at(t) : Jet{};
    switch (equation.kind) {
      case Kind::apart_ground:
        return T(b.place(q)[equation.k] - a.place(q)[equation.k] - AlongTime<T>::of(f));
      case Kind::apart:
        return T(dot(a.axis(q, equation.k), b.place(q) - a.place(q)) - AlongTime<T>::of(f));
      case Kind::perpendicular:
        return dot(a.axis(q, equation.k), b.axis(q, equation.l));
      case Kind::turned:
        break;
    }
    const double s = std::sin(f.value), c = std::cos(f.value), square = f.first * f.first;
    const T sine = AlongTime<T>::of({s, c * f.first, c * f.second - s * square});
    const T cosine = AlongTime<T>::of({c, -s * f.first, -s * f.second - c * square});
    const Triple<T> x = b.axis(q, 0);
    const T along = dot(a.axis(q, 0), x), across = dot(a.axis(q, 1), x);
    return T(2.0 * (cosine * across - sine * along) / (T(1.0) + cosine * along + sine * across));
  }

  FramePair sides_;
  std::vector<JointEquation> equations_;
  std::vector<std::string> directions_;
};

/// Adds them as constraints of what an error message calls `owner`. Throws InvalidInput("`owner`") where both
/// sides are on the same body or an attachment is no point with axes.
inline void add_joint_equations(MultibodyBuilder& builder, const std::string& owner, const Attachment& a,
                                const Attachment& b, const std::vector<JointEquation>& equations) {
  FramePair sides(a, b, owner);
  builder.add(make_pair_element<ConstraintElement>(
      owner, a, b, JointEquations(std::move(sides), equations, directions_of(builder, a, b, equations))));
}

}  // namespace mfs::dae
