#include "dae/mechanics/motions.hpp"

#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/joint_equations.hpp"

namespace mfs::dae {
namespace {

/// q_i - q_i(0) - f(t) = 0, one element for each i.
class CoordinateMotion final : public ElementGroup {
 public:
  CoordinateMotion(std::string name, std::vector<int> coordinates, std::vector<double> initial,
                   Function change)
      : name_(std::move(name)),
        coordinates_(std::move(coordinates)),
        initial_(std::move(initial)),
        change_(std::move(change)) {}

  int size() const override { return static_cast<int>(coordinates_.size()); }
  int local_coordinates() const override { return 1; }
  int local_constraints() const override { return 1; }
  const int* coordinates(int e) const override { return coordinates_.data() + e; }
  LocalStructure structure() const override { return {LocalStructure::Kind::zero}; }
  std::string name(int e) const override { return name_ + ", coordinate " + std::to_string(coordinates_[e]); }

  void residual(int e, const LocalState& state, LocalResidual& residual) const override {
    const Jet f = change_->at(state.t);
    residual.force[0] = state.lambda[0];
    residual.position[0] = state.q[0] - initial_[e] - f.value;
    residual.velocity[0] = state.v[0] - f.first;
    residual.acceleration[0] = state.a[0] - f.second;
  }
  void tangent(int, const LocalState&, LocalTangent& tangent) const override { tangent.position_q[0] = 1; }

 private:
  std::string name_;
  std::vector<int> coordinates_;
  std::vector<double> initial_;
  Function change_;
};

std::string owner_of(const std::string& name) {
  return "motion " + name;
}

void add_drive(MultibodyBuilder& builder, const std::string& name, const Attachment& a, const Attachment& b,
               const std::vector<JointEquation>& equations) {
  for (const JointEquation& equation : equations)
    if (!equation.function) throw InvalidInput(owner_of(name), "it has no function of time");
  add_joint_equations(builder, owner_of(name), a, b, equations);
}

}  // namespace

void add_rotation(MultibodyBuilder& builder, const std::string& name, const Attachment& a,
                  const Attachment& b, const Function& angle) {
  add_drive(builder, name, a, b, {{JointEquation::Kind::turned, 0, 0, angle}});
}

void add_translation(MultibodyBuilder& builder, const std::string& name, const Attachment& a,
                     const Attachment& b, const Function& distance) {
  add_drive(builder, name, a, b, {{JointEquation::Kind::apart, 2, 0, distance}});
}

void add_point_motion(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                      const std::array<Function, 3>& position) {
  std::vector<JointEquation> equations;
  for (int k = 0; k < 3; ++k)
    if (position[k]) equations.push_back({JointEquation::Kind::apart_ground, k, 0, position[k]});
  if (equations.empty()) throw InvalidInput(owner_of(name), "it has no function of time");
  add_drive(builder, name, {}, attachment, equations);
}

void add_coordinate_motion(MultibodyBuilder& builder, const std::string& name,
                           const std::vector<int>& coordinates, const Function& change) {
  if (!change) throw InvalidInput(owner_of(name), "it has no function of time");
  if (coordinates.empty()) throw InvalidInput(owner_of(name), "it moves no coordinate");
  std::vector<double> initial;
  for (const int i : coordinates) {
    if (i < 0 || i >= static_cast<int>(builder.initial_q().size()))
      throw InvalidInput(owner_of(name), "coordinate " + std::to_string(i) + " is not in the system");
    initial.push_back(builder.initial_q()[i]);
  }
  builder.add(std::make_shared<CoordinateMotion>(owner_of(name), coordinates, std::move(initial), change));
}

}  // namespace mfs::dae
