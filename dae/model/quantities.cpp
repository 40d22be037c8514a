#include "dae/model/quantities.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include <mfs/error.hpp>

#include "parts/comma_list.hpp"

namespace mfs::dae {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Strings = std::vector<std::string>;

const Strings kXyz{"x", "y", "z"}, kWxyz{"w", "x", "y", "z"}, kTensor{"xx", "yy", "zz", "xy", "yz", "xz"};

void put(const Vector3d& vector, double* values) {
  std::copy_n(vector.data(), 3, values);
}

/// Collects the quantities of one place.
class Place {
 public:
  Place(std::vector<Quantity>& list, std::string place) : list_(list), place_(std::move(place)) {}

  template <class Measure>
  Quantity& number(const std::string& name, const std::string& unit, const Measure& measure) {
    list_.push_back(
        {place_, name, unit, {}, [measure](Measurement& m, double* values) { *values = measure(m); }});
    return list_.back();
  }
  template <class Measure>
  Quantity& vector(const std::string& name, const std::string& unit, const Measure& measure) {
    list_.push_back(
        {place_, name, unit, kXyz, [measure](Measurement& m, double* values) { put(measure(m), values); }});
    return list_.back();
  }
  Quantity& array(const std::string& name, const std::string& unit, const Strings& components,
                  std::function<void(Measurement&, double*)> measure) {
    list_.push_back({place_, name, unit, components, std::move(measure)});
    return list_.back();
  }

 private:
  std::vector<Quantity>& list_;
  std::string place_;
};

/// motion: Measurement& -> something with these six.
template <class Motion>
void add_body_motion(Place& place, const Motion& motion) {
  place.vector("position", "m", [motion](Measurement& m) { return motion(m).position; });
  place.vector("velocity", "m/s", [motion](Measurement& m) { return motion(m).velocity; });
  place.vector("acceleration", "m/s2", [motion](Measurement& m) { return motion(m).acceleration; });
  place.vector("angular_velocity", "rad/s", [motion](Measurement& m) { return motion(m).angular_velocity; });
  place.vector("angular_acceleration", "rad/s2",
               [motion](Measurement& m) { return motion(m).angular_acceleration; });
}

template <class EnergyOf>
void add_energy(Place& place, bool is_elastic, const EnergyOf& energy_of) {
  place.number("kinetic_energy", "J", [energy_of](Measurement& m) { return energy_of(m).kinetic; });
  place.number("potential_energy", "J", [energy_of](Measurement& m) { return energy_of(m).potential; });
  if (is_elastic)
    place.number("elastic_energy", "J", [energy_of](Measurement& m) { return energy_of(m).elastic; });
}

void add_rigid_body(Place place, std::size_t i) {
  add_body_motion(place,
                  [i](Measurement& m) { return frame_motion(m.model().rigid_bodies[i].frame, m.state()); });
  place.array("orientation", "", kWxyz, [i](Measurement& m, double* values) {
    const auto first = static_cast<std::size_t>(m.model().rigid_bodies[i].frame.first);
    const Eigen::Vector4d p = Eigen::Map<const Eigen::Vector4d>(&m.state().q[first + 3]).normalized();
    std::copy_n(p.data(), 4, values);
  });
  add_energy(place, false,
             [i](Measurement& m) { return energy({m.model().rigid_bodies[i].element}, m.state()); });
}

void add_flexible_body(Place place, std::size_t i) {
  add_body_motion(place, [i](Measurement& m) { return m.motion(i); });
  place.array("orientation", "", kWxyz, [i](Measurement& m, double* values) {
    const Eigen::Vector4d p = quaternion(m.motion(i).rotation);
    std::copy_n(p.data(), 4, values);
  });
  add_energy(place, true, [i](Measurement& m) { return m.flexible_energy(i); });
  place.number("von_mises", "Pa", [i](Measurement& m) { return m.stress(i).largest; });
}

void add_joint(Place place, std::size_t i, const ModelJoint& joint) {
  const auto at = [i](Measurement& m) -> const ModelJoint& { return m.model().joints[i]; };
  const auto reaction_of = [at](Measurement& m) { return reaction(at(m), m.state()); };
  const auto axes = [at](Measurement& m) {
    return Matrix3d(frame_motion(at(m).a.frame, m.state()).rotation * at(m).a.axes);
  };
  place.vector("position", "m", [at](Measurement& m) { return joint_position(at(m), m.state()); });
  place.array("orientation", "", kWxyz, [axes](Measurement& m, double* values) {
    const Eigen::Vector4d p = quaternion(axes(m));
    std::copy_n(p.data(), 4, values);
  });
  place.vector("reaction_force", "N", [reaction_of](Measurement& m) { return reaction_of(m).force; });
  place.vector("reaction_moment", "Nm", [reaction_of](Measurement& m) { return reaction_of(m).moment; });
  place.vector("reaction_force_in_joint_axes", "N", [reaction_of, axes](Measurement& m) {
    return Vector3d(axes(m).transpose() * reaction_of(m).force);
  });
  place.vector("reaction_moment_in_joint_axes", "Nm", [reaction_of, axes](Measurement& m) {
    return Vector3d(axes(m).transpose() * reaction_of(m).moment);
  });
  const int angles = angles_of(joint.kind);
  if (angles > 0) {
    const Strings components = angles == 2 ? Strings{"about_a", "about_b"} : Strings{};
    place.array("angle", "rad", components, [i](Measurement& m, double* values) {
      const std::vector<double> angle = m.account().angles(i, m.state());
      std::copy(angle.begin(), angle.end(), values);
    });
    place.array("angle_rate", "rad/s", components, [at](Measurement& m, double* values) {
      const std::vector<double> rate = joint_motion(at(m), m.state()).angle_rate;
      std::copy(rate.begin(), rate.end(), values);
    });
  }
  if (!slides(joint.kind)) return;
  place.number("travel", "m", [at](Measurement& m) { return joint_motion(at(m), m.state()).travel; });
  place.number("travel_rate", "m/s",
               [at](Measurement& m) { return joint_motion(at(m), m.state()).travel_rate; });
}

using Actions = std::vector<ModelAction> MultibodyModel::*;

/// On the last side; ground where there is one only.
Wrench wrench_of(const ModelAction& action, const State& state) {
  const Attachment ground, &b = action.sides.back(),
                           &a = action.sides.size() > 1 ? action.sides.front() : ground;
  if (action.along.number < 0) return wrench_on(b, a, action.elements, state);
  // What ties the coordinate to the bodies belongs to all that use it.
  const Vector3d axis = frame_motion(a.frame, state).rotation * a.axes.col(2);
  Wrench wrench;
  (action.along.turns ? wrench.moment : wrench.force) =
      force_along(action.along.number, action.elements, state) * axis;
  return wrench;
}

void add_action(Place place, std::size_t i, Actions actions, const ModelAction& action) {
  const auto at = [i, actions](Measurement& m) -> const ModelAction& { return (m.model().*actions)[i]; };
  if (action.sides.empty()) {
    place.vector("force", "N",
                 [at](Measurement& m) { return force_on_nodes(m.model(), at(m).elements, m.state()); });
  } else {
    place.vector("force", "N", [at](Measurement& m) { return wrench_of(at(m), m.state()).force; });
    place.vector("moment", "Nm", [at](Measurement& m) { return wrench_of(at(m), m.state()).moment; });
  }
  if (actions == &MultibodyModel::forces)
    place.number("elastic_energy", "J",
                 [at](Measurement& m) { return energy(at(m).elements, m.state()).elastic; });
  place.number("power", "W", [at](Measurement& m) {
    const Power now = power(at(m).elements, m.state());
    return now.input - now.dissipated;
  });
}

/// The multiplier of a motion of a joint is its force along or moment about the axis.
void add_drive(Place place, std::size_t i, const ModelAction& action) {
  const bool turns = action.type == "rotation";
  place.number(turns ? "moment_about_axis" : "force_along_axis", turns ? "Nm" : "N", [i](Measurement& m) {
    return -m.state().lambda[static_cast<std::size_t>(m.model().motions[i].elements.front().first_row)];
  });
}

void add_joint_force(Place place, std::size_t i, const JointCoordinate& along) {
  place.number(along.turns ? "moment_about_axis" : "force_along_axis", along.turns ? "Nm" : "N",
               [i, number = along.number](Measurement& m) {
                 return force_along(number, m.model().forces[i].elements, m.state());
               });
}

void add_point(Place place, std::size_t i, const ModelPoint& point) {
  const auto motion = [i](Measurement& m) { return motion_of(m.model(), m.model().points[i], m.state()); };
  place.vector("position", "m", [motion](Measurement& m) { return motion(m).position; });
  place.vector("velocity", "m/s", [motion](Measurement& m) { return motion(m).velocity; });
  place.vector("acceleration", "m/s2", [motion](Measurement& m) { return motion(m).acceleration; });
  if (point.node < 0) return;
  const auto body = static_cast<std::size_t>(point.body), node = static_cast<std::size_t>(point.node);
  place.array("stress", "Pa", kTensor, [body, node](Measurement& m, double* values) {
    std::copy_n(m.stress(body).cauchy[node].begin(), 6, values);
  });
  place.number("von_mises", "Pa", [body, node](Measurement& m) { return m.stress(body).von_mises[node]; });
}

void add_energies(Place place, const MultibodyModel& model) {
  place.number("kinetic", "J", [](Measurement& m) { return m.total_energy().kinetic; });
  place.number("potential", "J", [](Measurement& m) { return m.total_energy().potential; });
  place.number("elastic", "J", [](Measurement& m) { return m.total_energy().elastic; });
  // With bodies of many elements their dampers, and the states of all steps, cost too much to do it unasked.
  const bool along_steps = !Account::active_elements(model).empty(), dear = !model.flexible_bodies.empty();
  const auto sum = [&](const std::string& name, const auto& measure) {
    Quantity& quantity = place.number(name, "J", measure);
    quantity.along_steps = along_steps;
    quantity.by_name_only = dear && along_steps;
  };
  sum("dissipated", [](Measurement& m) { return m.account().work(m.state().t).dissipated; });
  sum("input", [](Measurement& m) { return m.account().work(m.state().t).input; });
  sum("balance", [](Measurement& m) { return m.account().balance(m.total_energy(), m.state().t); });
}

Strings split(const std::string& path) {
  Strings words;
  for (std::size_t from = 0, to = 0; from <= path.size(); from = to + 1) {
    to = std::min(path.find('.', from), path.size());
    words.push_back(path.substr(from, to - from));
  }
  return words;
}

/// Whether the first `count` words of the pattern are those of the path.
bool begins(const Strings& path, const Strings& pattern, std::size_t count) {
  if (count > path.size()) return false;
  for (std::size_t k = 0; k < count; ++k)
    if (pattern[k] != "*" && pattern[k] != path[k]) return false;
  return true;
}

bool matches(const Quantity& quantity, const Strings& pattern) {
  return begins(split(quantity.path()), pattern, pattern.size()) &&
         (!quantity.by_name_only || pattern.back() == quantity.name);
}

/// Throws with the names that could stand where the first one is not known.
[[noreturn]] void refuse(const std::vector<Quantity>& all, const std::string& pattern) {
  const Strings words = split(pattern);
  std::size_t known = 0;
  std::set<std::string> possible;  // behind those
  for (std::size_t count = 0; count <= words.size(); ++count) {
    std::set<std::string> next;
    bool any = false;
    for (const Quantity& quantity : all) {
      const Strings path = split(quantity.path());
      if (!begins(path, words, count)) continue;
      any = true;
      if (count < path.size()) next.insert(path[count]);
    }
    if (!any) break;
    known = count;
    possible = std::move(next);
  }
  if (possible.empty()) throw InvalidInput(pattern, "has more parts than the name of a quantity");
  if (known == words.size())
    throw InvalidInput(pattern, "takes none but by its own name, one of: " + comma_list(possible));
  throw InvalidInput(pattern, "there is no '" + words[known] + "'; known are: " + comma_list(possible));
}

}  // namespace

Measurement::Measurement(const MultibodyModel& model, const State& state, Account& account, int threads)
    : model_(model),
      state_(state),
      account_(account),
      threads_(threads),
      stress_(model.flexible_bodies.size()),
      motion_(model.flexible_bodies.size()),
      flexible_energy_(model.flexible_bodies.size()) {
  account_.follow(state_);
  if (!account_.has_begun()) account_.begin_balance(total_energy());
}

const NodalStress& Measurement::stress(std::size_t body) {
  const FlexibleBody& b = model_.flexible_bodies[body];
  if (!stress_[body])
    stress_[body] = std::make_unique<NodalStress>(
        nodal_stress(*b.solid, &state_.q[static_cast<std::size_t>(b.range.first)], threads_));
  return *stress_[body];
}

const BodyMotion& Measurement::motion(std::size_t body) {
  const FlexibleBody& b = model_.flexible_bodies[body];
  const auto first = static_cast<std::size_t>(b.range.first);
  if (!motion_[body])
    motion_[body] = std::make_unique<BodyMotion>(
        body_motion(*b.solid, &state_.q[first], &state_.v[first], &state_.a[first], threads_));
  return *motion_[body];
}

const Energy& Measurement::flexible_energy(std::size_t body) {
  if (!flexible_energy_[body])
    flexible_energy_[body] =
        std::make_unique<Energy>(energy({{model_.flexible_bodies[body].solid, 0}}, state_, threads_));
  return *flexible_energy_[body];
}

const Energy& Measurement::total_energy() {
  if (total_energy_) return *total_energy_;
  total_energy_ = std::make_unique<Energy>();
  for (std::size_t i = 0; i < model_.flexible_bodies.size(); ++i) *total_energy_ += flexible_energy(i);
  for (const RigidPart& body : model_.rigid_bodies) *total_energy_ += energy({body.element}, state_);
  for (const ModelAction& force : model_.forces) *total_energy_ += energy(force.elements, state_);
  return *total_energy_;
}

std::vector<Quantity> quantities(const MultibodyModel& model) {
  std::vector<Quantity> list;
  const auto place = [&](const char* kind, const std::string& name) {
    return Place(list, std::string(kind) + "." + name);
  };
  for (std::size_t i = 0; i < model.rigid_bodies.size(); ++i)
    add_rigid_body(place("bodies", model.rigid_bodies[i].name), i);
  for (std::size_t i = 0; i < model.flexible_bodies.size(); ++i)
    add_flexible_body(place("bodies", model.flexible_bodies[i].name), i);
  for (std::size_t i = 0; i < model.joints.size(); ++i)
    add_joint(place("joints", model.joints[i].name), i, model.joints[i]);
  for (std::size_t i = 0; i < model.motions.size(); ++i) {
    const ModelAction& motion = model.motions[i];
    if (motion.type == "rotation" || motion.type == "translation")
      add_drive(place("motions", motion.name), i, motion);
    add_action(place("motions", motion.name), i, &MultibodyModel::motions, motion);
  }
  for (std::size_t i = 0; i < model.forces.size(); ++i) {
    const ModelAction& force = model.forces[i];
    if (force.along.number >= 0) add_joint_force(place("forces", force.name), i, force.along);
    add_action(place("forces", force.name), i, &MultibodyModel::forces, force);
  }
  for (std::size_t i = 0; i < model.points.size(); ++i)
    add_point(place("points", model.points[i].name), i, model.points[i]);
  add_energies(Place(list, "energy"), model);
  return list;
}

std::vector<Quantity> chosen_quantities(const MultibodyModel& model) {
  std::vector<Quantity> all = quantities(model), chosen;
  std::vector<Strings> patterns;
  for (const std::string& pattern : model.record) {
    patterns.push_back(split(pattern));
    if (std::none_of(all.begin(), all.end(), [&](const Quantity& q) { return matches(q, patterns.back()); }))
      refuse(all, pattern);
  }
  for (Quantity& quantity : all) {
    const bool wanted = patterns.empty()
                            ? !quantity.by_name_only
                            : std::any_of(patterns.begin(), patterns.end(),
                                          [&](const Strings& pattern) { return matches(quantity, pattern); });
    if (wanted) chosen.push_back(std::move(quantity));
  }
  return chosen;
}

}  // namespace mfs::dae
