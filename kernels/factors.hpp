// The factors of one matrix in the memory of an executor. This interface is all that the accuracy ladder
// knows of an executor. Everything that factor() needs is allocated when the factors are made.
#pragma once

#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mfs/error.hpp>

#include "kernels/dense/pivot_rule.hpp"
#include "kernels/factor_status.hpp"
#include "ordering/transpose.hpp"
#include "plan/segments.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Right-hand sides that one pass over the factors serves at most.
constexpr Vertex kSolveColumns = 16;

/// Bytes that factors of a plan take, by purpose; the sum is exactly what is allocated where they are used.
struct NumericBytes {
  Offset factor = 0;        // L and U
  Offset outside = 0;       // of them, in the memory of the host instead
  Offset contribution = 0;  // what contribution blocks need beyond the factors
  Offset other = 0;         // matrix values, scaling, pivots, lists
  Offset solve = 0;         // vectors of a solve
  Offset total() const { return factor - outside + contribution + other + solve; }
};

/// Of factors that do not fit where they are used: how they move between there and the memory of the host.
struct Movement {
  std::vector<Vertex> segments;  // by depth, deepest first; empty where the factors fit
  Offset out = 0, in = 0;        // bytes of one factorization: factors and contribution blocks, those alone
  Offset back = 0;               // bytes of one pass over the factors and back
  double slowdown = 1;           // of a refactorization on a device, as foreseen
};

/// What an executor makes of a symbolic plan before any number is known.
template <class Product>
struct Planned {
  NumericBytes bytes;         // that the product will take where the factors lie
  BlockFlops flops{0, 0, 0};  // of one factorization
  Movement movement;
  /// Once. Throws OutOfMemory, std::bad_alloc.
  std::function<std::unique_ptr<Product>()> make;
  /// The operations by step of the plan; empty where they are those of its blocks.
  std::vector<BlockFlops> step_flops{};
  bool one_thread = false;  // does all work of the product, in whatever thread that is
  bool early = false;       // the product takes so little of what is free that it may be made at once
};

/// What factor() did, and the largest scaled entry of the matrix.
struct Factored {
  FactorStatus status;
  double largest;
};

/// A's values by slot of the pattern, its scales by row and column of A.
template <class Value>
struct HostMatrix {
  const Value* values = nullptr;
  const double *row_scale = nullptr, *column_scale = nullptr;
};

/// Right-hand sides and the place of their solutions, column-major with leading dimensions of at least n.
template <class Value>
struct SolveBlock {
  const Value* b;
  Offset ldb;
  Value* x;
  Offset ldx;
  Vertex columns;
  const TransposedPattern* transposed = nullptr;  // solve with A^T, whose pattern this is
};

/// What a step towards the solution for the right-hand side of a probe did (kernels/stages/probe_step.hpp),
/// in scaled numbers.
struct ProbeStep {
  double left;           // the largest entry of the residual
  double length;         // that of the correction d
  double product, size;  // those of A d and of |A| |d|
};

/// Factors in the memory of a device also copy arrays of that memory, and hold the vectors of a solve there.
/// `stream` is a stream of the caller; what was put into it before is waited for on the device. Calls return
/// when their work is done. Only start and correct return before, and backward_error waits for their end.
template <class Value>
class ResidentFactors {
 public:
  virtual ~ResidentFactors() = default;
  /// Throws InvalidInput(name) for an array that kernels cannot reach: of the host, of another device.
  virtual void require_reachable(const void* array, const char* name) const = 0;
  /// Takes the values, by slot of the pattern, for the next factor(). False if one of them is not finite.
  virtual bool take_values(const Value* values, void* stream) = 0;
  /// Copy `columns` columns of `rows` entries, from the device to the host and back.
  virtual void download(const Value* from, Offset ld, Offset rows, Vertex columns, Value* to,
                        void* stream) = 0;
  virtual void upload(const Value* from, Offset rows, Vertex columns, Value* to, Offset ld, void* stream) = 0;

  /// x = approximately A^-1 b, in vectors of the factors' own. The arrays of the block lie on the device and
  /// are used until the next start. Those of start_from_host lie on the host with leading dimensions n, and
  /// the solution is copied there.
  virtual void start(const SolveBlock<Value>& block, double row_floor, void* stream) = 0;
  virtual void start_from_host(const SolveBlock<Value>& block, double row_floor) = 0;
  /// The worst componentwise backward error of x. Where it is at most `bound`, x goes to its place in the
  /// block.
  virtual double backward_error(double bound) = 0;
  /// x += approximately A^-1 (b - A x).
  virtual void correct() = 0;
  /// x as it is now, into memory of the host: n x columns.
  virtual void bring_solution(Value* x) = 0;
  /// A step towards the solution for the right-hand side of a probe, from nothing or from the step before,
  /// since when nothing else has been solved for: it may have had the same vectors.
  /// Throws OutOfMemory, std::bad_alloc.
  virtual ProbeStep probe(bool from_nothing) = 0;
  /// The same as a step of GCR, which leaves the least residual that it and those before it can. Nothing
  /// where there is no room for more steps (kernels/stages/probe_directions.hpp).
  virtual std::optional<ProbeStep> probe_together(bool from_nothing) = 0;
  /// Later solves are as after factor(policy), whose factors are those at hand but for
  /// PivotPolicy::symmetric.
  virtual void solve_as(const PivotPolicy& policy) = 0;
};

template <class Value>
class Factors {
 public:
  virtual ~Factors() = default;

  /// Places on the host for A's values by slot of the pattern (nnz), and for its scales (n each), to be
  /// filled before factor().
  virtual Value* matrix_values() = 0;
  virtual double* row_scale() = 0;
  virtual double* column_scale() = 0;
  /// The same for reading. Values that came from a device are copied to the host first.
  virtual HostMatrix<Value> matrix() = 0;

  /// Factors the matrix. A pivot below the policy's tolerance times the largest scaled entry is suspect.
  /// `progress`, which may be empty, is called with the fraction of the operations that is done after each
  /// depth.
  virtual Factored factor(const PivotPolicy& policy, const std::function<void(double)>& progress) = 0;

  /// to = approximately A^-1 from (A^-T with `transposed`), scaling and permutation included: n x columns in
  /// memory of the host and in the caller's numbering. They may be the same array.
  virtual void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) = 0;
  /// Takes the memory that apply_inverse needs for so many columns. From the start there is room for one.
  /// Throws std::bad_alloc, OutOfMemory.
  virtual void make_room(Vertex columns) = 0;
  /// The number of columns by which many right-hand sides should be solved for. It is less than kSolveColumns
  /// where the vectors of so many would need much memory beside the factors.
  virtual Vertex columns_at_once() const { return kSolveColumns; }
  /// Memory of the host for vectors that apply_inverse is given. Throws std::bad_alloc.
  virtual std::shared_ptr<char> host_vectors(Offset bytes) const = 0;

  /// What factor() did to the pivot at a position: the row of its pivot block that came there, counted from
  /// the block's first, and the number that was added to the pivot.
  virtual Vertex local_row(Vertex position) const = 0;
  virtual Value pivot_shift(Vertex position) const = 0;
  /// pivots[0 ... n-1] = the pivots by position, as they are in the factors.
  virtual void diagonal_pivots(std::complex<double>* pivots) const = 0;

  /// Where the factors lie, and the bytes that they and all that goes with them take there.
  virtual MemorySpace memory() const = 0;
  virtual Offset bytes() const = 0;
  virtual Movement movement() const { return {}; }
  /// Null where the factors lie on the host.
  virtual ResidentFactors<Value>* resident() { return nullptr; }
};

enum class HostSpace { serial, openmp };

/// How factors in the memory of the host do with less of it: by a file in `folder`.
struct OutOfCore {
  std::string folder;
  SegmentPlan segments;
  Vertex columns = 1;  // whose vectors have room in the region
  NumericBytes bytes;  // without the ladder's
  Movement movement;
};
/// In `available` bytes, `ladder_bytes(columns)` of which are others'. Fewer than kSolveColumns columns are
/// solved for at once only where the vectors of so many have no room. Throws OutOfMemory with bytes that
/// would do.
OutOfCore plan_out_of_core(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes,
                           const std::function<Offset(Vertex)>& ladder_bytes, const std::string& folder,
                           Offset available);

/// Of factors in the memory of the host: `scalar_bytes` of an entry of the factors, `value_bytes` of one of
/// the matrix; `columns` right-hand sides that there is room for.
NumericBytes host_bytes(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes, Vertex columns);

/// With single_precision the factors are float or complex<float>, whatever Value is. Must be made and used
/// inside Engine::run, with `threads` the number given there. `outside` is null where all factors are in
/// memory; `columns` are solved for at once then. Throws std::bad_alloc, and then BackendError("file") as all
/// that moves factors to the file or back.
template <class Value>
std::unique_ptr<Factors<Value>> make_host_factors(HostSpace space, bool single_precision,
                                                  std::shared_ptr<const SymbolicPlan> plan,
                                                  std::shared_ptr<const Pattern> pattern, int threads,
                                                  const OutOfCore* outside = nullptr,
                                                  Vertex columns = kSolveColumns);

}  // namespace mfs
