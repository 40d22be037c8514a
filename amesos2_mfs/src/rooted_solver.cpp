#include "rooted_solver.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "on_all_ranks.hpp"
#include "relayed.hpp"

namespace mfs::amesos2 {
namespace {

constexpr std::int64_t kMostRows = std::numeric_limits<std::int32_t>::max();

/// "(global ids: row 70, column 30)"
std::string place_text(std::int64_t row, std::int64_t column) {
  std::string text = " (global ids:";
  if (row >= 0) text += " row " + std::to_string(row);
  if (column >= 0) text += std::string(row >= 0 ? "," : "") + " column " + std::to_string(column);
  return text + ")";
}

/// Position -> id; "none" stays "none".
std::int64_t id_of(std::int64_t position, const std::vector<std::int64_t>& ids) {
  return position >= 0 && position < static_cast<std::int64_t>(ids.size()) ? ids[position] : -1;
}

/// Runs `work` and puts the caller's ids in place of positions in what it throws. Where `vector_ids` is
/// given, invalid input is an entry of a right-hand side with these ids, and its column a number of that.
void with_global_ids(const std::vector<std::int64_t>& row_ids, const std::vector<std::int64_t>& unknown_ids,
                     const std::vector<std::int64_t>* vector_ids, const std::function<void()>& work) {
  try {
    work();
  } catch (const SingularMatrix& e) {
    const std::int64_t row = id_of(e.row(), row_ids), column = id_of(e.column(), unknown_ids);
    if (row < 0 && column < 0) throw;
    throw Relayed<SingularMatrix>(e.what() + place_text(row, column), e.kind(), row, column,
                                  e.dependent_rows(), e.what());
  } catch (const PatternChanged& e) {
    const std::int64_t row = id_of(e.row(), row_ids);
    if (row < 0) throw;
    throw Relayed<PatternChanged>(e.what() + place_text(row, -1), e.what(), row);
  } catch (const InvalidInput& e) {
    const std::int64_t row = id_of(e.row(), vector_ids != nullptr ? *vector_ids : row_ids);
    const std::int64_t column = vector_ids != nullptr ? -1 : id_of(e.column(), unknown_ids);
    if (row < 0 && column < 0) throw;
    throw Relayed<InvalidInput>(e.what() + place_text(row, column), e.argument(), e.what(), row,
                                vector_ids != nullptr ? e.column() : column);
  }
}

template <class Integer>
bool in_order(const std::vector<Integer>& positions) {
  for (std::size_t k = 0; k < positions.size(); ++k)
    if (positions[k] != static_cast<Integer>(k)) return false;
  return true;
}

/// Whether an entry is stored whose value is 0.
bool holds_zeros(const CsrView<double>& a) {
  const double* end = a.values + a.row_offsets[a.rows];
  return std::find(a.values, end, 0.0) != end;
}

/// Throws SingularMatrix where the pattern alone, with any values, is structurally singular. The matching
/// finds that: what an analysis does beyond it would be done in vain, and is left.
void match_without_values(Options options, CsrView<double> a) {
  struct BeyondMatching {};
  options.dump_prefix.clear();
  options.log = nullptr;
  options.progress = [](const Progress& at) {
    if (at.phase != std::string_view("matching")) throw BeyondMatching();
  };
  const std::vector<double> ones(static_cast<std::size_t>(a.row_offsets[a.rows]), 1.0);
  a.values = ones.data();
  try {
    Solver(std::move(options)).analyze(a);
  } catch (const BeyondMatching&) {
  }
}

/// Ids of all ranks on rank 0.
std::vector<std::int64_t> gather_ids(const Teuchos::Comm<int>& comm, const RankGather& gather,
                                     const std::vector<std::int64_t>& ids) {
  std::vector<std::int64_t> all;
  on_all_ranks(comm, [&] { all.resize(comm.getRank() == 0 ? gather.total() : 0); });
  gather.to_root(ids.data(), all.data());
  return all;
}

void refuse_duplicates(const IdPositions& positions, const char* what) {
  std::int64_t id = 0;
  if (positions.has_duplicate(id))
    throw InvalidInput("A", std::string(what) + " with global id " + std::to_string(id) + " is held twice",
                       id);
}

}  // namespace

RootedSolver::RootedSolver(Teuchos::RCP<const Teuchos::Comm<int>> comm) : comm_(std::move(comm)) {}

void RootedSolver::set_options(Options options) {
  options_ = std::move(options);
  solver_.reset();
  bytes_.set(0);
  analyzed_ = factored_ = analysis_due_ = false;
}

void RootedSolver::load(const LocalIds& ids, const LocalRows& rows) {
  analyzed_ = factored_ = false;
  number_unknowns(ids);
  entry_gather_ = RankGather(comm_, rows.entries());
  on_all_ranks(*comm_, [&] {
    if (root() && !solver_) solver_ = std::make_unique<Solver>(options_);
    if (one_rank()) return;
    remember_pattern(ids, rows);
    if (root()) values_.resize(entry_gather_.total());
  });
  if (one_rank()) {
    use_rows(rows, column_positions_);
  } else {
    gather_pattern(ids, rows);
    entry_gather_.to_root(rows.values, values_.data());
    matrix_ = {row_gather_.total(), row_gather_.total(), offsets_.data(), columns_.data(), values_.data()};
  }
}

void RootedSolver::load_values(const LocalRows& rows, const std::vector<std::int64_t>* column_ids) {
  on_all_ranks(*comm_, [&] {
    if (!analyzed_) throw StateError("numericFactorization: symbolicFactorization has not succeeded");
    check_pattern(rows, column_ids);
    if (one_rank() && column_ids != nullptr)
      use_rows(rows, positions_of_columns(column_ids->data(), column_ids->size()));
    else if (one_rank())
      use_rows(rows, column_positions_);
  });
  if (!one_rank()) entry_gather_.to_root(rows.values, values_.data());
}

/// Gathers the ids of rows and unknowns and gives positions to them.
void RootedSolver::number_unknowns(const LocalIds& ids) {
  row_gather_ = RankGather(comm_, static_cast<std::int64_t>(ids.rows.size()));
  const RankGather unknown_gather(comm_, static_cast<std::int64_t>(ids.unknowns.size()));
  on_all_ranks(*comm_, [&] {
    if (row_gather_.total() != unknown_gather.total())
      throw InvalidInput("A", "it has " + std::to_string(row_gather_.total()) + " rows and " +
                                  std::to_string(unknown_gather.total()) + " columns: not square");
    if (row_gather_.total() > kMostRows)
      throw InvalidInput("A", "more than " + std::to_string(kMostRows) + " rows");
  });
  row_ids_ = gather_ids(*comm_, row_gather_, ids.rows);
  unknown_ids_ = gather_ids(*comm_, unknown_gather, ids.unknowns);
  on_all_ranks(*comm_, [&] {
    if (!root()) return;
    row_positions_ = IdPositions(row_ids_);
    refuse_duplicates(row_positions_, "row");
    bool same_ids = true;
    for (const std::int64_t id : unknown_ids_) same_ids = same_ids && row_positions_.find(id) >= 0;
    unknown_positions_ = same_ids ? row_positions_ : IdPositions(unknown_ids_);
    refuse_duplicates(IdPositions(unknown_ids_), "unknown");
    if (same_ids) unknown_ids_ = row_ids_;
    if (one_rank()) {
      column_positions_ = positions_of_columns(ids.columns.data(), ids.columns.size());
      if (in_order(column_positions_)) column_positions_.clear();
    }
  });
}

std::vector<std::int32_t> RootedSolver::positions_of_columns(const std::int64_t* ids,
                                                             std::size_t count) const {
  std::vector<std::int32_t> positions(count);
  for (std::size_t k = 0; k < count; ++k) {
    positions[k] = static_cast<std::int32_t>(unknown_positions_.find(ids[k]));
    if (positions[k] < 0)
      throw InvalidInput("A", "the domain map has no column with global id " + std::to_string(ids[k]), -1,
                         ids[k]);
  }
  return positions;
}

/// Several ranks: row offsets and columns on rank 0, in the solver's numbering.
void RootedSolver::gather_pattern(const LocalIds& ids, const LocalRows& rows) {
  const RankGather column_gather(comm_, static_cast<std::int64_t>(ids.columns.size()));
  std::vector<std::int64_t> lengths, all_column_ids;
  std::vector<std::int32_t> all_columns;
  on_all_ranks(*comm_, [&] {
    lengths.resize(rows.count);
    for (std::int64_t row = 0; row < rows.count; ++row)
      lengths[row] = rows.offsets[row + 1] - rows.offsets[row];
    if (!root()) return;
    offsets_.assign(row_gather_.total() + 1, 0);
    all_columns.resize(entry_gather_.total());
    columns_.resize(entry_gather_.total());
    all_column_ids.resize(column_gather.total());
  });
  row_gather_.to_root(lengths.data(), root() ? offsets_.data() + 1 : nullptr);
  entry_gather_.to_root(rows.columns, all_columns.data());
  column_gather.to_root(ids.columns.data(), all_column_ids.data());
  on_all_ranks(*comm_, [&] {
    if (!root()) return;
    for (std::size_t row = 1; row < offsets_.size(); ++row) offsets_[row] += offsets_[row - 1];
    std::int64_t first_id = 0, first_entry = 0;
    for (int rank = 0; rank < comm_->getSize(); ++rank) {
      const std::vector<std::int32_t> positions = positions_of_columns(
          all_column_ids.data() + first_id, static_cast<std::size_t>(column_gather.count(rank)));
      translate_columns(all_columns.data() + first_entry, entry_gather_.count(rank), positions,
                        columns_.data() + first_entry);
      first_id += column_gather.count(rank);
      first_entry += entry_gather_.count(rank);
    }
  });
}

void RootedSolver::translate_columns(const std::int32_t* local_columns, std::int64_t count,
                                     const std::vector<std::int32_t>& positions,
                                     std::int32_t* columns) const {
  for (std::int64_t k = 0; k < count; ++k) columns[k] = positions[local_columns[k]];
}

void RootedSolver::remember_pattern(const LocalIds& ids, const LocalRows& rows) {
  pattern_offsets_.resize(rows.count + 1);
  pattern_offsets_[0] = 0;
  for (std::int64_t row = 0; row < rows.count; ++row) pattern_offsets_[row + 1] = rows.offsets[row + 1];
  pattern_columns_.assign(rows.columns, rows.columns + rows.entries());
  pattern_row_ids_ = ids.rows;
  pattern_column_ids_ = ids.columns;
}

/// With one rank the solver itself compares; here only what it cannot see.
void RootedSolver::check_pattern(const LocalRows& rows, const std::vector<std::int64_t>* column_ids) const {
  const int rank = comm_->getRank();
  if (rows.count != row_gather_.count(rank))
    throw PatternChanged("rank " + std::to_string(rank) + " holds " + std::to_string(rows.count) +
                             " rows, symbolicFactorization saw " + std::to_string(row_gather_.count(rank)),
                         -1);
  if (one_rank()) return;
  const auto same_column = [&](std::int32_t now, std::int32_t before) {
    return column_ids == nullptr ? now == before : (*column_ids)[now] == pattern_column_ids_[before];
  };
  for (std::int64_t row = 0; row < rows.count; ++row) {
    const std::int64_t first = pattern_offsets_[row], last = pattern_offsets_[row + 1];
    if (rows.offsets[row + 1] == last &&
        std::equal(rows.columns + first, rows.columns + last, pattern_columns_.data() + first, same_column))
      continue;
    throw PatternChanged("it is not the one that symbolicFactorization saw, first in the row of global id " +
                             std::to_string(pattern_row_ids_[row]),
                         pattern_row_ids_[row]);
  }
}

/// One rank: reads the caller's arrays in place; only columns in another order have to be copied.
void RootedSolver::use_rows(const LocalRows& rows, const std::vector<std::int32_t>& column_positions) {
  local_rows_ = rows;
  device_values_ = {};
  IndexSpan columns = rows.columns;
  if (!column_positions.empty()) {
    columns_.resize(rows.entries());
    translate_columns(rows.columns, rows.entries(), column_positions, columns_.data());
    columns = columns_.data();
  }
  matrix_ = {rows.count, rows.count, rows.offsets, columns, rows.values};
}

void RootedSolver::on_root(const std::function<void(Solver&)>& work,
                           const std::vector<std::int64_t>* vector_ids) {
  on_all_ranks(*comm_, [&] {
    if (!root()) return;
    if (row_positions_.identity() && unknown_positions_.identity()) {
      work(*solver_);
      return;
    }
    with_global_ids(row_ids_, unknown_ids_, vector_ids, [&] { work(*solver_); });
  });
}

void RootedSolver::analyze() {
  analyzed_ = factored_ = analysis_due_ = false;
  bytes_.set(0);
  on_root([&](Solver& solver) {
    try {
      counted(Phase::analysis, 1, [&] { solver.analyze(matrix_); });
    } catch (const SingularMatrix&) {
      if (!holds_zeros(matrix_)) throw;
      match_without_values(options_, matrix_);
      analysis_due_ = true;
    }
  });
  analyzed_ = true;
}

void RootedSolver::forget_factorization() {
  factored_ = false;
  last_failure_.clear();
}

void RootedSolver::require_factorization() const {
  if (factored_) return;
  throw StateError("solve: there is no factorization" +
                   (last_failure_.empty() ? "" : "; the last numericFactorization failed: " + last_failure_));
}

void RootedSolver::factor() {
  forget_factorization();
  if (!analyzed_) throw StateError("numericFactorization: symbolicFactorization has not succeeded");
  // Every factorization is given its arrays anew: none is held longer, Tpetra would refuse others the access.
  const DeviceValues device_values = std::exchange(device_values_, {});
  const LocalRows local_rows = std::exchange(local_rows_, {});
  try {
    on_root([&](Solver& solver) {
      if (analysis_due_) counted(Phase::analysis, 1, [&] { solver.analyze(matrix_); });
      analysis_due_ = false;
      counted(Phase::factorization, 1, [&] {
        if (device_values.data != nullptr)
          solver.refactor_device(device_values.data, device_values.stream);
        else if (solver.factored())
          solver.refactor(matrix_);
        else
          solver.factor(matrix_);
      });
      bytes_.set(solver.report().bytes_used);
    });
  } catch (const std::exception& e) {
    last_failure_ = e.what();
    throw;
  }
  factored_ = true;
}

VectorLayout RootedSolver::make_layout(const std::vector<std::int64_t>& ids, Space space) const {
  const RankGather gather(comm_, static_cast<std::int64_t>(ids.size()));
  std::vector<std::int64_t> positions = gather_ids(*comm_, gather, ids);
  const char* name = space == Space::rows ? "right-hand side" : "solution";
  on_all_ranks(*comm_, [&] {
    if (gather.total() != row_gather_.total())
      throw InvalidInput(name, std::to_string(gather.total()) + " entries for " +
                                   std::to_string(row_gather_.total()) + " rows");
    if (!root()) return;
    refuse_duplicates(IdPositions(positions), name);
    const IdPositions& known = space == Space::rows ? row_positions_ : unknown_positions_;
    for (std::size_t k = 0; k < positions.size(); ++k) {
      const std::int64_t position = known.find(positions[k]);
      if (position < 0)
        throw InvalidInput(name,
                           "the matrix has no row or unknown with global id " + std::to_string(positions[k]),
                           positions[k]);
      positions[k] = position;
    }
    if (in_order(positions)) positions.clear();
  });
  if (!root()) positions.clear();
  return {gather, std::move(positions)};
}

void RootedSolver::solve(const VectorLayout& b_layout, LocalColumns<const double> b,
                         const VectorLayout& x_layout, LocalColumns<double> x, std::int64_t columns,
                         bool transpose) {
  require_factorization();
  if (columns == 0) return;
  const std::int64_t n = row_gather_.total();
  const std::vector<std::int64_t>* b_ids = transpose ? &unknown_ids_ : &row_ids_;
  const auto run = [&](Solver& solver, const double* from, double* to, std::int64_t ldb, std::int64_t ldx) {
    counted(Phase::solve, columns, [&] {
      if (b.on_device && transpose)
        solver.solve_transpose_device(from, to, columns, ldb, ldx, stream_);
      else if (b.on_device)
        solver.solve_device(from, to, columns, ldb, ldx, stream_);
      else if (transpose)
        solver.solve_transpose(from, to, columns, ldb, ldx);
      else
        solver.solve(from, to, columns, ldb, ldx);
    });
  };
  if (one_rank() && b_layout.in_order() && x_layout.in_order()) {
    on_root(
        [&](Solver& solver) { run(solver, b.data, x.data, std::max(b.stride, n), std::max(x.stride, n)); },
        b_ids);
    return;
  }
  on_all_ranks(*comm_, [&] {
    if (!root()) return;
    right_hand_sides_.resize(n * columns);
    piece_.resize(n);
  });
  for (std::int64_t j = 0; j < columns; ++j) {
    double* column = root() ? right_hand_sides_.data() + j * n : nullptr;
    b_layout.gather().to_root(b.data + j * b.stride, b_layout.in_order() ? column : piece_.data());
    const auto& positions = b_layout.positions();
    for (std::size_t k = 0; k < positions.size(); ++k) column[positions[k]] = piece_[k];
  }
  on_root([&](Solver& solver) { run(solver, right_hand_sides_.data(), right_hand_sides_.data(), n, n); },
          b_ids);
  for (std::int64_t j = 0; j < columns; ++j) {
    const double* column = root() ? right_hand_sides_.data() + j * n : nullptr;
    const auto& positions = x_layout.positions();
    for (std::size_t k = 0; k < positions.size(); ++k) piece_[k] = column[positions[k]];
    x_layout.gather().from_root(x_layout.in_order() ? column : piece_.data(), x.data + j * x.stride);
  }
}

void RootedSolver::solve_device(const double* b, double* x, void* stream) {
  const std::int64_t n = row_gather_.total();
  on_root(
      [&](Solver& solver) { counted(Phase::solve, 1, [&] { solver.solve_device(b, x, 1, n, n, stream); }); },
      &row_ids_);
}

const Report& RootedSolver::report() const {
  static const Report none;
  return solver_ ? solver_->report() : none;
}

std::vector<DepthSummary> RootedSolver::depths() const {
  return solver_ ? solver_->depths() : std::vector<DepthSummary>();
}

}  // namespace mfs::amesos2
