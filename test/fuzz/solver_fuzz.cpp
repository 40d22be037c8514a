// Any bytes as a system for the public class: it is refused with one of its errors, or solved with a small
// backward error by plain code; the object works afterwards. Entry point of libFuzzer (preset
// fuzz) and of replay_corpus.cpp.
//
// The bytes, as long as they last (zeros after that):
//
//   shape   1  rows, 0..12           options 1  bit 0: 64-bit offsets, 1: 64-bit columns, 2: pattern analysed
//                                               first, 3: no matching, 4: no scaling, 5: single precision
//                                               factors, 6: transposed, 7: refactored with other values
//   lie     1  how the arrays lie: 0..191 they do not, else which of them is made wrong
//   per row 1  number of entries, 0..7; each entry 2: column (modulo rows), value
//   b       1 per row
//
// A value byte is an index into a table of awkward numbers, or a small integer.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <vector>

#include <mfs/mfs.hpp>

#include "test/reference/sparse.hpp"

namespace {

using mfs::test::SparseMatrix;

constexpr std::int64_t kMostRows = 12;
constexpr long double kLeast = std::numeric_limits<double>::denorm_min();

void require(bool condition) {
  if (!condition) std::abort();
}

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  int next() { return at_ < size_ ? data_[at_++] : 0; }
  double value() {
    static constexpr double kAwkward[] = {0,   1e-300, 1e300,   1e-16,   1 + 1e-15, 1e16, 1e-8,
                                          1e8, 5e-324, 1.7e308, 1.0 / 3, 1e-160,    1e160};
    constexpr int kCount = static_cast<int>(std::size(kAwkward));
    const int byte = next();
    if (byte == 255) return std::numeric_limits<double>::quiet_NaN();
    if (byte == 254) return std::numeric_limits<double>::infinity();
    if (byte >= 200) return (byte % 2 ? -1 : 1) * kAwkward[(byte - 200) / 2 % kCount];
    return byte < 100 ? byte / 8.0 : (100 - byte) / 8.0;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

struct System {
  SparseMatrix a;
  std::vector<double> b;
  int options = 0, lie = 0;
};

System read_system(Bytes bytes) {
  System system;
  SparseMatrix& a = system.a;
  a.n = bytes.next() % (kMostRows + 1);
  system.options = bytes.next();
  system.lie = bytes.next();
  a.offsets.push_back(0);
  for (std::int64_t i = 0; i < a.n; ++i) {
    for (int k = bytes.next() % 8; k > 0; --k) {
      a.columns.push_back(static_cast<std::int32_t>(bytes.next() % a.n));
      a.values.push_back(bytes.value());
    }
    a.offsets.push_back(a.entries());
  }
  for (std::int64_t i = 0; i < a.n; ++i) system.b.push_back(bytes.value());
  return system;
}

// Makes one of the arrays wrong, so that it has to be refused; false where `lie` asks for none, or there is
// nothing to be made wrong. Offsets only get smaller: how long the arrays are, nobody can check.
bool tell_a_lie(int lie, std::vector<std::int64_t>& offsets, std::vector<std::int64_t>& columns) {
  if (lie < 192) return false;
  if (lie < 224) {
    if (offsets.size() < 3) return false;
    offsets[1 + static_cast<std::size_t>(lie) % (offsets.size() - 2)] = -1 - lie;
    return true;
  }
  if (columns.empty()) return false;
  const std::int64_t wrong[] = {-1, kMostRows + 1, 1 << 30, std::numeric_limits<std::int32_t>::min()};
  columns[static_cast<std::size_t>(lie) % columns.size()] = wrong[lie % 4];
  return true;
}

mfs::Options options_of(int bits) {
  mfs::Options options;
  options.threads = 1;
  options.backend = mfs::Backend::serial;
  if (bits & 8) options.analysis.matching = mfs::Matching::never;
  if (bits & 16) options.analysis.scaling = false;
  if (bits & 32) options.factor.precision = mfs::Precision::single;
  return options;
}

// |b - A x| <= 1e-12 (|A| |x| + |b|) in every row, beside what doubles cannot hold: a product below their
// range is lost, and an unknown there has no digits, so that much is free for each.
bool is_solution(const SparseMatrix& a, const std::vector<double>& b, const std::vector<double>& x) {
  for (std::int64_t i = 0; i < a.n; ++i) {
    long double residual = b[i], size = std::fabs(residual), lost = kLeast;
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      const long double product = static_cast<long double>(a.values[k]) * x[a.columns[k]];
      residual -= product;
      size += std::fabs(product);
      lost += kLeast * (1 + 8 * std::fabs(a.values[k]));
    }
    if (!(std::fabs(residual) <= 1.01e-12L * size + lost)) return false;
  }
  return true;
}

// Solves; what was returned has to be a solution.
void solve(mfs::Solver& solver, const System& system) {
  const bool transpose = system.options & 64;
  std::vector<double> x(system.b.size(), 7.0);
  if (transpose)
    solver.solve_transpose(system.b.data(), x.data());
  else
    solver.solve(system.b.data(), x.data());
  require(is_solution(transpose ? mfs::test::transposed(system.a) : system.a, system.b, x));
  require(solver.report().backward_error <= 1e-12);
}

template <class Offset, class Column>
void treat(mfs::Solver& solver, const System& system, const std::vector<std::int64_t>& offsets,
           const std::vector<std::int64_t>& columns) {
  const std::vector<Offset> o(offsets.begin(), offsets.end());
  const std::vector<Column> c(columns.begin(), columns.end());
  const auto n = static_cast<std::int64_t>(system.b.size());
  mfs::CsrView<double> view{n, n, o.data(), c.data(), system.a.values.data()};
  if (system.options & 4) {
    mfs::CsrView<double> pattern = view;
    pattern.values = nullptr;
    solver.analyze(pattern);
  }
  solver.factor(view);
  solve(solver, system);
  if (!(system.options & 128)) return;
  System other = system;
  for (std::size_t k = 0; k < other.a.values.size(); ++k) other.a.values[k] *= k % 3 == 0 ? 0 : 1.5;
  solver.refactor(other.a.values.data());
  solve(solver, other);
}

void expect_usable(mfs::Solver& solver) {
  const std::int32_t offsets[] = {0, 2, 4}, columns[] = {0, 1, 0, 1};
  const double values[] = {2, 1, 1, 3}, b[] = {3, 4};
  double x[2] = {};
  solver.analyze({2, 2, offsets, columns, values});
  solver.factor({2, 2, offsets, columns, values});
  solver.solve(b, x);
  require(std::fabs(x[0] - 1) < 1e-14 && std::fabs(x[1] - 1) < 1e-14);
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const System system = read_system(Bytes(data, size));
  std::vector<std::int64_t> offsets = system.a.offsets,
                            columns(system.a.columns.begin(), system.a.columns.end());
  const bool lied = tell_a_lie(system.lie, offsets, columns);
  mfs::Solver solver(options_of(system.options));
  try {
    const bool wide_offsets = system.options & 1, wide_columns = system.options & 2;
    if (wide_offsets && wide_columns) treat<std::int64_t, std::int64_t>(solver, system, offsets, columns);
    if (wide_offsets && !wide_columns) treat<std::int64_t, std::int32_t>(solver, system, offsets, columns);
    if (!wide_offsets && wide_columns) treat<std::int32_t, std::int64_t>(solver, system, offsets, columns);
    if (!wide_offsets && !wide_columns) treat<std::int32_t, std::int32_t>(solver, system, offsets, columns);
    require(!lied);
  } catch (const mfs::SingularMatrix& e) {
    require(e.row() >= -1 && e.row() < system.a.n && e.column() >= -1 && e.column() < system.a.n);
    require(e.row() >= 0 || e.column() >= 0);
    require(e.dependent_rows() >= 1);
  } catch (const mfs::Error&) {
  }
  expect_usable(solver);
  return 0;
}
