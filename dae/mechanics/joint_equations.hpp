// The few equations of which all joints and motions between two frames are made (Haug 1989, chapter 9). P and
// the axes x, y, z are those of the attachments on a and b, d = P_b - P_a, f a function of time:
//
//   apart_ground k      e_k . d           = f(t)    e_k an axis of the ground
//   apart k             a_k . d           = f(t)    "dot-2"
//   perpendicular k, l  a_k . b_l         = 0       "dot-1"
//   turned              cos f(t) a_y . b_x - sin f(t) a_x . b_x = 0     b_x at the angle f(t) from a_x about
//   a_z
//
// A perpendicular pair and the angle have a second solution half a turn away, which a motion that begins at
// the first does not reach.
#pragma once

#include <utility>
#include <vector>

#include "dae/mechanics/frame_pair.hpp"
#include "dae/mechanics/smooth_function.hpp"
#include "dae/mechanics/taylor.hpp"

namespace mfs::dae {

struct JointEquation {
  enum class Kind { apart_ground, apart, perpendicular, turned };
  Kind kind;
  int k = 0, l = 0;
  Function function = nullptr;  ///< none: zero
};

class JointEquations {
 public:
  JointEquations(FramePair sides, std::vector<JointEquation> equations)
      : sides_(std::move(sides)), equations_(std::move(equations)) {}

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
    return T(cosine * dot(a.axis(q, 1), x) - sine * dot(a.axis(q, 0), x));
  }

  FramePair sides_;
  std::vector<JointEquation> equations_;
};

}  // namespace mfs::dae
