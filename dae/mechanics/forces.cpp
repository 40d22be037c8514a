#include "dae/mechanics/forces.hpp"

#include <cmath>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/frame_pair.hpp"
#include "dae/mechanics/rigid_interface.hpp"
#include "dae/mechanics/single_element.hpp"

namespace mfs::dae {
namespace {

struct BushingFormulas {
  FramePair sides;
  std::array<double, 6> stiffness, damping;

  int count() const { return 6; }
  double relaxed(int) const { return 0.0; }

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
};

struct SpringFormulas {
  FramePair sides;
  std::string name;
  double damping, free_length;
  Function force;  // of the elongation

  int count() const { return 1; }
  double relaxed(int) const { return free_length; }

  template <class T>
  void positions(double, const T* q, T* x) const {
    using std::sqrt;
    const Triple<T> d = sides.b.place(q) - sides.a.place(q);
    const T square = dot(d, d);
    if (!(value_of(square) > 0)) throw InvalidInput("spring " + name, "its ends have come together");
    x[0] = sqrt(square);
  }
  Reaction reaction(double, int, double length, double rate) const {
    const Jet elastic = force->at(length - free_length);
    return {elastic.value + damping * rate, elastic.first, damping};
  }
};

struct PointForce {
  FramePair sides;
  std::array<Function, 3> force;

  int count() const { return 3; }

  template <class T>
  void positions(double, const T* q, T* x) const {
    const Triple<T> place = sides.b.place(q);
    for (int k = 0; k < 3; ++k) x[k] = place[k];
  }
  Reaction reaction(double t, int i, double, double) const {
    return {force[i] ? -force[i]->at(t).value : 0.0};
  }
};

class NodalForce final : public ElementGroup {
 public:
  NodalForce(std::string name, std::vector<int> coordinates, std::vector<double> fractions,
             std::array<Function, 3> force)
      : name_(std::move(name)),
        coordinates_(std::move(coordinates)),
        fractions_(std::move(fractions)),
        force_(std::move(force)) {}

  int size() const override { return static_cast<int>(fractions_.size()); }
  int local_coordinates() const override { return 3; }
  const int* coordinates(int e) const override { return coordinates_.data() + 3 * e; }
  LocalStructure structure() const override { return {LocalStructure::Kind::zero}; }
  std::string name(int) const override { return name_; }

  void residual(int e, const LocalState& state, LocalResidual& residual) const override {
    for (int k = 0; k < 3; ++k)
      if (force_[k]) residual.force[k] = -fractions_[e] * force_[k]->at(state.t).value;
  }
  void tangent(int, const LocalState&, LocalTangent&) const override {}

 private:
  std::string name_;
  std::vector<int> coordinates_;
  std::vector<double> fractions_;
  std::array<Function, 3> force_;
};

void check_not_negative(double value, const std::string& owner, const char* what) {
  if (!(value >= 0) || !std::isfinite(value)) throw InvalidInput(owner, std::string(what) + " is negative");
}

void check_any(const std::array<Function, 3>& force, const std::string& owner) {
  if (!force[0] && !force[1] && !force[2]) throw InvalidInput(owner, "it has no function of time");
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
  if (initial_point(builder, spring.a) == initial_point(builder, spring.b))
    throw InvalidInput(owner, "its ends are together");
  const Function force = spring.force ? spring.force : linear_function(0.0, spring.stiffness);
  builder.add(make_pair_element<CompliantElement>(
      owner, spring.a, spring.b,
      SpringFormulas{sides, spring.name, spring.damping, spring.free_length, force}));
}

void add_point_force(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                     const std::array<Function, 3>& force) {
  const std::string owner = "force " + name;
  check_any(force, owner);
  const Attachment ground;
  builder.add(make_pair_element<CompliantElement>(owner, ground, attachment,
                                                  PointForce{FramePair(ground, attachment, owner), force}));
}

void add_nodal_force(MultibodyBuilder& builder, const std::string& name, CoordinateRange body,
                     const std::vector<int>& nodes, const std::vector<double>& fractions,
                     const std::array<Function, 3>& force) {
  const std::string owner = "force " + name;
  check_any(force, owner);
  if (nodes.empty()) throw InvalidInput(owner, "it acts on no node");
  if (fractions.size() != nodes.size())
    throw InvalidInput(owner, std::to_string(nodes.size()) + " nodes, but " +
                                  std::to_string(fractions.size()) + " fractions");
  builder.add(std::make_shared<NodalForce>(owner, node_coordinates(body, nodes, owner), fractions, force));
}

}  // namespace mfs::dae
