// Batches: every system is solved as if it were alone, by any number of threads, whatever becomes of others.
#include <gmock/gmock.h>

#include "test/failure/fresh_solver.hpp"
#include "test/solver/batches.hpp"

namespace mfs::test {
namespace {

/// With all backends that are here.
std::vector<Options> with_backends(int threads) {
  std::vector<Options> all;
  for (const Backend backend : backends()) {
    all.push_back(with_threads(threads));
    all.back().backend = backend;
  }
  return all;
}

template <class Scalar>
class BatchOf : public testing::Test {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(BatchOf, Scalars);

TYPED_TEST(BatchOf, SystemsIsSolvedAndReported) {
  using Scalar = TypeParam;
  for (const std::int64_t nrhs : {1, 3, 20}) {
    for (const Options& options : with_backends(nrhs == 3 ? 1 : 3)) {
      Systems<Scalar> all(random_diagonally_dominant(90, 4, 1), 11, nrhs, 2);
      BasicBatchSolver<Scalar> solver(options);
      solver.analyze(all.matrices[0].view());
      solver.solve(all.batch);
      EXPECT_EQ(solver.failed(), 0);
      ASSERT_EQ(solver.systems().size(), 11u);
      for (std::int64_t k = 0; k < all.batch.count; ++k) {
        const SystemReport& found = solver.systems()[static_cast<std::size_t>(k)];
        EXPECT_EQ(found.status, SystemStatus::solved) << found.error;
        EXPECT_LE(all.error_of(k), kPromisedFor<Scalar>);
        EXPECT_NEAR(found.backward_error, all.error_of(k), 0.1 * kTolerance<Scalar>);
      }
      // What lies between the columns and systems is nobody's.
      for (std::int64_t k = 0; k < all.batch.count; ++k) {
        for (std::int64_t i = 0; i < all.batch.x_stride; ++i) {
          const std::int64_t row = i % all.batch.ldx;
          const bool gap = i >= nrhs * all.batch.ldx || row >= 90;
          ASSERT_EQ(std::isnan(std::abs(all.x[static_cast<std::size_t>(k * all.batch.x_stride + i)])), gap);
        }
      }
    }
  }
}

// As a solver of one thread gives them that has analysed the same values, where fronts are large enough to be
// the faster way.
TEST(Batch, GivesTheBitsOfASolver) {
  Systems<double> all(random_diagonally_dominant(300, 30, 2), 7, 2, 0);
  BatchSolver solver(with_threads(2));
  solver.analyze(all.matrices[3].view());
  solver.solve(all.batch);
  Solver alone(with_threads(1));
  alone.factor(all.matrices[3].view());
  std::vector<double> x(2 * 300);
  for (std::int64_t k = 0; k < 7; ++k) {
    alone.refactor(all.matrices[static_cast<std::size_t>(k)].values.data());
    alone.solve(all.b.data() + k * all.batch.b_stride, x.data(), 2);
    EXPECT_EQ(std::memcmp(x.data(), all.x.data() + k * all.batch.x_stride, x.size() * sizeof(double)), 0);
    EXPECT_EQ(alone.report().rung, solver.systems()[static_cast<std::size_t>(k)].rung);
  }
}

/// Bodies of six unknowns with a joint of five before and behind each, which has no diagonal.
SparseMatrix chain_of_bodies(std::int64_t bodies) {
  Random random(7);
  std::vector<Entry> entries;
  for (std::int64_t body = 0; body < bodies; ++body) {
    for (std::int64_t i = 0; i < 36; ++i)
      entries.push_back(
          {6 * body + i / 6, 6 * body + i % 6, (i % 7 == 0 ? 4.0 : 0.0) + 0.5 * random.entry()});
    for (std::int64_t joint = body; joint <= body + 1 && joint < bodies; ++joint) {
      for (std::int64_t i = 0; i < 30; ++i) {
        const std::int64_t force = 6 * bodies + 5 * joint + i / 6, motion = 6 * body + i % 6;
        const double value = (i / 6 == i % 6 ? 1.0 : 0.0) + 0.3 * random.entry();
        entries.push_back({force, motion, value});
        entries.push_back({motion, force, value});
      }
    }
  }
  return from_entries(11 * bodies, entries);
}

// Such patterns have an order of their own (ordering/order_matrix.hpp, ListCost), on a device perhaps
// another.
TYPED_TEST(BatchOf, LongBodiesAreSolvedWhateverTheThreads) {
  using Scalar = TypeParam;
  for (Options options : with_backends(1)) {
    Systems<Scalar> all(chain_of_bodies(30), 19, 2, 1);
    std::vector<Scalar> first;
    for (const int threads : {1, 3, 8}) {
      options.threads = threads;
      BasicBatchSolver<Scalar> solver(options);
      solver.analyze(all.matrices[0].view());
      solver.solve(all.batch);
      EXPECT_EQ(solver.failed(), 0);
      for (std::int64_t k = 0; k < all.batch.count; ++k) EXPECT_LE(all.error_of(k), kPromisedFor<Scalar>);
      if (first.empty()) first = all.x;
      EXPECT_TRUE(same_bits(first, all.x));
    }
  }
}

// Whole and broken groups of systems that are solved together.
TYPED_TEST(BatchOf, SystemsMayBeAnyNumberOfAnySize) {
  using Scalar = TypeParam;
  for (const std::int64_t n : {1, 2, 31, 32, 33, 65}) {
    for (const std::int64_t count : {0, 1, 7, 8, 9, 33, 1000}) {
      if (count == 1000 && n != 32) continue;
      const SparseMatrix pattern = n < 3 ? tridiagonal(n) : random_diagonally_dominant(n, 3, 1);
      Systems<Scalar> all(pattern, count, 1, 1);
      BasicBatchSolver<Scalar> solver(with_threads(2));
      solver.analyze(in_scalar<Scalar>(pattern).view());
      solver.solve(all.batch);
      EXPECT_EQ(solver.failed(), 0);
      ASSERT_EQ(static_cast<std::int64_t>(solver.systems().size()), count);
      for (std::int64_t k = 0; k < count; ++k) ASSERT_LE(all.error_of(k), kPromisedFor<Scalar>) << k;
      const std::vector<Scalar> first = all.x;
      solver.solve(all.batch);
      EXPECT_TRUE(same_bits(first, all.x));
    }
  }
}

// Each system alone gives the bits that it gives among others.
TEST(Batch, OfOneSystemGivesTheSameBits) {
  Systems<double> all(grid_2d(23, 24), 13, 2, 0);
  BatchSolver solver(with_threads(2));
  solver.analyze(all.matrices[3].view());
  solver.solve(all.batch);
  std::vector<double> x(static_cast<std::size_t>(all.batch.x_stride));
  for (std::int64_t k = 0; k < 13; ++k) {
    Batch<double> one = all.batch;
    one.count = 1;
    one.values += k * one.values_stride;
    one.b += k * one.b_stride;
    one.x = x.data();
    solver.solve(one);
    EXPECT_EQ(std::memcmp(x.data(), all.x.data() + k * all.batch.x_stride, x.size() * sizeof(double)), 0);
  }
}

// A floor under rows, factors of single precision and no refinement are obeyed as by a solver.
TEST(Batch, OptionsOfSolvesAreObeyed) {
  Systems<double> all(grid_2d(9, 8), 9, 1, 0);
  for (int kind = 0; kind < 3; ++kind) {
    Options options = with_threads(1);
    if (kind == 0) options.solve.row_floor = 1;
    if (kind == 1) options.factor.precision = Precision::single;
    if (kind == 2) options.solve.tolerance = 1e-30;
    BatchSolver solver(options);
    solver.analyze(all.matrices[0].view());
    solver.solve(all.batch);
    for (const SystemReport& found : solver.systems()) {
      if (kind < 2) {
        EXPECT_EQ(found.status, SystemStatus::solved);
        EXPECT_EQ(found.rung >= Rung::refinement, kind == 1);
      } else {
        EXPECT_EQ(found.status, SystemStatus::accuracy_not_reached);
      }
    }
  }
}

TEST(Batch, ASystemThatFailsSpoilsNoOther) {
  const SparseMatrix pattern = grid_2d(9, 8);
  std::vector<double> first;
  std::vector<Options> kinds = with_backends(2);
  for (const int threads : {1, 4}) kinds.push_back(with_threads(threads));
  for (const Options& options : kinds) {
    SCOPED_TRACE(backend_name(options.backend));
    Systems<double> all(pattern, 25, 1, 1), good(pattern, 25, 1, 1);
    spoil(all);
    BatchSolver solver(options);
    solver.analyze(good.matrices[0].view());
    solver.solve(good.batch);
    EXPECT_EQ(solver.failed(), 0);
    solver.solve(all.batch);
    int failed = 0;
    for (std::int64_t k = 0; k < 25; ++k) {
      SCOPED_TRACE(k);
      const SystemReport& found = solver.systems()[static_cast<std::size_t>(k)];
      failed += found.status != SystemStatus::solved;
      if (k % 5 == 1) {
        EXPECT_EQ(found.status, SystemStatus::singular);
        EXPECT_EQ(found.row, 4);
        EXPECT_THAT(found.error, testing::HasSubstr("singular"));
      } else if (k % 5 == 2) {
        EXPECT_EQ(found.status, SystemStatus::invalid_input);
        EXPECT_EQ(found.row, 4);
        EXPECT_EQ(found.column, 0 + all.matrices[0].columns[all.matrices[0].offsets[4]]);
      } else if (k == 9) {
        EXPECT_EQ(found.status, SystemStatus::invalid_input);
        EXPECT_EQ(found.row, 3);
      } else {
        EXPECT_EQ(found.status, SystemStatus::solved) << found.error;
        EXPECT_LE(all.error_of(k), kPromised);
        EXPECT_EQ(found.error, "");
      }
      EXPECT_EQ(all.untouched(k), found.status != SystemStatus::solved);
      if (k % 5 == 0 && k > 0) {
        EXPECT_EQ(std::memcmp(all.x.data() + k * all.batch.x_stride, good.x.data() + k * all.batch.x_stride,
                              72 * sizeof(double)),
                  0);
      }
    }
    EXPECT_EQ(solver.failed(), failed);
    if (options.backend != Backend::openmp) continue;
    if (first.empty()) first = all.x;
    EXPECT_TRUE(same_bits(first, all.x)) << options.threads << " threads";
  }
}

// The plan of the analysis does not serve these: each is analysed by itself, and the next is not the worse.
TEST(Batch, SystemsFarFromThatOfTheAnalysisAreSolvedByThemselves) {
  for (const Options& options : with_backends(2)) {
    Systems<double> all(adversarial_matrix("saddle point renumbered", 1), 6, 2, 0);
    BatchSolver solver(options);
    for (const bool values : {true, false}) {
      CsrView<double> view = all.matrices[0].view();
      if (!values) view.values = nullptr;
      solver.analyze(view);
      std::fill(all.x.begin(), all.x.end(), 0.0);
      solver.solve(all.batch);
      EXPECT_EQ(solver.failed(), 0);
      for (std::int64_t k = 0; k < 6; ++k) EXPECT_LE(all.error_of(k), kPromised);
    }
    // One of them has a row of zeros.
    SparseMatrix& singular = all.matrices[2];
    std::fill(singular.values.begin(), singular.values.begin() + singular.offsets[1], 0.0);
    all.put_values(2);
    const std::vector<double> before = all.x;
    solver.solve(all.batch);
    EXPECT_EQ(solver.failed(), 1);
    EXPECT_EQ(solver.systems()[2].status, SystemStatus::singular) << solver.systems()[2].error;
    EXPECT_TRUE(same_bits(before, all.x));
  }
}

TEST(Batch, SolutionsMayLieWhereRightHandSidesWere) {
  for (const Options& options : with_backends(2)) {
    Systems<double> all(grid_2d(11, 12), 5, 20, 0);
    BatchSolver solver(options);
    solver.analyze(all.matrices[0].view());
    solver.solve(all.batch);
    Batch<double> in_place = all.batch;
    std::vector<double> both = all.b;
    in_place.b = in_place.x = both.data();
    solver.solve(in_place);
    EXPECT_EQ(solver.failed(), 0);
    EXPECT_TRUE(same_bits(both, all.x));
  }
}

// Unsorted rows and repeated entries: values are taken in the order of the entries that were analysed.
TEST(Batch, EntriesMayComeInAnyOrder) {
  const SparseMatrix a = from_entries(3, {{0, 2, 1}, {0, 0, 2}, {0, 0, 3}, {1, 1, 4}, {2, 2, 7}, {2, 0, -1}});
  std::vector<double> values = a.values, b{1, 2, 3, 4, 5, 6}, x(6);
  for (const double value : a.values) values.push_back(2 * value);
  for (const Options& options : with_backends(1)) {
    BatchSolver solver(options);
    solver.analyze(a.view());
    solver.solve({2, values.data(), 0, b.data(), x.data()});
    EXPECT_EQ(solver.failed(), 0);
    for (int k = 0; k < 2; ++k) {
      SparseMatrix one = a;
      std::copy(values.begin() + k * 6, values.begin() + (k + 1) * 6, one.values.begin());
      EXPECT_LE(backward_error(one, b.data() + 3 * k, x.data() + 3 * k), kPromised);
    }
  }
}

// {b_k, x_k} as the fields of records.
TYPED_TEST(BatchOf, ColumnsMayLieBetweenEachOther) {
  Systems<TypeParam> all(grid_2d(5, 5), 6, 2, 0);
  for (const Options& options : with_backends(2)) {
    BasicBatchSolver<TypeParam> solver(options);
    solver.analyze(all.matrices[0].view());
    solver.solve(all.batch);
    const std::vector<TypeParam> apart = all.x;
    const std::int64_t vectors = 2 * all.matrices[0].n;
    std::vector<TypeParam> records(static_cast<std::size_t>(2 * vectors * all.batch.count));
    Batch<TypeParam> batch = all.batch;
    batch.b = records.data();
    batch.x = records.data() + vectors;
    batch.b_stride = batch.x_stride = 2 * vectors;
    for (std::int64_t k = 0; k < batch.count; ++k)
      std::copy_n(all.b.begin() + k * vectors, vectors, records.begin() + 2 * k * vectors);
    solver.solve(batch);
    EXPECT_EQ(solver.failed(), 0);
    for (std::int64_t k = 0; k < batch.count; ++k) {
      EXPECT_TRUE(std::equal(apart.begin() + k * vectors, apart.begin() + (k + 1) * vectors,
                             records.begin() + (2 * k + 1) * vectors));
      EXPECT_TRUE(std::equal(all.b.begin() + k * vectors, all.b.begin() + (k + 1) * vectors,
                             records.begin() + 2 * k * vectors));
    }
    batch.x -= 1;
    expect_invalid([&] { solver.solve(batch); }, "x");
    batch.x += 2;
    expect_invalid([&] { solver.solve(batch); }, "x");
  }
}

// Whether or not the values were there to be analysed.
TEST(Batch, BitsDoNotDependOnTheThreads) {
  for (const bool with_values : {false, true}) {
    std::vector<double> first;
    for (const int threads : {1, 2, 8}) {
      Systems<double> all(random_diagonally_dominant(40, 4, 3), 24, 1, 0);
      auto pattern = all.matrices[0].view();
      if (!with_values) pattern.values = nullptr;
      BatchSolver solver(with_threads(threads));
      solver.analyze(pattern);
      solver.solve(all.batch);
      EXPECT_EQ(solver.failed(), 0);
      if (threads == 1) first = all.x;
      EXPECT_EQ(all.x, first) << threads << " threads";
    }
  }
}

TEST(Batch, RefusesWhatCannotBe) {
  Systems<double> all(grid_2d(4, 4), 3, 1, 0);
  BatchSolver solver(with_threads(1));
  failure_of<StateError>([&] { solver.solve(all.batch); });
  failure_of<StateError>([&] { solver.solve_device(all.batch); });
  solver.analyze(all.matrices[0].view());
  const auto with = [&](const auto& change) {
    return [&, change] {
      Batch<double> batch = all.batch;
      change(batch);
      solver.solve(batch);
    };
  };
  expect_invalid(with([](auto& batch) { batch.count = -1; }), "count");
  expect_invalid(with([](auto& batch) { batch.nrhs = 0; }), "nrhs");
  expect_invalid(with([](auto& batch) { batch.values = nullptr; }), "values");
  expect_invalid(with([](auto& batch) { batch.b = nullptr; }), "b");
  expect_invalid(with([](auto& batch) { batch.x = nullptr; }), "x");
  expect_invalid(with([](auto& batch) { batch.values_stride -= 1; }), "values_stride");
  expect_invalid(with([](auto& batch) { batch.ldb = 15; }), "ldb");
  expect_invalid(with([](auto& batch) { batch.ldx = 15; }), "ldx");
  expect_invalid(with([](auto& batch) { batch.b_stride = 15; }), "b_stride");
  expect_invalid(with([](auto& batch) { batch.x_stride = 15; }), "x_stride");
  expect_invalid(with([&](auto& batch) { batch.x = all.b.data() + 16; }), "x");
  // Products of these would be beyond 64 bits, and what they count beyond all memory.
  constexpr std::int64_t kFar = std::int64_t{1} << 61;
  expect_invalid(with([](auto& batch) { batch.nrhs = kFar; }), "ldb");
  expect_invalid(with([](auto& batch) { batch.ldx = kFar; }), "ldx");
  expect_invalid(with([](auto& batch) { batch.b_stride = kFar; }), "b_stride");
  expect_invalid(with([](auto& batch) { batch.count = kFar; }), "values_stride");
  with([](auto& batch) { batch.count = 0; })();
  EXPECT_TRUE(solver.systems().empty());
  solver.solve(all.batch);
  EXPECT_EQ(solver.failed(), 0);

  failure_of<StateError>([&] { solver.solve_device(all.batch); });  // there is none
  Options dumping;
  dumping.dump_prefix = "x";
  expect_invalid([&] { const BatchSolver other(dumping); }, "dump_prefix");
  Options limited;
  limited.memory_limit = 1000000;
  expect_invalid([&] { const BatchSolver other(limited); }, "memory_limit");
  limited = {};
  limited.out_of_core_dir = "/tmp";
  expect_invalid([&] { const BatchSolver other(limited); }, "out_of_core_dir");
  BatchSolver moved = std::move(solver);
  failure_of<StateError>([&] { solver.solve(all.batch); });
  moved.solve(all.batch);
  EXPECT_EQ(moved.failed(), 0);
}

TEST(Batch, MoreSystemsThanAnyMemoryHolds) {
  double value = 2, b = 6;
  BatchSolver solver(with_threads(1));
  solver.analyze(from_entries(1, {{0, 0, 1}}).view());
  failure_of<OutOfMemory>([&] { solver.solve({std::int64_t{1} << 58, &value, 0, &b, &b}); });
  solver.solve({1, &value, 0, &b, &b});
  EXPECT_EQ(b, 3);
}

TEST(Batch, OfASingularPatternIsRefusedAtOnce) {
  BatchSolver solver(with_threads(1));
  failure_of<SingularMatrix>([&] { solver.analyze(from_entries(2, {{0, 0, 1}, {1, 0, 1}}).view()); });
  Systems<double> all(grid_2d(4, 4), 3, 1, 0);
  failure_of<StateError>([&] { solver.solve(all.batch); });
  solver.analyze(all.matrices[0].view());
  solver.solve(all.batch);
  EXPECT_EQ(solver.failed(), 0);
}

TEST(Batch, TellsItsProgress) {
  std::vector<double> told;
  Options options = with_threads(2);
  options.progress = [&](const Progress& progress) { told.push_back(progress.fraction); };
  BatchSolver solver(options);
  Systems<double> all(grid_2d(9, 9), 50, 1, 0);
  solver.analyze(all.matrices[0].view());
  told.clear();
  solver.solve(all.batch);
  EXPECT_EQ(solver.failed(), 0);
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.back(), 1.0);
}

TEST(Batch, NamesOfStatusAreThoseOfTheEnumerators) {
  EXPECT_STREQ(status_name(SystemStatus::solved), "solved");
  EXPECT_STREQ(status_name(SystemStatus::singular), "singular");
  EXPECT_STREQ(status_name(SystemStatus::accuracy_not_reached), "accuracy_not_reached");
  EXPECT_STREQ(status_name(SystemStatus::invalid_input), "invalid_input");
  EXPECT_STREQ(status_name(SystemStatus::out_of_memory), "out_of_memory");
  EXPECT_STREQ(status_name(SystemStatus::failed), "failed");
  EXPECT_STREQ(status_name(static_cast<SystemStatus>(99)), "unknown");
}

}  // namespace
}  // namespace mfs::test
