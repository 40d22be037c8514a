#include "dae/integrator/partition.hpp"

#include <klu.h>
#include <umfpack.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "dae/vectors/host_loops.hpp"

namespace mfs::dae {
namespace {

/// A pivot below this part of its constraint's largest entry is rounding.
constexpr double kRedundant = 1e-10;
/// It is not looked at while no entry of the constraints has changed more, in parts of the constraint's
/// largest: each pivot was at least half of what it was chosen from.
constexpr double kUnchanged = 0.25;
/// A choice has degraded when dependent coordinates move this many times more than they did at first.
constexpr double kDegraded = 4.0;

[[noreturn]] void fail(const char* library, bool no_memory, int status, const char* what) {
  if (no_memory) throw OutOfMemory(MemorySpace::host, 0, 0);
  throw BackendError(library, status, std::string("coordinate partitioning: ") + what);
}

struct Pivots {
  std::vector<int> row, column;  ///< of the k-th pivot
  std::vector<double> value;
};

/// Those of a matrix in compressed columns, by UMFPACK, which takes them by size.
Pivots find_pivots(int rows, const std::vector<int>& starts, const RawVector<int>& index,
                   const std::vector<double>& values) {
  double controls[UMFPACK_CONTROL];
  umfpack_di_defaults(controls);
  controls[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_UNSYMMETRIC;  // pivots by size
  controls[UMFPACK_SCALE] = UMFPACK_SCALE_NONE;               // coordinates have scales of their own
  controls[UMFPACK_SINGLETONS] = 0;  // a coordinate of one constraint would be its pivot whatever its size
  controls[UMFPACK_PIVOT_TOLERANCE] = 0.5;
  const auto check = [](int status, const char* what) {
    if (status != UMFPACK_OK && status != UMFPACK_WARNING_singular_matrix)
      fail("UMFPACK", status == UMFPACK_ERROR_out_of_memory, status, what);
  };
  const auto free_symbolic = [](void* p) { umfpack_di_free_symbolic(&p); };
  const auto free_numeric = [](void* p) { umfpack_di_free_numeric(&p); };
  const int columns = static_cast<int>(starts.size()) - 1;
  void* made = nullptr;
  // With values, the analysis sees which entries are zero.
  check(umfpack_di_symbolic(rows, columns, starts.data(), index.data(), values.data(), &made, controls,
                            nullptr),
        "symbolic factorization");
  const std::unique_ptr<void, decltype(free_symbolic)> symbolic(made, free_symbolic);
  check(umfpack_di_numeric(starts.data(), index.data(), values.data(), symbolic.get(), &made, controls,
                           nullptr),
        "factorization");
  const std::unique_ptr<void, decltype(free_numeric)> numeric(made, free_numeric);
  const auto count = static_cast<std::size_t>(std::min(rows, columns));
  Pivots p{std::vector<int>(static_cast<std::size_t>(rows)),
           std::vector<int>(static_cast<std::size_t>(columns)), std::vector<double>(count)};
  check(umfpack_di_get_numeric(nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, p.row.data(),
                               p.column.data(), p.value.data(), nullptr, nullptr, numeric.get()),
        "pivots");
  p.row.resize(count);
  p.column.resize(count);
  return p;
}

/// Whether a factorization chooses its pivots or takes those of the one before.
enum class PivotOrder { chosen, kept };

/// A square matrix in compressed columns and its factors, by KLU: constraints that share no frame are blocks
/// of their own, mostly with one row. Only the values change.
class BlockLu {
 public:
  BlockLu(std::vector<int> starts, std::vector<int> index)
      : starts_(std::move(starts)), index_(std::move(index)) {
    klu_defaults(&common_);
    common_.scale = 0;  // none: the entries are scaled
    symbolic_ = klu_analyze(static_cast<int>(starts_.size()) - 1, starts_.data(), index_.data(), &common_);
    check(symbolic_ != nullptr, "analysis");
  }
  ~BlockLu() {
    klu_free_numeric(&numeric_, &common_);
    klu_free_symbolic(&symbolic_, &common_);
  }
  BlockLu(const BlockLu&) = delete;

  /// False: singular, or so with the pivots kept. There are none to keep before the first and after a
  /// singular one.
  bool factor(std::vector<double> values, PivotOrder order) {
    if (order == PivotOrder::kept && numeric_ != nullptr)
      return klu_refactor(starts_.data(), index_.data(), values.data(), symbolic_, numeric_, &common_) != 0 &&
             common_.status == KLU_OK;
    klu_free_numeric(&numeric_, &common_);
    numeric_ = klu_factor(starts_.data(), index_.data(), values.data(), symbolic_, &common_);
    if (common_.status == KLU_SINGULAR) return false;
    check(numeric_ != nullptr, "factorization");
    return true;
  }
  /// x for A^T x = b.
  std::vector<double> solve_transpose(std::vector<double> b) {
    check(klu_tsolve(symbolic_, numeric_, symbolic_->n, 1, b.data(), &common_) != 0, "solution");
    return b;
  }

 private:
  void check(bool good, const char* what) const {
    if (!good) fail("KLU", common_.status == KLU_OUT_OF_MEMORY, common_.status, what);
  }

  klu_common common_{};
  std::vector<int> starts_, index_;
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
};

/// Phi_q with columns in the coordinates' scales and rows of largest entry 1.
std::vector<double> scaled(const Pattern& pattern, const std::vector<double>& values,
                           const std::vector<double>& scale, int threads) {
  std::vector<double> result(values.size());
  const auto scale_row = [&](std::size_t row) {
    double most = 0.0;
    for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
      most = std::max(most, std::abs(result[k] = values[k] * scale[pattern.column[k]]));
    if (most > 0.0)
      for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k) result[k] /= most;
  };
  parallel_for(static_cast<std::size_t>(pattern.rows), threads, scale_row, pattern.entries());
  return result;
}

/// The rows of `pattern` in `kept`, with values.
struct Rows {
  std::vector<int> starts{0};
  RawVector<int> column;
  std::vector<double> values;
};
Rows take_rows(const Pattern& pattern, const std::vector<double>& values, const std::vector<int>& kept) {
  Rows rows;
  for (const int row : kept) {
    const int begin = pattern.row_start[row], end = pattern.row_start[row + 1];
    rows.column.insert(rows.column.end(), pattern.column.begin() + begin, pattern.column.begin() + end);
    rows.values.insert(rows.values.end(), values.begin() + begin, values.begin() + end);
    rows.starts.push_back(static_cast<int>(rows.column.size()));
  }
  return rows;
}

/// +1 or -1, always the same for one pair of numbers (a step of splitmix64).
double random_sign(std::uint64_t sample, std::uint64_t index) {
  std::uint64_t z = (index + 1) * 0x9e3779b97f4a7c15ULL + sample;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return (z >> 63) != 0 ? 1.0 : -1.0;
}

}  // namespace

std::vector<int> redundant_rows(const Pattern& pattern, const std::vector<double>& values,
                                const std::vector<double>& scale) {
  const std::vector<double> entries = scaled(pattern, values, scale, 1);
  std::vector<int> kept(static_cast<std::size_t>(pattern.rows)), redundant;
  for (int row = 0; row < pattern.rows; ++row) kept[row] = row;
  // Once a pivot is rounding, what is eliminated with it is none the better: look again without these rows.
  while (!kept.empty()) {
    const Rows rows = take_rows(pattern, entries, kept);
    const Pivots pivots = find_pivots(pattern.columns, rows.starts, rows.column, rows.values);
    std::vector<char> found(kept.size(), 1);  // more rows than columns: the rest has no pivot
    for (std::size_t k = 0; k < pivots.value.size(); ++k)
      found[pivots.column[k]] = std::abs(pivots.value[k]) < kRedundant ? 1 : 0;
    std::vector<int> left;
    for (std::size_t k = 0; k < kept.size(); ++k) (found[k] != 0 ? redundant : left).push_back(kept[k]);
    if (left.size() == kept.size()) break;
    kept = std::move(left);
  }
  std::sort(redundant.begin(), redundant.end());
  return redundant;
}

class Partition::Impl {
 public:
  Impl(const Pattern& pattern, const std::vector<double>& values, std::vector<double> scale, int threads)
      : pattern_(pattern), scale_(std::move(scale)), threads_(threads), independent_(scale_.size(), 1) {
    if (pattern.rows == 0) return;
    looked_at_ = scaled(pattern_, values, scale_, threads_);
    for (const int row : find_pivots(pattern.columns, pattern.row_start, pattern.column, looked_at_).row)
      independent_[row] = 0;
    make_dependent_block();
    first_growth_ = std::max(growth(PivotOrder::chosen), 1.0);
  }

  const std::vector<char>& independent() const { return independent_; }
  bool degraded(const std::vector<double>& values) {
    if (pattern_.rows == 0) return false;
    std::vector<double> entries = scaled(pattern_, values, scale_, threads_);
    const auto unchanged = [](double a, double b) { return std::abs(a - b) <= kUnchanged; };
    if (std::equal(entries.begin(), entries.end(), looked_at_.begin(), unchanged)) return false;
    looked_at_ = std::move(entries);
    const double most = kDegraded * first_growth_;
    // Pivots that were chosen for other values are at hand sooner, and may show more growth than there is.
    return growth(PivotOrder::kept) > most && growth(PivotOrder::chosen) > most;
  }

 private:
  // Phi_d^T in compressed columns is Phi_d by rows.
  void make_dependent_block() {
    std::vector<int> number(independent_.size(), -1);
    int count = 0;
    for (std::size_t i = 0; i < independent_.size(); ++i)
      if (independent_[i] == 0) number[i] = count++;
    std::vector<int> starts{0}, index;
    for (int row = 0; row < pattern_.rows; ++row) {
      for (int k = pattern_.row_start[row]; k < pattern_.row_start[row + 1]; ++k)
        if (number[pattern_.column[k]] >= 0) {
          index.push_back(number[pattern_.column[k]]);
          entry_.push_back(k);
        }
      starts.push_back(static_cast<int>(index.size()));
    }
    dependent_ = std::make_unique<BlockLu>(std::move(starts), std::move(index));
  }

  /// Of the entries that are looked at.
  double growth(PivotOrder order) {
    std::vector<double> block(entry_.size());
    for (std::size_t k = 0; k < block.size(); ++k) block[k] = looked_at_[entry_[k]];
    if (!dependent_->factor(std::move(block), order)) return std::numeric_limits<double>::infinity();
    double most = 0.0;
    for (std::uint64_t sample = 0; sample < 2; ++sample) {
      std::vector<double> moved(static_cast<std::size_t>(pattern_.rows), 0.0);
      const auto move_by_signs = [&](std::size_t row) {
        for (int k = pattern_.row_start[row]; k < pattern_.row_start[row + 1]; ++k) {
          const int i = pattern_.column[k];
          if (independent_[i] != 0)
            moved[row] += looked_at_[k] * random_sign(sample, static_cast<std::uint64_t>(i));
        }
      };
      parallel_for(moved.size(), threads_, move_by_signs, looked_at_.size());
      for (const double x : dependent_->solve_transpose(std::move(moved))) most = std::max(most, std::abs(x));
    }
    return most;
  }

  const Pattern& pattern_;
  std::vector<double> scale_;
  int threads_;
  std::vector<char> independent_;
  std::vector<int> entry_;  ///< of Phi_q, for each entry of the dependent block
  std::unique_ptr<BlockLu> dependent_;
  double first_growth_ = 1.0;
  std::vector<double> looked_at_;  ///< scaled
};

Partition::Partition(const Pattern& position_q, const std::vector<double>& values, std::vector<double> scale,
                     int threads)
    : impl_(std::make_unique<Impl>(position_q, values, std::move(scale), threads)) {}
Partition::~Partition() = default;
Partition::Partition(Partition&&) noexcept = default;
Partition& Partition::operator=(Partition&&) noexcept = default;

const std::vector<char>& Partition::independent() const {
  return impl_->independent();
}
bool Partition::degraded(const std::vector<double>& values) {
  return impl_->degraded(values);
}

}  // namespace mfs::dae
