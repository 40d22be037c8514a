#include "dae/integrator/partition.hpp"

#include <umfpack.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "dae/vectors/host_loops.hpp"

namespace mfs::dae {
namespace {

/// A pivot below this part of its constraint's largest entry is rounding.
constexpr double kRedundant = 1e-10;

[[noreturn]] void fail(const char* library, bool no_memory, int status, const char* what) {
  if (no_memory) throw OutOfMemory(MemorySpace::host, 0, 0);
  throw BackendError(library, status, std::string("redundant constraints: ") + what);
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

}  // namespace mfs::dae
