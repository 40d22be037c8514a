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

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "dae/mechanics/frame_pair.hpp"
#include "dae/mechanics/multibody.hpp"
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
  /// What equations are made of, in ground axes: axes of the ground, d, axes of a and of b.
  enum class Vector { ground_x, ground_y, ground_z, apart, a_x, a_y, a_z, b_x, b_y, b_z };
  static constexpr std::size_t kVectors = 10;
  using Product = std::pair<Vector, Vector>;

  /// `directions`: of each equation.
  JointEquations(FramePair sides, std::vector<JointEquation> equations, std::vector<std::string> directions)
      : sides_(std::move(sides)), equations_(std::move(equations)), directions_(std::move(directions)) {}

  std::string direction(int i) const { return directions_[static_cast<std::size_t>(i)]; }
  int count() const { return static_cast<int>(equations_.size()); }
  const FramePair& sides() const { return sides_; }
  const std::vector<JointEquation>& all() const { return equations_; }

  /// The scalar products in an equation: one, or the cosine and the sine of the angle. The second of a pair
  /// may not be an axis of the ground.
  static std::array<Product, 2> products(const JointEquation& equation) {
    using Kind = JointEquation::Kind;
    const auto axis = [](Vector first, int k) { return static_cast<Vector>(static_cast<int>(first) + k); };
    switch (equation.kind) {
      case Kind::apart_ground:
        return repeated({axis(Vector::ground_x, equation.k), Vector::apart});
      case Kind::apart:
        return repeated({axis(Vector::a_x, equation.k), Vector::apart});
      case Kind::perpendicular:
        return repeated({axis(Vector::a_x, equation.k), axis(Vector::b_x, equation.l)});
      case Kind::turned:
        break;
    }
    return {{{Vector::a_x, Vector::b_x}, {Vector::a_y, Vector::b_x}}};
  }

  /// The left side of `turned`.
  template <class T>
  static T angle(const Jet& f, const T& along, const T& across) {
    const double s = std::sin(f.value), c = std::cos(f.value), square = f.first * f.first;
    const T sine = AlongTime<T>::of({s, c * f.first, c * f.second - s * square});
    const T cosine = AlongTime<T>::of({c, -s * f.first, -s * f.second - c * square});
    return T(2.0 * (cosine * across - sine * along) / (T(1.0) + cosine * along + sine * across));
  }

 private:
  static std::array<Product, 2> repeated(Product product) { return {product, product}; }

  FramePair sides_;
  std::vector<JointEquation> equations_;
  std::vector<std::string> directions_;
};

/// Adds them as constraints of what an error message calls `owner`. Throws InvalidInput("`owner`") where both
/// sides are on the same body or an attachment is no point with axes.
void add_joint_equations(MultibodyBuilder& builder, const std::string& owner, const Attachment& a,
                         const Attachment& b, const std::vector<JointEquation>& equations);

}  // namespace mfs::dae
