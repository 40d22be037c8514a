// The equations of one step, H(x) = 0, the paper's Eq. (6), and their Jacobian H_x. With a formula that ties
// v and a to q (formula.hpp), n coordinates, m constraints and the directions B that the constraints have for
// themselves (projection.hpp),
//
//   rows      F (n) | Phi (m) | dPhi/dt (m) | d2Phi/dt2 (m) | v_by_a (a - a0) - (v - v0) + B kappa
//                                                           | q_by_v (v - v0) - (q - q0) + B mu
//   unknowns  x = [lambda (m), a (n), v (n), q (n), kappa, mu]
//
// with relations for all but tied coordinates. In place of Phi a constraint on velocities has its mu, which
// is zero. The reduced form solves the relations of free coordinates beforehand: their v_i and q_i are no
// unknowns any more, and their columns of H_x go, times v_by_a and q_by_a, to the column of a_i. (The other
// way round, a_i from q_i, rounding in q would be multiplied by 1 / q_by_a ~ 1/h^2.)
//
// H_x itself is as badly scaled as a matrix can be, and anew by each step. What is factored is R H_x C, which
// no unit and no step makes large or small (augmentation.hpp): with a typical diagonal entry s of F's
// derivatives by a,
//
//   R    F by 1  | Phi by s / q_by_a | dPhi/dt by s / v_by_a | d2Phi/dt2 by s | relations as Phi's
//   derivatives C    a, v, q by 1 / s, v_by_a / s, q_by_a / s,  then  lambda = lambda' + s Phi_q a
//                    kappa and mu as v and q
//
// so Phi_q itself stands in the rows of all its levels, and the first two groups of columns hold
// (dF/da + v_by_a dF/dv + q_by_a dF/dq) / s + Phi_q^T Phi_q and Phi_q^T in the rows of F. Where a device has
// these derivatives (RemoteTangent), the matrix is put together there (RemoteMatrix).
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "dae/integrator/augmentation.hpp"
#include "dae/integrator/composition.hpp"
#include "dae/integrator/formula.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/integrator/projection.hpp"
#include "dae/integrator/step_state.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "dae/vectors/executor.hpp"

namespace mfs::dae {

class StepEquations {
 public:
  /// `remote`: that of the system for a
  /// device, null for the host. Vectors are those of `executor`. All have to live as long.
  StepEquations(const ConstrainedSystem& system, Unknowns unknowns, Projection projection,
                const Executor& executor, RemoteResidual* remote = nullptr);
  StepEquations(const StepEquations&) = delete;

  const ConstrainedSystem& system() const { return system_; }
  int size() const { return size_; }
  const Pattern& pattern() const { return composition_.pattern(); }
  /// Rows of H of the constraints: kLevels times m from `first_constraint`.
  int first_constraint() const { return n_; }
  static constexpr int kLevels = 3;
  /// Whether the constraints alone determine the motion.
  bool all_prescribed() const { return n_ == m_ && nonholonomic_.rows == 0; }
  /// What an unknown belongs to: a coordinate or a constraint.
  std::string unknown_name(int unknown) const;

  /// Phi_q of the last Jacobian.
  const std::vector<double>& constraint_gradient() const { return tangent_[Block::position_q]; }
  /// M_i of every coordinate (n), by the last Jacobian.
  const Array<double>& inertia() const { return inertia_.array(); }
  /// The share of a coordinate's elastic energy that becomes motion once steps are short (n), by the last
  /// Jacobian: 1 where damping is small, (K_i M_i / D_i^2)^2 where the coordinate alone would creep. Creeping
  /// takes K M / D^2 of the energy, for a part of a step; that this counts for as much again was measured
  /// (docs/experiments/integrator-rotation.md).
  const Array<double>& ringing() const { return ringing_.array(); }
  /// As followed_forces().
  const Array<double>& followed() const { return followed_; }
  /// Sets B to what it is at q of `state`, whose multipliers do not matter. Throws InvalidInput where it is
  /// no number.
  void set_directions(const StateView& state) const;
  /// x of the prediction with multipliers `lambda` (m).
  void pack(const StepRelation& relation, const double* lambda, double* x) const;
  /// The state that x stands for.
  void unpack(const double* x, const StepRelation& relation, StepState& state) const;
  /// H at x, `state` unpacked.
  void residual(const double* x, const StepState& state, const StepRelation& relation, double* h) const;
  /// R H_x C at `state`: values on the host in the order of the pattern, unless there is a remote matrix,
  /// which takes them instead.
  void jacobian(const StepState& state, const StepRelation& relation, double* values) const;
  /// The same at the state of the last one, in a step of no time, in which v and q do not move with a.
  void initial_jacobian(double* values) const;
  /// Where the values are if derivatives are evaluated on a device, else null.
  RemoteMatrix* remote_matrix() const { return remote_matrix_.get(); }
  /// The right-hand side b of the system for what lambda and a, zero in `state`, are to be changed by, so
  /// that F and the constraints on accelerations hold.
  void initial_right_side(const StepState& state, double* b) const;
  /// The right-hand side b of the system for what an error `e` of the velocities (n) of the step of
  /// `relation`, which ends in `state`, is once forces have acted on it: M e / v_by_a in the rows of F, to
  /// which the small rest of F in `state` is added, and in those of constraints what e is in their
  /// directions.
  void error_right_side(const StepState& state, const StepRelation& relation, const Array<double>& e,
                        double* b) const;
  /// Sets `v` (n) to what the correction x of that system is in velocities.
  void take_velocities(const StepRelation& relation, const double* x, double* v) const;
  /// Changes lambda and a by the correction x.
  void change_accelerations(const double* x, StepState& state) const;
  /// 1 / q_by_a of `relation` over that of the last Jacobian.
  double ratio(const StepRelation& relation) const {
    return relation.q_by_a() == scales_.q_by_a() ? 1.0 : scales_.q_by_a() / relation.q_by_a();
  }
  /// b = R h, with R of the last Jacobian, but for constraints and relations such that correct() makes of a
  /// solution what they ask for: they say how far q, v and a have to go, whatever step the Jacobian is of.
  void scale_rows(const StepRelation& relation, const double* h, double* b) const;
  /// Makes a correction x in the step of `relation` of a solution of a system with the last Jacobian: C times
  /// that, and where that is of another step, scaled. Where inertia dominates, corrections of q by such a
  /// matrix are too large by the ratio, where stiffness does they are right; this shares the error out.
  /// Corrections of v and a follow those of q by the rates of this step, for dependent coordinates too: else
  /// each correction of a, many times that of q, would violate the constraints on accelerations anew.
  void correct(const StepRelation& relation, const double* solution, double* x) const;

 private:
  enum Kind { kA, kV, kQ, kLambda };
  enum Row { kForce, kPosition, kVelocity, kAcceleration, kRelation };
  /// Where a term of H_x has its numbers, and where it stands.
  struct Numbers {
    const std::vector<double>* block;  ///< null: elsewhere
    Row row;
    Kind column;
  };
  /// What R and C of the last Jacobian are made of.
  struct Scales {
    double s = 1.0, v_by_a = 0.0, q_by_v = 0.0;
    double q_by_a() const { return v_by_a * q_by_v; }
    double of(Row row, Kind column) const;
  };
  bool eliminated(std::size_t i) const { return reduced_ && projection_.role[i] == Role::free; }
  /// Columns: multipliers, all of a, then v and q of the coordinates that are kept, kappa and mu.
  std::size_t first_acceleration() const { return static_cast<std::size_t>(m_); }
  std::size_t first_velocity() const { return static_cast<std::size_t>(m_) + projection_.role.size(); }
  std::size_t first_position() const { return first_velocity() + kept_.size(); }
  std::size_t first_kappa() const { return first_position() + kept_.size(); }
  std::size_t first_mu() const { return first_kappa() + projection_.rows.size(); }
  int number_unknowns();
  void place_numbers();
  void evaluate(const StateView& state, double* h) const;
  void find_nonholonomic();
  Composition make_composition(int threads);
  void add_relations(std::vector<Composition::Term>& terms);
  void place_remotes();
  double typical_diagonal(const StepRelation& relation) const;
  void find_diagonals() const;
  void find_ringing() const;
  void send_gradient() const;
  void compose(const StepRelation& relation, double* values) const;

  const ConstrainedSystem& system_;
  const int n_, m_;
  const bool reduced_;
  const Executor& executor_;
  RemoteResidual* const remote_;
  Projection projection_;
  std::vector<int> related_;                ///< those with rows of relations, ascending
  std::vector<int> kept_;                   ///< those whose v and q are unknowns, ascending
  std::array<std::vector<int>, 4> column_;  ///< by Kind: where an unknown's derivatives go
  const int size_;
  Pattern holonomic_;                  ///< Phi_q without rows of constraints on velocities
  std::vector<int> holonomic_source_;  ///< of an entry of it: that of Phi_q
  Pattern nonholonomic_;               ///< one entry in each of those rows: the column of its mu
  TransposedPattern position_transposed_;
  mutable Augmentation augmentation_;
  Pattern selection_;                  ///< a row with one entry for each of the related coordinates
  Pattern directions_;                 ///< their rows of B
  std::vector<int> direction_source_;  ///< of an entry of these: that of Phi_q
  std::vector<int> direction_rows_;    ///< of Phi_q, that have these entries
  mutable std::vector<double> direction_values_;
  std::vector<double> ones_, minus_ones_;  ///< as many as rows of relations, or of nonholonomic_
  mutable Residual residual_;
  mutable Tangent tangent_;
  mutable BlockSet due_;          ///< blocks that the next Jacobian has to evaluate
  BlockSet constant_;             ///< those of them that the first one evaluates for all
  std::vector<Numbers> numbers_;  ///< by term
  /// What is added to rows of F elsewhere.
  struct Remote {
    RemoteTangent* tangent;
    std::size_t first_term;  ///< of three, in the order of kForceByAVQ
  };
  std::vector<Remote> remotes_;
  Composition composition_;
  std::unique_ptr<RemoteMatrix> remote_matrix_;
  std::array<std::vector<int>, 3> diagonal_;  ///< where dF/da, dF/dv and dF/dq have their diagonal entries
  mutable DiagonalsByAVQ diagonals_;          ///< M_i, D_i, K_i: these entries
  mutable Scales scales_;
  // For the passes over vectors.
  Array<int> kept_there_, kept_place_;  ///< which are kept; the place of each among those, or -1
  Array<int> related_there_;
  Array<int> direction_start_, direction_column_;
  Array<int> nonholonomic_row_, nonholonomic_mu_;  ///< of H, of x
  mutable Array<double> directions_there_;         ///< entries of B
  mutable Tangent direction_tangent_;              ///< Phi_q alone
  mutable Array<double> no_multipliers_;
  mutable Array<double> changed_a_;
  mutable SentArray<double> inertia_, ringing_;
  Array<double> followed_;
  Array<int> gradient_start_, gradient_column_;  ///< of Phi_q's entries: the column of x
  mutable SentArray<double> gradient_;           ///< Phi_q of the last Jacobian
};

}  // namespace mfs::dae
