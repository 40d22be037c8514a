#include "dae/mechanics/forces.hpp"

#include <cmath>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/compliant_element.hpp"
#include "dae/mechanics/frame_pair.hpp"

namespace mfs::dae {
namespace {

struct BushingFormulas {
  FramePair sides;
  std::array<double, 6> stiffness, damping;

  int count() const { return 6; }

  template <class T>
  void positions(double, const T* q, T* x) const {
    const Side &a = sides.a, &b = sides.b;
    const Triple<T> d = b.place(q) - a.place(q);
    for (int k = 0; k < 3; ++k) x[k] = dot(a.axis(q, k), d);
    const Quadruple<T> of_a = a.orientation(q);
    const Quadruple<T> back{of_a[0], T(-of_a[1]), T(-of_a[2]), T(-of_a[3])};
    const Quadruple<T> turn = product(back, b.orientation(q));
    const double sign =
        value_of(turn[0]) < 0 ? -1.0 : 1.0;  // p and -p are the same rotation; the smaller one
    const T scale = T(4.0 * sign) / T(T(1.0) + sign * turn[0]);
    for (int k = 0; k < 3; ++k) x[3 + k] = scale * turn[1 + k];
  }
  Reaction reaction(double, int i, double x, double rate) const {
    return {stiffness[i] * x + damping[i] * rate, stiffness[i], damping[i]};
  }
  double energy(int i, double x) const { return 0.5 * stiffness[i] * x * x; }
};

struct SpringFormulas : SpringLaw {
  static constexpr bool kIsLength = true;
  FramePair sides;
  std::string name;

  template <class T>
  void positions(double, const T* q, T* x) const {
    using std::sqrt;
    const Triple<T> d = sides.b.place(q) - sides.a.place(q);
    const T square = dot(d, d);
    if (!(value_of(square) > 0)) throw InvalidInput("spring " + name, "its ends have come together");
    x[0] = sqrt(square);
  }
};

/// Of no free length, whose force k d needs no direction: the ends may be together.
struct ShortSpringFormulas {
  FramePair sides;
  double stiffness;

  int count() const { return 3; }

  template <class T>
  void positions(double, const T* q, T* x) const {
    const Triple<T> d = sides.b.place(q) - sides.a.place(q);
    for (int k = 0; k < 3; ++k) x[k] = d[k];
  }
  Reaction reaction(double, int, double x, double) const { return {stiffness * x, stiffness, 0.0}; }
  double energy(int, double x) const { return 0.5 * stiffness * x * x; }
};

void check_not_negative(double value, const std::string& owner, const char* what) {
  if (!(value >= 0) || !std::isfinite(value)) throw InvalidInput(owner, std::string(what) + " is negative");
}

Eigen::Vector3d initial_point(const MultibodyBuilder& builder, const Attachment& attachment) {
  const Placement placement = initial_placement(builder, attachment.frame);
  return placement.position + placement.rotation * attachment.point;
}

}  // namespace

void add_bushing(MultibodyBuilder& builder, const Bushing& bushing) {
  const std::string owner = "bushing " + bushing.name;
  for (int k = 0; k < 6; ++k) {
    check_not_negative(bushing.stiffness[k], owner, "a stiffness");
    check_not_negative(bushing.damping[k], owner, "a damping");
  }
  builder.add(make_pair_element<CompliantElement>(
      owner, bushing.a, bushing.b,
      BushingFormulas{FramePair(bushing.a, bushing.b, owner), bushing.stiffness, bushing.damping}));
}

void add_spring_damper(MultibodyBuilder& builder, const SpringDamper& spring) {
  const std::string owner = "spring " + spring.name;
  check_not_negative(spring.stiffness, owner, "its stiffness");
  check_not_negative(spring.damping, owner, "its damping");
  check_not_negative(spring.free_length, owner, "its free length");
  if (spring.force && spring.stiffness > 0)
    throw InvalidInput(owner, "it has both a stiffness and a function");
  const FramePair sides(spring.a, spring.b, owner);
  if (spring.free_length == 0 && spring.damping == 0 && !spring.force) {
    builder.add(make_pair_element<CompliantElement>(owner, spring.a, spring.b,
                                                    ShortSpringFormulas{sides, spring.stiffness}));
    return;
  }
  if (initial_point(builder, spring.a) == initial_point(builder, spring.b))
    throw InvalidInput(owner,
                       "its ends are together, so that its force has no direction: that is only good "
                       "for a stiffness alone, with a free length of 0");
  const Function force = spring.force ? spring.force : linear_function(0.0, spring.stiffness);
  builder.add(make_pair_element<CompliantElement>(
      owner, spring.a, spring.b,
      SpringFormulas{{spring.free_length, spring.damping, force}, sides, spring.name}));
}

}  // namespace mfs::dae
