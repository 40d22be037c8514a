// What the integrator integrates: a mechanical system with holonomic constraints, in the terms of Jung and
// Bae (Multibody System Dynamics 2017), Eq. (1)-(4),
//
//   F(t, q, v, a, lambda) = M(q) a - Q(t, q, v) + Phi_q^T lambda = 0     n equations of motion
//   Phi(t, q)                                                    = 0     m constraints on positions,
//   d/dt   Phi = Phi_q v + Phi_t                                 = 0       on velocities,
//   d^2/dt^2 Phi = Phi_q a + (Phi_q v + Phi_t)_q v + ...         = 0       on accelerations,
//
// with n coordinates q, v = q', a = v' and m multipliers lambda. A system fills these residuals and their
// derivatives, sparse and on patterns that never change. Derivatives that hold for every such system are not
// asked for twice: Phi_q is also the derivative of d/dt Phi by v, of d^2/dt^2 Phi by a, and, transposed, of F
// by lambda.
//
// A constraint may be on velocities alone (nonholonomic), as that of a wheel which rolls: A(q) v + b(t, q) =
// 0. It has no Phi; A takes the place of Phi_q everywhere else, and the left-hand side that of d/dt Phi.
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "dae/mechanics/change_watch.hpp"
#include "dae/mechanics/time_span.hpp"
#include "dae/vectors/executor.hpp"
#include "ordering/raw_vector.hpp"

namespace mfs::dae {

/// Where the system is. Borrowed arrays of n coordinates, velocities, accelerations and m multipliers.
struct StateView {
  double t = 0.0;
  const double* q = nullptr;
  const double* v = nullptr;
  const double* a = nullptr;
  const double* lambda = nullptr;
};

/// The derivatives that a system computes. Rows are equations, columns coordinates.
enum class Block {
  force_q,         ///< dF/dq, n x n
  force_v,         ///< dF/dv, n x n
  force_a,         ///< dF/da: the mass matrix, n x n
  position_q,      ///< Phi_q, m x n; A of constraints on velocities
  velocity_q,      ///< d(d/dt Phi)/dq, m x n
  acceleration_q,  ///< d(d^2/dt^2 Phi)/dq, m x n
  acceleration_v,  ///< d(d^2/dt^2 Phi)/dv, m x n
};
constexpr int kBlocks = 7;

/// A set of blocks.
class BlockSet {
 public:
  constexpr BlockSet() = default;
  constexpr BlockSet(std::initializer_list<Block> blocks) {
    for (const Block b : blocks) bits_ |= bit(b);
  }
  static constexpr BlockSet all() {
    BlockSet set;
    set.bits_ = (1U << kBlocks) - 1U;
    return set;
  }
  constexpr bool has(Block b) const { return (bits_ & bit(b)) != 0; }
  constexpr bool empty() const { return bits_ == 0; }
  constexpr bool meets(BlockSet other) const { return (bits_ & other.bits_) != 0; }
  constexpr BlockSet operator&(BlockSet other) const {
    other.bits_ &= bits_;
    return other;
  }
  constexpr void insert(Block b) { bits_ |= bit(b); }
  constexpr void erase(BlockSet others) { bits_ &= ~others.bits_; }

 private:
  static constexpr unsigned bit(Block b) { return 1U << static_cast<unsigned>(b); }
  unsigned bits_ = 0;
};

/// A sparse pattern in compressed rows; columns of a row ascend strictly. No entries: the block is zero.
struct Pattern {
  int rows = 0, columns = 0;
  std::vector<int> row_start;  ///< rows + 1
  RawVector<int> column;       ///< row_start[rows]
  std::size_t entries() const { return column.size(); }
};

/// The patterns of all blocks and which of them have the same values in every state.
struct TangentPattern {
  std::array<Pattern, kBlocks> block;
  std::array<bool, kBlocks> constant{};

  const Pattern& operator[](Block b) const { return block[static_cast<std::size_t>(b)]; }
};

/// Values of the blocks, in the order of the entries of their patterns.
struct Tangent {
  std::array<std::vector<double>, kBlocks> values;

  std::vector<double>& operator[](Block b) { return values[static_cast<std::size_t>(b)]; }
  const std::vector<double>& operator[](Block b) const { return values[static_cast<std::size_t>(b)]; }
};

/// The left-hand sides of the equations above.
struct Residual {
  std::vector<double> force;         ///< F, n
  std::vector<double> position;      ///< Phi, m; 0 of constraints on velocities
  std::vector<double> velocity;      ///< d/dt Phi, m
  std::vector<double> acceleration;  ///< d^2/dt^2 Phi, m
};

/// One number for each of the derivatives of F: by a, by v, by q.
using ByAVQ = std::array<double, 3>;
using DiagonalsByAVQ = std::array<std::vector<double>, 3>;
constexpr std::array<Block, 3> kForceByAVQ{Block::force_a, Block::force_v, Block::force_q};

/// Newton's matrix in the memory of a device: what is evaluated there is added up there, and the host sends
/// what it has for some of the entries. Where a solver takes the values from there, they never pass through
/// the memory of the host.
class RemoteMatrix {
 public:
  virtual ~RemoteMatrix() = default;

  /// Room for what the host has, a number for each of the entries that it was made with.
  virtual double* own() = 0;
  /// Begins anew with what was left there; all other entries are zero. Then the remote tangents add theirs.
  virtual void begin() = 0;
  /// All entries, in the memory of the device: in stream(), behind what is there.
  virtual const double* values() = 0;
  virtual void* stream() const = 0;
  /// Waits for them and copies them.
  virtual void read(double* values) = 0;
};

/// A share of F's derivatives that is not in the blocks: it stays where it is evaluated, on a device, and
/// goes from there into Newton's matrix as one sum. The blocks would be three times as much to copy, and they
/// would pass through the memory of the host several times.
class RemoteTangent {
 public:
  virtual ~RemoteTangent() = default;

  /// The entries of each of the three derivatives, n x n. No two remote tangents have entries in one row.
  virtual const Pattern& pattern() const = 0;
  /// A matrix of so many entries on the device, for this remote tangent and all others of the system.
  /// `own`: the entries that the host has numbers for. Throws OutOfMemory, BackendError.
  virtual std::unique_ptr<RemoteMatrix> make_matrix(std::size_t entries, const std::vector<int>& own) = 0;
  /// Says where entry k of the derivative by a, v, q is to be added: to entry target[0][k], target[1][k],
  /// target[2][k] of `matrix`, made by make_matrix(), which has to live as long as sums are added to it.
  /// Targets of one k may be the same; those of different k are not.
  virtual void place(const std::array<const int*, 3>& target, RemoteMatrix& matrix) = 0;

  /// Begins to evaluate the derivatives; `state`, whose multipliers do not matter, has been read when this
  /// returns.
  virtual void begin_tangent(const StateView& state) = 0;
  /// The same for a state in the memory of `executor`, a device: read behind what it marked last and before
  /// what it begins from now on.
  virtual void begin_tangent(const Executor& executor, const StateView& state) = 0;
  /// Adds the diagonal entries of factor[0] dF/da, factor[1] dF/dv and factor[2] dF/dq, in the state that was
  /// begun last, to `diagonals` (n each).
  virtual void add_diagonals(const ByAVQ& factor, DiagonalsByAVQ& diagonals) = 0;
  /// Begins to add that sum to the matrix, which has begun before.
  virtual void begin_sum(const ByAVQ& factor) = 0;
};

/// Evaluates residuals where the state's vectors lie on a device. What has no device is evaluated by the
/// host, which gets the few coordinates that it needs.
class RemoteResidual {
 public:
  virtual ~RemoteResidual() = default;

  /// Writes F (n) and the constraints (m) of the first `levels` levels to `h`, one after the other. `state`
  /// and `h` are in the executor's memory; what is written is there for all that the executor begins from now
  /// on.
  virtual void evaluate(const StateView& state, int levels, double* h) = 0;
  /// A state on the host, for the blocks of derivatives: only the coordinates that they depend on have their
  /// numbers. Until the next one is brought or evaluated. The executor has marked what it began before.
  virtual StateView bring(const StateView& state) = 0;
};

class ConstrainedSystem {
 public:
  virtual ~ConstrainedSystem() = default;

  virtual int coordinates() const = 0;  ///< n
  virtual int constraints() const = 0;  ///< m, of which some may follow from the others
  virtual const TangentPattern& tangent_pattern() const = 0;

  /// Overwrites `residual`, whose vectors have their sizes.
  virtual void evaluate(const StateView& state, Residual& residual) const = 0;
  /// Overwrites the values of these blocks in `tangent`, whose vectors have the sizes of the patterns, and
  /// leaves the others alone.
  virtual void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const = 0;
  /// The same for some rows of Phi_q; others are overwritten or left alone.
  virtual void evaluate_gradient(const StateView& state, const std::vector<int>& /*rows*/,
                                 Tangent& tangent) const {
    evaluate(state, tangent, {Block::position_q});
  }
  /// What has to be added to the blocks and is evaluated by its own functions. They live as long as the
  /// system.
  virtual std::vector<RemoteTangent*> remote_tangents() const { return {}; }

  /// For states in the memory of `executor`, a device; null: they are to be on the host. `executor` has to
  /// live as long. Throws OutOfMemory, BackendError.
  virtual std::unique_ptr<RemoteResidual> remote_residual(const Executor& /*executor*/) const {
    return nullptr;
  }

  /// What an error message calls them: "knuckle.x", "joint ball_upper, equation 2 of 3".
  virtual std::string coordinate_name(int coordinate) const {
    return "q[" + std::to_string(coordinate) + "]";
  }
  virtual std::string constraint_name(int row) const { return "constraint " + std::to_string(row); }
  /// What the constraint is a part of: "joint ball_upper".
  virtual std::string constraint_owner(int row) const { return constraint_name(row); }
  /// Whether the constraint is no condition on where bodies are, but gives their coordinates a meaning, as
  /// p.p = 1 does for Euler parameters. Such constraints share no coordinate and follow from no others.
  virtual bool is_normalization(int /*row*/) const { return false; }
  /// Whether the constraint is on velocities alone.
  virtual bool is_nonholonomic(int /*row*/) const { return false; }
  /// Times, ascending, at which steps within `span` are to end, so that they do not pass over what only lasts
  /// for a while.
  virtual std::vector<double> marks(const TimeSpan& /*span*/) const { return {}; }
  /// What sees where steps pass over something; null: nothing may be passed over. The system has to live as
  /// long.
  virtual std::unique_ptr<ChangeWatch> change_watch() const { return nullptr; }
  /// A typical size of a coordinate, in its own unit: what the integrator measures it in. A power of two.
  virtual double coordinate_scale(int) const { return 1.0; }
  /// How far each coordinate may go while the mechanism moves: of lengths, the extent of the whole mechanism
  /// in `q` (n), where that is more than the scale.
  virtual std::vector<double> ranges(const double* /*q*/) const {
    std::vector<double> ranges;
    for (int i = 0; i < coordinates(); ++i) ranges.push_back(coordinate_scale(i));
    return ranges;
  }
  /// What is pressed together so far in `q` (n) that no step may lead on, for a message: "body arm, element
  /// 17 is pressed to 0.4 of its length"; empty: nothing.
  virtual std::string most_pressed(const double* /*q*/) const { return {}; }
  /// What a value of a constraint is multiplied by for a message, where it is not in the unit of whoever
  /// reads that (scaled_system.hpp), and one of F.
  virtual double constraint_unit(int /*row*/) const { return 1.0; }
  virtual double force_unit(int /*coordinate*/) const { return 1.0; }
  /// Whether a constraint of its own makes the coordinate a function of the others: where initial values are
  /// corrected, its change then is no change of where bodies are.
  virtual bool is_measure(int /*coordinate*/) const { return false; }
};

/// Vectors of the right sizes for `system`, all zero.
inline Residual make_residual(const ConstrainedSystem& system) {
  const auto n = static_cast<std::size_t>(system.coordinates());
  const auto m = static_cast<std::size_t>(system.constraints());
  return {std::vector<double>(n), std::vector<double>(m), std::vector<double>(m), std::vector<double>(m)};
}

inline Tangent make_tangent(const ConstrainedSystem& system) {
  Tangent tangent;
  for (std::size_t b = 0; b < kBlocks; ++b)
    tangent.values[b].resize(system.tangent_pattern().block[b].entries());
  return tangent;
}

}  // namespace mfs::dae
