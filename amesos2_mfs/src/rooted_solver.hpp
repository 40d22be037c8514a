// A distributed square system, solved on rank 0.
//
// Trilinos spreads rows, right-hand sides and solutions over ranks by global ids. Row k of the solver is the
// k-th row of all ranks in rank order; an unknown gets the position of the row of the same id, so that the
// diagonal stays the diagonal:
//
//   rank 0 rows   ids 10 20        solver rows      0  1  2
//   rank 1 rows   ids 35           ids             10 20 35     ids(k): what a message names
//
// With one rank, and with ids in their natural order, the solver reads the caller's arrays where they lie,
// with Backend::cuda also in the memory of the device. Nothing here knows Tpetra or Epetra: the adapter
// (solver_def.hpp) hands over plain arrays.
//
// All member functions are collective, and an error of one rank is thrown on all of them (on_all_ranks.hpp).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Teuchos_Comm.hpp>
#include <Teuchos_RCP.hpp>

#include <mfs/mfs.hpp>

#include "id_positions.hpp"
#include "rank_gather.hpp"
#include "totals.hpp"

namespace mfs::amesos2 {

/// Global ids of what this rank holds.
struct LocalIds {
  std::vector<std::int64_t> rows;
  std::vector<std::int64_t> columns;   ///< of the local columns that LocalRows::columns counts
  std::vector<std::int64_t> unknowns;  ///< of this rank's piece of a solution
};

/// The rows of this rank, borrowed.
struct LocalRows {
  std::int64_t count = 0;
  IndexSpan offsets;                      ///< count + 1
  const std::int32_t* columns = nullptr;  ///< local columns
  const double* values = nullptr;
  std::shared_ptr<const void> keep_alive;  ///< what the arrays belong to

  std::int64_t entries() const { return count == 0 ? 0 : offsets[count]; }
};

/// Values in the memory of the device, borrowed, in the order of LocalRows::values.
struct DeviceValues {
  const double* data = nullptr;
  void* stream = nullptr;  ///< a cudaStream_t in which they become what they are
  std::shared_ptr<const void> keep_alive;
};

/// This rank's piece of right-hand sides or solutions, borrowed; column j starts at data + j * stride.
template <class Entry>
struct LocalColumns {
  Entry* data = nullptr;
  std::int64_t stride = 0;
  bool on_device = false;
};

/// Where the local entries of a vector stand in the solver's numbering.
class VectorLayout {
 public:
  VectorLayout() = default;
  VectorLayout(RankGather gather, std::vector<std::int64_t> positions)
      : gather_(std::move(gather)), positions_(std::move(positions)) {}

  /// The gathered entries are in the solver's order already.
  bool in_order() const { return positions_.empty(); }
  const RankGather& gather() const { return gather_; }
  const std::vector<std::int64_t>& positions() const { return positions_; }

 private:
  RankGather gather_;
  std::vector<std::int64_t> positions_;  ///< of the gathered entries, on rank 0; empty where in order
};

class RootedSolver {
 public:
  /// Rows and right-hand sides, or unknowns and solutions: they may carry different ids.
  enum class Space { rows, unknowns };

  explicit RootedSolver(Teuchos::RCP<const Teuchos::Comm<int>> comm);

  /// Options of the next analysis; forgets the present one.
  void set_options(Options options);

  /// Brings pattern and values to rank 0. Throws InvalidInput (a row held twice, too many rows).
  void load(const LocalIds& ids, const LocalRows& rows);
  /// Brings values to rank 0, where the pattern is that of the last load(). `column_ids`: of the local
  /// columns, where they differ from those of the load. Throws PatternChanged, with the global id of the row.
  void load_values(const LocalRows& rows, const std::vector<std::int64_t>* column_ids = nullptr);

  /// Whether the solver can read and write arrays on the device: on one rank, with factors there.
  bool takes_device_arrays() const {
    return one_rank() && backend_info(options_.backend).memory == MemorySpace::device;
  }
  /// The same for values: they replace others.
  bool takes_device_values() const { return takes_device_arrays() && solver_ && solver_->factored(); }
  /// As load_values, for a pattern that the caller knows to be that of the last load().
  void load_device_values(DeviceValues values) { device_values_ = std::move(values); }
  /// The caller's stream (a cudaStream_t) in which arrays on the device become what they are.
  void set_stream(void* stream) { stream_ = stream; }

  /// Analyses pattern and values. A matrix that is structurally singular by entries stored as 0 may not have
  /// its values yet (FROSch of Trilinos 16.1 analyses so): its pattern is checked, and factor() analyses.
  void analyze();
  /// Factors, or refactors where that was done before.
  void factor();
  /// A factorization is about to be made: until it succeeds there is none.
  void forget_factorization();
  bool analyzed() const { return analyzed_; }
  bool factored() const { return factored_; }
  /// Throws StateError, with the reason of the last failure, where there is nothing to solve with.
  void require_factorization() const;

  /// For vectors of `space` whose local entries have these ids. Throws InvalidInput for an unknown id.
  VectorLayout make_layout(const std::vector<std::int64_t>& ids, Space space) const;
  /// Solves A X = B, or A^T X = B (then B is of space unknowns and X of space rows). Both on the host, or
  /// both on the device.
  void solve(const VectorLayout& b_layout, LocalColumns<const double> b, const VectorLayout& x_layout,
             LocalColumns<double> x, std::int64_t columns, bool transpose);

  /// One right-hand side on the device, in the order of the rows; `stream` is the caller's. Where
  /// takes_device_arrays() holds.
  void solve_device(const double* b, double* x, void* stream);

  /// Figures and tree of rank 0; empty on the others.
  const Report& report() const;
  std::vector<DepthSummary> depths() const;

 private:
  bool root() const { return comm_->getRank() == 0; }
  bool one_rank() const { return comm_->getSize() == 1; }
  void number_unknowns(const LocalIds& ids);
  void gather_pattern(const LocalIds& ids, const LocalRows& rows);
  std::vector<std::int32_t> positions_of_columns(const std::int64_t* ids, std::size_t count) const;
  void translate_columns(const std::int32_t* local_columns, std::int64_t count,
                         const std::vector<std::int32_t>& positions, std::int32_t* columns) const;
  void remember_pattern(const LocalIds& ids, const LocalRows& rows);
  void check_pattern(const LocalRows& rows, const std::vector<std::int64_t>* column_ids) const;
  void use_rows(const LocalRows& rows, const std::vector<std::int32_t>& column_positions);
  /// `work` with the solver of rank 0, and its errors on all ranks, with global ids.
  void on_root(const std::function<void(Solver&)>& work,
               const std::vector<std::int64_t>* vector_ids = nullptr);

  Teuchos::RCP<const Teuchos::Comm<int>> comm_;
  Options options_;
  std::unique_ptr<Solver> solver_;  ///< rank 0
  CountedBytes bytes_;
  bool analyzed_ = false;
  bool factored_ = false;
  bool analysis_due_ = false;  ///< rank 0: the values were not there when the pattern was analysed
  std::string last_failure_;

  RankGather row_gather_, entry_gather_;
  std::vector<std::int64_t> row_ids_, unknown_ids_;  ///< by position, rank 0
  IdPositions row_positions_, unknown_positions_;    ///< rank 0
  std::vector<std::int32_t> column_positions_;  ///< of local columns; one rank only, empty where in order

  std::vector<std::int64_t> offsets_;  ///< gathered pattern and values, rank 0, several ranks
  std::vector<std::int32_t> columns_;
  std::vector<double> values_;
  LocalRows local_rows_;        ///< one rank: the arrays in use
  CsrView<double> matrix_;      ///< rank 0: what the solver reads, unless the values are on the device
  DeviceValues device_values_;  ///< until they are factored
  void* stream_ = nullptr;

  std::vector<std::int64_t> pattern_row_ids_,
      pattern_column_ids_;  ///< this rank's own pattern, several ranks
  std::vector<std::int64_t> pattern_offsets_;
  std::vector<std::int32_t> pattern_columns_;

  std::vector<double> right_hand_sides_, piece_;  ///< rank 0
};

}  // namespace mfs::amesos2
