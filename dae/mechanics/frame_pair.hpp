// Two attachments, one of which may be on the ground, as formulas see them: the coordinates of an element are
// those of the moving frames, 7 or 14, and the rest is fixed.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/rotation.hpp"

namespace mfs::dae {

/// One side: where its frame's coordinates begin in the element's, or -1 on the ground.
struct Side {
  int first = -1;
  Eigen::Vector3d point;
  Eigen::Matrix3d axes;

  template <class T>
  Triple<T> place(const T* q) const {
    if (first < 0) return {T(point[0]), T(point[1]), T(point[2])};
    const Triple<T> arm = rotate(q + first + 3, point);
    return {T(q[first] + arm[0]), T(q[first + 1] + arm[1]), T(q[first + 2] + arm[2])};
  }
  /// Axis k in ground axes.
  template <class T>
  Triple<T> axis(const T* q, int k) const {
    if (first < 0) return {T(axes(0, k)), T(axes(1, k)), T(axes(2, k))};
    return rotate(q + first + 3, Eigen::Vector3d(axes.col(k)));
  }
  /// Euler parameters of the axes.
  template <class T>
  Quadruple<T> orientation(const T* q) const {
    const Eigen::Vector4d p = euler_parameters(axes);
    if (first < 0) return {T(p[0]), T(p[1]), T(p[2]), T(p[3])};
    const T* frame = q + first + 3;
    return product(Quadruple<T>{frame[0], frame[1], frame[2], frame[3]},
                   Quadruple<double>{p[0], p[1], p[2], p[3]});
  }
};

/// The sides `a` and `b` of what an error message calls `owner`. Throws InvalidInput where both are the same
/// frame, or an attachment is no point with axes.
struct FramePair {
  Side a, b;

  FramePair(const Attachment& on_a, const Attachment& on_b, const std::string& owner)
      : a{-1, on_a.point, on_a.axes}, b{-1, on_b.point, on_b.axes} {
    if (on_a.frame.first == on_b.frame.first)
      throw InvalidInput(owner, "both sides are on the same body, " + on_a.frame.name);
    for (const Attachment* side : {&on_a, &on_b}) {
      if (!side->point.allFinite())
        throw InvalidInput(owner, "its point on " + side->frame.name + " is not finite");
      check_axes(side->axes, owner + " on " + side->frame.name);
    }
    if (!on_a.frame.is_ground()) a.first = 0;
    if (!on_b.frame.is_ground()) b.first = on_a.frame.is_ground() ? 0 : 7;
  }
};

/// Makes the element Element<Formulas, 7 or 14> of formulas that hold a FramePair of `a` and `b`.
template <template <class, int> class Element, class Formulas>
std::shared_ptr<const ElementGroup> make_pair_element(const std::string& name, const Attachment& a,
                                                      const Attachment& b, Formulas formulas) {
  std::array<int, 14> both{};
  for (int k = 0; k < 7; ++k) {
    both[k] = a.frame.first + k;
    both[7 + k] = b.frame.first + k;
  }
  if (!a.frame.is_ground() && !b.frame.is_ground())
    return std::make_shared<Element<Formulas, 14>>(name, both, std::move(formulas));
  std::array<int, 7> one{};
  for (int k = 0; k < 7; ++k) one[k] = both[(a.frame.is_ground() ? 7 : 0) + k];
  return std::make_shared<Element<Formulas, 7>>(name, one, std::move(formulas));
}

}  // namespace mfs::dae
