#include "dae/mechanics/motions.hpp"

#include <numeric>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/joint_equations.hpp"
#include "dae/mechanics/whole_group.hpp"

namespace mfs::dae {
namespace {

/// q_i - q_i(0) - f(t, u) = 0, one element for each i; u are other coordinates, the same for all.
///
///   coordinates of an element   q_i | u
class CoordinateMotion final : public WholeGroup {
 public:
  CoordinateMotion(std::string name, std::vector<int> moved, std::vector<double> from, StateFunction change)
      : name_(std::move(name)),
        moved_(std::move(moved)),
        from_(std::move(from)),
        change_(std::move(change)),
        count_(1 + static_cast<int>(change_.coordinates().size())),
        consecutive_(static_cast<std::size_t>(count_)) {
    std::iota(consecutive_.begin(), consecutive_.end(), 0);
    for (const int i : moved_) {
      coordinates_.push_back(i);
      coordinates_.insert(coordinates_.end(), change_.coordinates().begin(), change_.coordinates().end());
    }
  }

  int size() const override { return static_cast<int>(moved_.size()); }
  int local_coordinates() const override { return count_; }
  int local_constraints() const override { return 1; }
  const int* coordinates(int e) const override { return coordinates_.data() + count_ * e; }
  LocalStructure structure() const override {
    LocalStructure structure;
    if (count_ == 1) structure.force_q = LocalStructure::Kind::zero;
    structure.coupled_from = 1;
    return structure;
  }
  void add_marks(const TimeSpan& span, std::vector<double>& marks) const override {
    change_.add_marks(span, marks);
  }
  void add_watched(WatchedFunctions& functions) const override {
    functions.push_back(std::make_shared<StateFunction>(change_));
  }
  std::string name(int e) const override { return name_ + ", coordinate " + std::to_string(moved_[e]); }

  void residual(int e, const LocalState& state, LocalResidual& residual) const override {
    std::vector<Taylor<double>> by_u;
    const Taylor<double> f = change_.along({state.t, 1.0, 0.0}, others(state, consecutive_.data()), by_u);
    residual.force[0] = state.lambda[0];
    for (int j = 1; j < count_; ++j) residual.force[j] = -state.lambda[0] * by_u[j - 1].c0;
    residual.position[0] = state.q[0] - from_[e] - f.c0;
    residual.velocity[0] = state.v[0] - f.c1;
    residual.acceleration[0] = state.a[0] - 2 * f.c2;
  }

  void residual_of_all(const StateView& state, const int* coordinates, int row,
                       const ResidualView& residual) const override {
    std::vector<Taylor<double>> by_u;
    const Taylor<double> f = change_.along({state.t, 1.0, 0.0}, others(state, coordinates), by_u);
    double sum = 0.0;
    for (int e = 0; e < size(); ++e, ++row) {
      const int i = coordinates[count_ * e];
      residual.force[i] += state.lambda[row];
      sum += state.lambda[row];
      residual.position[row] = state.q[i] - from_[e] - f.c0;
      residual.velocity[row] = state.v[i] - f.c1;
      residual.acceleration[row] = state.a[i] - 2 * f.c2;
    }
    for (int j = 1; j < count_; ++j) residual.force[coordinates[j]] -= sum * by_u[j - 1].c0;
  }

  void tangent_of_all(const StateView& state, int row, const TangentOfAll& tangent) const override {
    std::vector<Taylor<double>> u = others(state, coordinates(0)), by_u;
    change_.along({state.t, 1.0, 0.0}, u, by_u);
    const auto set = [&](double* values, double first, const auto& by_other) {
      if (values == nullptr) return;
      const int* rank = tangent.rank;
      for (int e = 0; e < size(); ++e, values += count_, rank += count_) {
        values[rank[0]] = first;
        for (int j = 1; j < count_; ++j) values[rank[j]] = by_other(by_u[j - 1]);
      }
    };
    set(tangent.position_q, 1, [](const Taylor<double>& f_u) { return -f_u.c0; });
    set(tangent.velocity_q, 0, [](const Taylor<double>& f_u) { return -f_u.c1; });
    set(tangent.acceleration_q, 0, [](const Taylor<double>& f_u) { return -2 * f_u.c2; });
    set(tangent.acceleration_v, 0, [](const Taylor<double>& f_u) { return -2 * f_u.c1; });
    if (tangent.force_q == nullptr) return;
    const double sum = std::accumulate(state.lambda + row, state.lambda + row + size(), 0.0);
    // Along the motion in which u_j alone changes, the rate of f_u is its derivative by u_j.
    for (Taylor<double>& coordinate : u) coordinate.c1 = coordinate.c2 = 0;
    for (int j = 1; j < count_; ++j) {
      u[j - 1].c1 = 1;
      change_.along(state.t, u, by_u);
      u[j - 1].c1 = 0;
      for (int i = 1; i < count_; ++i) tangent.force_q[i * count_ + j] = -sum * by_u[i - 1].c1;
    }
  }

 private:
  /// Of the coordinates that the function depends on; `place`: where those of an element are.
  template <class State>
  std::vector<Taylor<double>> others(const State& state, const int* place) const {
    std::vector<Taylor<double>> u;
    for (int j = 1; j < count_; ++j)
      u.push_back({state.q[place[j]], state.v[place[j]], 0.5 * state.a[place[j]]});
    return u;
  }

  std::string name_;
  std::vector<int> moved_;
  std::vector<double> from_;
  StateFunction change_;
  int count_;
  std::vector<int> consecutive_;  // 0, 1, ...: an element's own
  std::vector<int> coordinates_;
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
                           const std::vector<int>& coordinates, const StateFunction& change,
                           MotionFrom from) {
  if (!change) throw InvalidInput(owner_of(name), "it has no function of time");
  if (coordinates.empty()) throw InvalidInput(owner_of(name), "it moves no coordinate");
  if (change.has_rates()) throw InvalidInput(owner_of(name), "it must not depend on rates");
  std::vector<double> zero;
  for (const int i : coordinates) {
    if (i < 0 || i >= static_cast<int>(builder.initial_q().size()))
      throw InvalidInput(owner_of(name), "coordinate " + std::to_string(i) + " is not in the system");
    for (const int other : change.coordinates())
      if (other == i) throw InvalidInput(owner_of(name), "it depends on what it moves");
    zero.push_back(from == MotionFrom::initial ? builder.initial_q()[i] : 0.0);
  }
  builder.add(std::make_shared<CoordinateMotion>(owner_of(name), coordinates, std::move(zero), change));
}

}  // namespace mfs::dae
