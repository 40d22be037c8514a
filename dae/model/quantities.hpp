// What a run can record, by names that are places in the model file: "bodies.crank.position",
// "joints.pin.reaction_force", "energy.kinetic". A model chooses by a list of such names: "*" stands for
// every name in its place, and what is left off behind stands for all.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dae/fem/body_motion.hpp"
#include "dae/fem/nodal_stress.hpp"
#include "dae/model/account.hpp"
#include "dae/model/measure.hpp"
#include "dae/model/model.hpp"

namespace mfs::dae {

/// One state, and what several quantities read off it, computed when it is first asked for.
class Measurement {
 public:
  /// All have to live as long. `threads`: of loops over elements. The account follows the state.
  Measurement(const MultibodyModel& model, const State& state, Account& account, int threads);

  const MultibodyModel& model() const { return model_; }
  const State& state() const { return state_; }
  const Account& account() const { return account_; }
  // Of flexible_bodies[body].
  const NodalStress& stress(std::size_t body);
  const BodyMotion& motion(std::size_t body);
  const Energy& flexible_energy(std::size_t body);
  /// Of the whole system.
  const Energy& total_energy();

 private:
  const MultibodyModel& model_;
  const State& state_;
  Account& account_;
  int threads_;
  std::vector<std::unique_ptr<NodalStress>> stress_;
  std::vector<std::unique_ptr<BodyMotion>> motion_;
  std::vector<std::unique_ptr<Energy>> flexible_energy_;
  std::unique_ptr<Energy> total_energy_;
};

struct Quantity {
  std::string place, name;              ///< "bodies.crank", "position"
  std::string unit;                     ///< "m"; empty: none
  std::vector<std::string> components;  ///< of an array: "x", "y", "z"; none: a number
  /// Writes its numbers.
  std::function<void(Measurement&, double*)> measure;
  /// It needs the states of all steps, not those of outputs alone.
  bool along_steps = false;
  /// It is taken only where the list says its own name: it costs more than the others.
  bool by_name_only = false;

  std::string path() const { return place + "." + name; }
  std::size_t size() const { return components.empty() ? 1 : components.size(); }
};

/// All that the model has.
std::vector<Quantity> quantities(const MultibodyModel& model);

/// Those that model.record chooses; without one all but by_name_only. Throws InvalidInput that names what is
/// not there and lists what is.
std::vector<Quantity> chosen_quantities(const MultibodyModel& model);

}  // namespace mfs::dae
