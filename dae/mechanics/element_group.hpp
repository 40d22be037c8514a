// What a mechanical system is made of: groups of elements of one kind. An element sees a few coordinates of
// the system and may bring constraints (rows of Phi, each with its multiplier); it computes its share of the
// residuals and, as small dense matrices, of the derivatives. A mesh of finite elements is one group, the
// links of one rigid interface are one, a rigid body or a joint is a group of one element. Multibody adds the
// shares up.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"
#include "dae/mechanics/watched_function.hpp"

namespace mfs::dae {

/// An element's own part of the state: nq coordinates and nc multipliers, gathered.
struct LocalState {
  double t;
  const double *q, *v, *a, *lambda;
};

/// Shares to be filled (they come zeroed): F (nq), Phi and its derivatives by time (nc each).
struct LocalResidual {
  double* force;
  double *position, *velocity, *acceleration;
};

/// Shares to be filled, dense, row by row. Those that are asked for come zeroed; whatever is written to the
/// others is thrown away, so that only a group with a dear block need look. Null: the group said that the
/// block is zero. Derivatives of F: nq x nq; of constraints: nc x nq.
struct LocalTangent {
  double *force_q, *force_v, *force_a;
  double *position_q, *velocity_q, *acceleration_q, *acceleration_v;
  BlockSet asked = BlockSet::all();
};

/// Which of the blocks of F an element has at all: keeps zeros out of the patterns. Blocks of constraints are
/// taken as dense for every element with constraints.
struct LocalStructure {
  enum class Kind { zero, diagonal, dense };
  Kind force_q = Kind::dense;
  Kind force_v = Kind::zero;
  Kind force_a = Kind::zero;
  /// force_a (or force_v) is the same for every state.
  bool constant_force_a = false;
  bool constant_force_v = false;
  /// Dense blocks of F have rows and columns of zeros for the local coordinates before this one.
  int coupled_from = 0;
};

/// What an element has in a state, J.
struct Energy {
  double kinetic = 0, potential = 0, elastic = 0;  ///< potential: of its weight, 0 at the origin

  Energy& operator+=(const Energy& other) {
    kinetic += other.kinetic;
    potential += other.potential;
    elastic += other.elastic;
    return *this;
  }
};

/// At what rate an element changes the energy of the system, W.
struct Power {
  double dissipated = 0;  ///< by dampers
  double input = 0;       ///< by what depends on time or keeps no account of its own: drives, loads

  Power& operator+=(const Power& other) {
    dissipated += other.dissipated;
    input += other.input;
    return *this;
  }
};

/// F of all elements of a group at once, and its derivatives, by a device that works beside the host.
class DeviceForce : public RemoteTangent {
 public:
  /// Begins to evaluate it; `state` has been read when this returns. What was begun before and not taken is
  /// dropped.
  virtual void begin(const StateView& state) = 0;
  /// Waits for what was begun and adds it to `force` (n).
  virtual void add_to(std::vector<double>& force) = 0;
  /// Writes it to `force`, for the coordinates of these elements, where that is zero: `state` and `force` (n)
  /// are in the memory of `executor`, the device. Between what that marked last and what it begins from now
  /// on.
  virtual void write(const Executor& executor, const StateView& state, double* force) = 0;
};

/// Immutable once it is part of a system; its functions are called by several threads at once.
class ElementGroup {
 public:
  virtual ~ElementGroup() = default;

  virtual int size() const = 0;                        ///< elements
  virtual int local_coordinates() const = 0;           ///< nq of each
  virtual int local_constraints() const { return 0; }  ///< nc of each
  /// The nq indices in the system of the coordinates of element e, all different.
  virtual const int* coordinates(int e) const = 0;
  virtual LocalStructure structure() const = 0;

  virtual void residual(int e, const LocalState& state, LocalResidual& residual) const = 0;
  virtual void tangent(int e, const LocalState& state, LocalTangent& tangent) const = 0;

  // For the balance: d/dt of the energies of all elements = input - dissipated, each summed over all.
  virtual Energy energy(int /*e*/, const LocalState& /*state*/) const { return {}; }
  /// Unless a group knows better: a force brings in its power, -F . v; constraints what the multipliers do to
  /// those that move with time, lambda . Phi_t.
  virtual Power power(int e, const LocalState& state) const {
    const auto nq = static_cast<std::size_t>(local_coordinates());
    const auto nc = static_cast<std::size_t>(local_constraints());
    std::vector<double> force(nq), constraint(3 * nc);
    const std::vector<double> rest(nq);
    LocalResidual local{force.data(), constraint.data(), constraint.data() + nc, constraint.data() + 2 * nc};
    Power power;
    if (nc == 0) {
      residual(e, state, local);
      for (std::size_t k = 0; k < nq; ++k) power.input -= force[k] * state.v[k];
      return power;
    }
    residual(e, {state.t, state.q, rest.data(), rest.data(), state.lambda}, local);
    for (std::size_t i = 0; i < nc; ++i) power.input += state.lambda[i] * local.velocity[i];
    return power;
  }

  /// The same as `residual` and `tangent` of all elements, on a device; null: this group is left to the host.
  /// For groups without constraints.
  /// `coordinates`: of the system; `threads`: of the host, for the copies. Throws BackendError, OutOfMemory.
  virtual std::unique_ptr<DeviceForce> device_force(int /*coordinates*/, int /*threads*/) const {
    return nullptr;
  }

  /// Adds those of ConstrainedSystem::marks; they need not ascend.
  virtual void add_marks(const TimeSpan& /*span*/, std::vector<double>& /*marks*/) const {}

  /// Adds what ChangeWatch is to look at: functions of coordinates, laws of springs.
  virtual void add_watched(WatchedFunctions& /*functions*/) const {}

  // For messages where no step leads on.
  /// The least length of a line in element e, of 1 undeformed; `q`: its coordinates. 1 where it has none.
  virtual double least_stretch(int /*e*/, const double* /*q*/) const { return 1.0; }
  /// What is to be said about an element that is pressed far: "; ...".
  virtual std::string pressed_note() const { return {}; }

  /// What an error message calls element e: "joint crank_pin", "body arm, element 17".
  virtual std::string name(int e) const = 0;
  /// What the constraint `row` of an element holds, where that has a name: "along ground x".
  virtual std::string direction(int /*row*/) const { return {}; }
  /// Whether its constraints are normalizations (ConstrainedSystem::is_normalization).
  virtual bool normalizes() const { return false; }
  /// Whether its constraints are on velocities alone (ConstrainedSystem::is_nonholonomic).
  virtual bool is_nonholonomic() const { return false; }
};

}  // namespace mfs::dae
