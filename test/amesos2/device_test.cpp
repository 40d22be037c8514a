// Amesos2::MFS with a Tpetra whose arrays lie on a CUDA device. With Backend::cuda they must be read and
// written there: copies between host and device that Tpetra or the adapter make show in the events of the
// Kokkos that both use. Solutions are checked by plain loops on the host.
#include <Amesos2_MFS.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <mfs/mfs.hpp>

#include "test/amesos2/systems.hpp"

namespace {

using namespace mfs::test;
using Solver = Amesos2::Solver<Matrix, Vector>;
using DeviceMatrix = Matrix::local_matrix_device_type;
using Values = DeviceMatrix::values_type;

constexpr Ordinal kWidth = 40, kHeight = 30, kRows = kWidth * kHeight;

/// Counts the copies between host and device, as long as it lives, that are more than a few numbers.
class CopyCounter {
 public:
  CopyCounter() {
    count() = 0;
    Kokkos::Tools::Experimental::set_begin_deep_copy_callback(&note);
  }
  ~CopyCounter() { Kokkos::Tools::Experimental::set_begin_deep_copy_callback(nullptr); }
  static int& count() {
    static int copies = 0;
    return copies;
  }

 private:
  using Handle = Kokkos::Tools::SpaceHandle;
  static bool on_device(const Handle& space) { return std::strncmp(space.name, "Cuda", 4) == 0; }
  static void note(Handle to, const char*, const void*, Handle from, const char*, const void*,
                   std::uint64_t bytes) {
    constexpr std::uint64_t kFew = 128;
    if (on_device(to) != on_device(from) && bytes > kFew) ++count();
  }
};

/// Other values everywhere, and a value at one place.
struct Scale {
  Values values;
  double factor;
  KOKKOS_INLINE_FUNCTION void operator()(int k) const { values(k) *= factor + 0.01 * (k % 5); }
};
struct Put {
  Values values;
  int place;
  double value;
  KOKKOS_INLINE_FUNCTION void operator()(int) const { values(place) = value; }
};
using Kernel = Kokkos::RangePolicy<Matrix::execution_space, int>;

Values values_of(const Matrix& a) {
  return a.getLocalMatrixDevice().values;
}
void change_on_device(const Matrix& a, double factor) {
  const Values values = values_of(a);
  Kokkos::parallel_for("change", Kernel(0, static_cast<int>(values.extent(0))), Scale{values, factor});
}
void put_on_device(const Matrix& a, int place, double value) {
  Kokkos::parallel_for("put", Kernel(0, 1), Put{values_of(a), place, value});
}

int first_entry(const Matrix& a, int row) {
  return static_cast<int>(a.getLocalMatrixHost().graph.row_map(row));
}

RCP<Matrix> grid() {
  return assemble(grid_entries(kWidth, kHeight), even_map(kRows));
}

RCP<Solver> make(const RCP<const Matrix>& a, const char* backend, bool transpose = false) {
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", a);
  solver->setParameters(amesos2_parameters([&](auto& list) {
    list.set("Backend", backend);
    list.set("Trans", transpose ? "TRANS" : "NOTRANS");
  }));
  return solver;
}

/// max |b - A x|_i / (|A| |x| + |b|)_i over rows and columns.
double backward_error(const Matrix& a, const Vector& x, const Vector& b, bool transpose = false) {
  const auto local = a.getLocalMatrixHost();
  const auto host_x = x.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto host_b = b.getLocalViewHost(Tpetra::Access::ReadOnly);
  const std::size_t n = host_b.extent(0);
  double worst = 0.0;
  for (std::size_t j = 0; j < host_b.extent(1); ++j) {
    std::vector<double> residual(n), bound(n);
    for (std::size_t i = 0; i < n; ++i) {
      residual[i] = host_b(i, j);
      bound[i] = std::abs(host_b(i, j));
    }
    for (std::size_t row = 0; row < n; ++row)
      for (std::size_t k = local.graph.row_map(row); k < local.graph.row_map(row + 1); ++k) {
        const std::size_t column = local.graph.entries(k);
        const std::size_t to = transpose ? column : row, from = transpose ? row : column;
        residual[to] -= local.values(k) * host_x(from, j);
        bound[to] += std::abs(local.values(k) * host_x(from, j));
      }
    for (std::size_t i = 0; i < n; ++i)
      if (const double error = std::abs(residual[i]) / bound[i]; !(error <= worst)) worst = error;
  }
  return worst;
}

/// Solves for the samples as right-hand sides and returns the backward error.
double solve_error(Solver& solver, const Matrix& a, std::size_t columns, bool transpose = false) {
  const auto b = samples(a.getRangeMap(), columns);
  Vector x(a.getDomainMap(), columns);
  solver.solve(&x, b.get());
  return backward_error(a, x, *b, transpose);
}

constexpr double kSmall = 1e-12;

class Amesos2Device : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Backends, Amesos2Device, ::testing::Values("cuda", "openmp"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(Amesos2Device, SolvesWhatChangesOnTheDevice) {
  const auto a = grid();
  const auto solver = make(a, GetParam());
  solver->symbolicFactorization().numericFactorization();
  EXPECT_LT(solve_error(*solver, *a, 1), kSmall);
  for (const double factor : {1.5, -0.7, 3.0}) {
    change_on_device(*a, factor);
    solver->numericFactorization();
    EXPECT_LT(solve_error(*solver, *a, 1), kSmall) << factor;
    EXPECT_LT(solve_error(*solver, *a, 17), kSmall) << factor;
  }
  EXPECT_EQ(solver->getStatus().getNumSymbolicFact(), 1);
}

TEST_P(Amesos2Device, Transposed) {
  const auto a = grid();
  const auto solver = make(a, GetParam(), true);
  for (const double factor : {1.0, 1.5}) {
    change_on_device(*a, factor);
    solver->numericFactorization();
    EXPECT_LT(solve_error(*solver, *a, 1, true), kSmall) << factor;
    EXPECT_LT(solve_error(*solver, *a, 17, true), kSmall) << factor;
  }
}

TEST_P(Amesos2Device, SolutionOverRightHandSide) {
  const auto a = grid();
  const auto b = samples(a->getRangeMap(), 3);
  Vector x(*b, Teuchos::Copy);
  make(a, GetParam())->solve(&x, &x);
  EXPECT_LT(backward_error(*a, x, *b), kSmall);
}

TEST_P(Amesos2Device, ColumnsThatDoNotLieAtOneDistance) {
  const auto a = grid();
  const auto b = samples(a->getRangeMap(), 4);
  Vector x(a->getDomainMap(), 4);
  const Teuchos::Array<std::size_t> columns = Teuchos::tuple<std::size_t>(0, 1, 3);
  make(a, GetParam())->solve(x.subViewNonConst(columns()).get(), b->subView(columns()).get());
  const Vector solved(*x.subView(columns()), Teuchos::Copy), asked(*b->subView(columns()), Teuchos::Copy);
  EXPECT_LT(backward_error(*a, solved, asked), kSmall);
}

TEST_P(Amesos2Device, VectorsInAnotherOrder) {
  const auto a = grid();
  const auto solver = make(a, GetParam());
  Ids backwards;
  for (Ordinal k = kRows; k > 0; --k) backwards.push_back(k - 1);
  const auto map = dealt_map(backwards);
  const auto b = image(*a);
  Vector turned_b(map, 1), turned_x(map, 1);
  {
    const auto from = b->getLocalViewHost(Tpetra::Access::ReadOnly);
    const auto to = turned_b.getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (Ordinal k = 0; k < kRows; ++k) to(kRows - 1 - k, 0) = from(k, 0);
  }
  solver->solve(&turned_x, &turned_b);
  EXPECT_LT(distance_from_samples(turned_x), 1e-10);
}

/// Rows of ids that do not count up: their order on the rank is the solver's, so nothing leaves the device.
TEST_P(Amesos2Device, OtherIds) {
  const auto id = [](Ordinal k) { return 3 * ((k * 7) % kRows) + 5; };
  Ids ids;
  for (Ordinal k = 0; k < kRows; ++k) ids.push_back(id(k));
  const auto a = assemble(renamed(grid_entries(kWidth, kHeight), id, id), dealt_map(ids));
  const auto solver = make(a, GetParam());
  solver->numericFactorization();
  change_on_device(*a, 2.0);
  solver->numericFactorization();
  const auto b = image(*a, 2);
  Vector x(a->getDomainMap(), 2);
  solver->solve(&x, b.get());
  EXPECT_LT(distance_from_samples(x), 1e-10);
}

/// Tpetra refuses either side while a view of the other one is held: the solver must hold none.
TEST_P(Amesos2Device, HoldsNoView) {
  const auto a = grid();
  const auto solver = make(a, GetParam());
  const auto both_sides = [&] {
    EXPECT_NO_THROW(a->getLocalMatrixHost());
    EXPECT_NO_THROW(a->getLocalMatrixDevice());
  };
  solver->symbolicFactorization();
  both_sides();
  for (int step = 0; step < 3; ++step) {
    solver->numericFactorization();
    both_sides();
  }
  const auto b = samples(a->getRangeMap());
  Vector x(a->getDomainMap(), 1);
  solver->solve(&x, b.get());
  EXPECT_NO_THROW(x.getLocalViewHost(Tpetra::Access::ReadWrite));
  EXPECT_NO_THROW(x.getLocalViewDevice(Tpetra::Access::ReadWrite));
  EXPECT_NO_THROW(b->getLocalViewHost(Tpetra::Access::ReadOnly));
}

TEST_P(Amesos2Device, Singular) {
  const auto a = grid();
  const auto solver = make(a, GetParam());
  EXPECT_LT(solve_error(*solver, *a, 1), kSmall);
  constexpr int kRow = 600;
  const int first = first_entry(*a, kRow), last = first_entry(*a, kRow + 1);
  for (int k = first; k < last; ++k) put_on_device(*a, k, 0.0);
  const auto b = samples(a->getRangeMap());
  Vector x(a->getDomainMap(), 1);
  try {
    solver->numericFactorization();
    solver->solve(&x, b.get());
    FAIL() << "nothing was thrown";
  } catch (const mfs::SingularMatrix& e) {
    EXPECT_EQ(e.row(), kRow) << e.what();
    EXPECT_EQ(e.dependent_rows(), 1) << e.what();
  }
  for (int k = first; k < last; ++k) put_on_device(*a, k, 1.0 + k);
  solver->numericFactorization();
  EXPECT_LT(solve_error(*solver, *a, 1), kSmall);
  EXPECT_EQ(solver->getStatus().getNumSymbolicFact(), 1);
}

TEST_P(Amesos2Device, NotANumberHasAPlace) {
  const auto a = grid();
  const auto solver = make(a, GetParam());
  solver->numericFactorization();
  constexpr int kRow = 777;
  const int place = first_entry(*a, kRow) + 1;
  const std::int64_t column = a->getLocalMatrixHost().graph.entries(place);
  put_on_device(*a, place, std::numeric_limits<double>::quiet_NaN());
  try {
    solver->numericFactorization();
    FAIL() << "nothing was thrown";
  } catch (const mfs::InvalidInput& e) {
    EXPECT_EQ(e.row(), kRow) << e.what();
    EXPECT_EQ(e.column(), column) << e.what();
  }
  put_on_device(*a, place, -0.5);
  solver->numericFactorization();
  EXPECT_LT(solve_error(*solver, *a, 1), kSmall);
}

TEST_P(Amesos2Device, NotANumberInTheRightHandSide) {
  const auto a = grid();
  const auto solver = make(a, GetParam());
  const auto b = samples(a->getRangeMap(), 2);
  b->replaceLocalValue(44, 1, std::numeric_limits<double>::infinity());
  Vector x(a->getDomainMap(), 2);
  try {
    solver->solve(&x, b.get());
    FAIL() << "nothing was thrown";
  } catch (const mfs::InvalidInput& e) {
    EXPECT_EQ(e.row(), 44) << e.what();
    EXPECT_EQ(e.column(), 1) << e.what();
  }
}

/// Columns change, their number does not: the device's comparison must see it, the host's names the row.
TEST_P(Amesos2Device, ChangedPattern) {
  const auto a = grid();
  const auto solver = make(a, GetParam());
  solver->numericFactorization();
  Entries entries = grid_entries(kWidth, kHeight);
  ASSERT_EQ(entries.erase({610, 609}), 1);
  entries[{610, 608}] = -1.3;
  const auto changed = assemble(entries, even_map(kRows));
  solver->setA(changed, Amesos2::SYMBFACT);
  try {
    solver->numericFactorization();
    FAIL() << "nothing was thrown";
  } catch (const mfs::PatternChanged& e) {
    EXPECT_EQ(e.row(), 610) << e.what();
  }
  const auto again = grid();
  change_on_device(*again, 2.0);
  solver->setA(again, Amesos2::SYMBFACT);
  solver->numericFactorization();
  EXPECT_LT(solve_error(*solver, *again, 1), kSmall);
}

TEST(Amesos2DeviceCopies, NoneForNewValuesAndVectors) {
  const auto a = grid();
  const auto solver = make(a, "cuda");
  const auto b = samples(a->getRangeMap(), 17);
  Vector x(a->getDomainMap(), 17);
  solver->numericFactorization();
  change_on_device(*a, 1.5);
  {
    // Views are held as by a program that works on the device, and bring b there.
    const Values values = values_of(*a);
    const auto view_b = b->getLocalViewDevice(Tpetra::Access::ReadOnly);
    const auto view_x = x.getLocalViewDevice(Tpetra::Access::ReadWrite);
    const CopyCounter copies;
    solver->numericFactorization();
    EXPECT_EQ(copies.count(), 0) << "values";
    solver->solve(&x, b.get());
    EXPECT_EQ(copies.count(), 0) << "right-hand sides and solutions";
  }
  EXPECT_LT(backward_error(*a, x, *b), kSmall);
}

/// What the test above counts is there to be counted.
TEST(Amesos2DeviceCopies, SomeForTheHost) {
  const auto a = grid();
  const auto solver = make(a, "openmp");
  solver->numericFactorization();
  change_on_device(*a, 1.5);
  const CopyCounter copies;
  solver->numericFactorization();
  EXPECT_GT(copies.count(), 0);
}

}  // namespace
