// The portable executor against the plain reference, in every execution space that this Kokkos has: stage by
// stage, on the input that the reference has at that point, and as a whole. Spaces of a device skip where
// there is none. On the host both forms of its dense operations are run: the library's, and its own, which
// any other space has.
#include <string>

#include "test/stages/followed_reference.hpp"
#include "test/stages/in_engine.hpp"
#include "test/stages/portable_bench.hpp"
#include "test/stages/stage_cases.hpp"
#include "test/stages/weak_pivots.hpp"
#ifdef MFS_CUDA
#include "kernels/cuda/cuda_factors.hpp"
#endif

namespace mfs::test {
namespace {

using portable::DenseOf;
using portable::LibraryDense;
using portable::OwnDense;
using portable::Sizes;

template <class Exec_, class Scalar_, template <class> class Dense_>
struct Tested {
  using Exec = Exec_;
  using Scalar = Scalar_;
  static constexpr bool kThorough = std::is_same_v<Scalar, double>;
  using Dense = Dense_<DeviceScalar<Scalar>>;
  using Bench = PortableBench<Exec, Scalar, Dense>;
};
using Default = Kokkos::DefaultExecutionSpace;
template <class S>
using DefaultDense = DenseOf<Default, S>;
#ifdef __SANITIZE_ADDRESS__  // indices are the same for all numbers, and what the vendor does is not looked
                             // into
using AllTested = testing::Types<Tested<Kokkos::Serial, double, OwnDense>,
                                 Tested<Kokkos::OpenMP, std::complex<float>, OwnDense>>;
#else
using AllTested =
    testing::Types<Tested<Kokkos::Serial, double, LibraryDense>, Tested<Kokkos::Serial, double, OwnDense>,
                   Tested<Kokkos::OpenMP, std::complex<float>, OwnDense>,
                   Tested<Default, double, DefaultDense>, Tested<Default, std::complex<double>, DefaultDense>,
                   Tested<Default, float, DefaultDense>, Tested<Default, std::complex<float>, DefaultDense>>;
#endif

/// With and without contribution blocks that are assembled in turns.
template <class Scalar>
const std::vector<Case<Scalar>>& trees() {
  static const auto* const cases = [] {
    auto* made = new std::vector<Case<Scalar>>(four_trees<Scalar>());
    made->emplace_back("400 pivots, border 150", artificial_problem(leaf_and_root(400, 150), {5}));
    made->emplace_back("in turns", artificial_problem(fork(), {12, 0.1, 64, kAssemblyTurns}));
    return made;
  }();
  return *cases;
}

/// As production has them; and so small that every front has several tiles, panels and slabs.
template <class T>
std::vector<Sizes> all_sizes(int threads) {
  using S = DeviceScalar<typename T::Scalar>;
  const Sizes usual = portable::sizes_for<typename T::Exec, S, typename T::Dense>(threads);
  Sizes narrow = usual;
  narrow.limits.tile = 16;
  narrow.limits.small_rows = 20;
  narrow.limits.small_part = 0;
  if (T::Dense::kSearchesAll) narrow.limits.ahead_tiles = 0;
  narrow.limits.small_step = 8;
  narrow.limits.multiprocessors = 1;  // fronts of different sizes have launches of their own
  narrow.limits.strip = 24;
  if (!T::Dense::kSearchesAll) narrow.limits.panelled = 48;
  narrow.limits.panelled_rows = 0;
  narrow.limits.panel = 32;
  narrow.limits.slab = 64;
  if (Space<typename T::Exec>::Queue::kLibrary) narrow.limits.vendor_entries = 64 * 64;
  narrow.limits.vendor_depth = 16;
  narrow.whole = 10;
  narrow.solve_tile = T::Dense::kSearchesAll ? 24 : 32;  // own tiles are some inverted blocks
  narrow.most_chunk = narrow.most_gathered = 17;
  if (kOnHost<typename T::Exec> && !T::Dense::kSearchesAll) narrow.host_team = threads;
  return {usual, narrow};
}

template <class T>
class PortableStagesTest : public testing::Test {
 protected:
  using Exec = typename T::Exec;
  using Scalar = typename T::Scalar;
  using Bench = typename T::Bench;

  void SetUp() override {
#ifdef MFS_CUDA
    if (!kOnHost<Exec> && !cuda::device_found()) GTEST_SKIP() << "no device";
#endif
  }
  /// Spaces of the host ask for plans without turns.
  static bool refuses(const SymbolicPlan& plan, const Sizes& sizes) {
    if (!plan.has_turns() || sizes.limits.small_rows <= kAssemblyTurns.rows) return false;
    EXPECT_TRUE(T::Dense::kSearchesAll);
    return true;
  }
  /// check(sizes) in the space, with one thread, and with two for one kind of numbers and each way to make
  /// products: what threads share does not depend on the numbers, and waiting for each other takes long where
  /// the machine has other work.
  template <class Check>
  void in_space(const Check& check) {
    const bool has_threads = kOnHost<Exec> && !std::is_same_v<Exec, Kokkos::Serial> &&
                             (std::is_same_v<Scalar, double> || !T::Dense::kSearchesAll);
    for (const int threads : has_threads ? std::vector<int>{1, 2} : std::vector<int>{1}) {
      in_engine(threads, [&] {
        Space<Exec>::start();
        const blas::SequentialScope sequential(threads);
        for (const Sizes& sizes : all_sizes<T>(threads)) {
          SCOPED_TRACE(std::to_string(threads) + " threads, tile " + std::to_string(sizes.limits.tile));
          if (!this->HasFailure()) check(sizes);
        }
      });
    }
  }

  void check_stages(const std::vector<Case<Scalar>>& cases, bool substitutes = false) {
    in_space([&](const Sizes& sizes) {
      for (const Case<Scalar>& tested : cases) {
        SCOPED_TRACE(tested.name);
        check_stages(tested, sizes, substitutes);
        if (this->HasFailure()) return;  // one broken case says enough
      }
    });
  }
  void check_stages(const Case<Scalar>& tested, const Sizes& sizes, bool substitutes) {
    const SymbolicPlan& plan = *tested.problem.plan;
    if (refuses(plan, sizes)) return;
    Bench bench(tested.problem, sizes);
    bench.make_all_strict();
    substitutes ? bench.substitute() : bench.begin();
    for (Vertex step = 0; step < plan.num_depths; ++step) check_depth(bench, plan, tested.reference, step);
    const portable::Status status = bench.status();
    EXPECT_EQ(status.pivots.perturbed, 0u);
    EXPECT_EQ(status.pivots.nonfinite, 0u);
    EXPECT_EQ(status.found_strict, 0);
  }
  void check_depth(Bench& bench, const SymbolicPlan& plan, const ReferenceStages<Scalar>& expected,
                   Vertex step) {
    const auto each_front = [&](auto&& body) {
      for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
        SCOPED_TRACE("front " + std::to_string(f));
        body(f);
      }
    };
    each_front([&](Vertex f) {
      for (Vertex c = plan.child_begin[f]; c < plan.child_begin[f + 1]; ++c)
        bench.put_front(plan.children[c], expected.updated[plan.children[c]]);
    });
    bench.factor_depth(step, {true, false, false});
    std::vector<FrontBlocks<Scalar>> found;
    each_front([&](Vertex f) { found.push_back(bench.front(f)); });
    each_front([&](Vertex f) {  // sums of few terms in a fixed order: the same bits
      const FrontBlocks<Scalar>& blocks = found[f - plan.depth_begin[step]];
      EXPECT_EQ(difference(blocks.lower, expected.assembled[f].lower), 0) << "assemble, P and L";
      EXPECT_EQ(difference(blocks.upper, expected.assembled[f].upper), 0) << "assemble, U";
      EXPECT_EQ(difference(blocks.contribution, expected.assembled[f].contribution), 0) << "assemble, C";
      bench.put_front(f, expected.assembled[f]);
    });
    bench.factor_depth(step, {false, true, false});
    each_front([&](Vertex f) {
      const FrontBlocks<Scalar> blocks = bench.as_kept(bench.front(f), f);
      EXPECT_EQ(bench.row_at(f), expected.fronts[f].row_at);
      EXPECT_EQ(bench.shift(f), expected.fronts[f].shift);
      EXPECT_LT(difference(blocks.lower, expected.factored[f].lower), kTolerance<Scalar>) << "P and L";
      EXPECT_LT(difference(blocks.upper, expected.factored[f].upper), kTolerance<Scalar>) << "U";
      EXPECT_EQ(difference(blocks.contribution, expected.assembled[f].contribution), 0) << "C must stay";
      bench.put_front(f, bench.as_kept(expected.factored[f], f));
    });
    bench.factor_depth(step, {false, false, true});
    each_front([&](Vertex f) {
      const FrontBlocks<Scalar> blocks = bench.front(f);
      EXPECT_EQ(difference(blocks.lower, bench.as_kept(expected.factored[f], f).lower), 0)
          << "P and L must stay";
      EXPECT_EQ(difference(blocks.upper, expected.factored[f].upper), 0) << "U must stay";
      EXPECT_LT(difference(blocks.contribution, expected.updated[f].contribution), kTolerance<Scalar>)
          << "update, C";
    });
  }

  void check_solves(const std::vector<Case<Scalar>>& cases, bool substitutes = false) {
    in_space([&](const Sizes& sizes) {
      for (const Case<Scalar>& tested : cases) {
        SCOPED_TRACE(tested.name);
        if (refuses(*tested.problem.plan, sizes)) continue;
        Bench bench(tested.problem, sizes);
        if (substitutes) bench.substitute();
        for (Vertex f = 0; f < tested.problem.plan->num_fronts; ++f)
          bench.put_factored(f, tested.reference.fronts[f]);
        for (const Vertex columns : {1, 2, 5, 16}) check_solve(bench, tested, columns);
        if (this->HasFailure()) return;
      }
    });
  }
  void check_solve(Bench& bench, const Case<Scalar>& tested, Vertex columns) {
    const Vertex n = tested.problem.plan->n;
    const std::vector<Scalar> v = Random(77).vector<Scalar>(static_cast<std::int64_t>(n) * columns);
    for (const bool transposed : {false, true}) {
      SCOPED_TRACE(std::to_string(columns) + " columns" + (transposed ? ", transposed" : ""));
      std::vector<Scalar> y, x;
      for (Vertex j = 0; j < columns; ++j) {
        std::vector<Scalar> column(v.begin() + static_cast<Offset>(j) * n,
                                   v.begin() + static_cast<Offset>(j + 1) * n);
        solve_forward(tested.reference.fronts, transposed, column);
        y.insert(y.end(), column.begin(), column.end());
        solve_backward(tested.reference.fronts, transposed, column);
        x.insert(x.end(), column.begin(), column.end());
      }
      const auto found = bench.solve(columns, v, transposed);
      EXPECT_LT(difference(found.y, y), kTolerance<Scalar>) << "forward";
      EXPECT_LT(difference(found.x, x), kTolerance<Scalar>) << "backward";
    }
  }

  /// Where pivot k of front f may have been searched.
  static SearchedRows searched(const SymbolicPlan& plan, const Sizes& sizes, const std::vector<int>& strict,
                               Vertex f, Vertex k) {
    const Vertex p = plan.pivots(f), tile = sizes.limits.tile;
    if (T::Dense::kSearchesAll || strict[f] || plan.rows(f) <= sizes.limits.small_rows) return {p};
    return {std::min(p, k / tile * tile + tile)};
  }
  /// Factors as production does, and compares with the reference on the same pivots.
  FactorStatus check_followed(const StageProblem<Scalar>& problem, const Sizes& sizes, double tolerance,
                              int* passes = nullptr) {
    Bench bench(problem, sizes);
    const FactoredFronts<Scalar> result = bench.factor(tolerance);
    const std::vector<int> strict = bench.strict();
    follow<Scalar>(problem, result, rule_of(problem, tolerance),
                   [&](Vertex f, Vertex k) { return searched(*problem.plan, sizes, strict, f, k); });
    expect_exact_factors(problem, result, Measure::row);
    if (passes) *passes = bench.passes();
    return result.status;
  }
};
TYPED_TEST_SUITE(PortableStagesTest, AllTested);

TYPED_TEST(PortableStagesTest, AssembleFactorUpdateOfAllFrontSizes) {
  this->check_stages(front_sizes<typename TypeParam::Scalar, TypeParam::kThorough>());
}
TYPED_TEST(PortableStagesTest, AssembleFactorUpdateOfTrees) {
  this->check_stages(trees<typename TypeParam::Scalar>());
}
TYPED_TEST(PortableStagesTest, SolvesWithAllFrontSizes) {
  this->check_solves(front_sizes<typename TypeParam::Scalar, TypeParam::kThorough>());
}
TYPED_TEST(PortableStagesTest, SolvesWithTrees) {
  this->check_solves(trees<typename TypeParam::Scalar>());
}

// As where tiny pivots are divided by.
TYPED_TEST(PortableStagesTest, SubstitutesWithU) {
  if (TypeParam::Dense::kSearchesAll) GTEST_SKIP() << "a library substitutes always";
  this->check_stages(trees<typename TypeParam::Scalar>(), true);
  this->check_solves(trees<typename TypeParam::Scalar>(), true);
}

// Where tiny pivots are divided by, the first pivot of a front stays, which else is exchanged.
TYPED_TEST(PortableStagesTest, PrefersTheDiagonalWhereTinyPivotsAreData) {
  using Scalar = typename TypeParam::Scalar;
  const std::vector<Case<Scalar>> cases = weak_diagonals<Scalar>();
  this->in_space([&](const Sizes& sizes) {
    for (const Case<Scalar>& tested : cases) {
      if (this->refuses(*tested.problem.plan, sizes)) continue;
      SCOPED_TRACE(tested.name);
      EXPECT_NE(tested.reference.fronts[0].row_at[0], 0);
      for (const bool strict : {false, true}) {
        typename TypeParam::Bench bench(tested.problem, sizes);
        if (strict) bench.make_all_strict();
        bench.substitute();
        bench.factor_depth(0, {true, true, true});
        EXPECT_EQ(bench.row_at(0)[0], 0) << (strict ? "strict" : "in tiles");
      }
    }
  });
}

// Pivots where they happen to be, in the rows that are searched.
TYPED_TEST(PortableStagesTest, FactorsWithPivotsOfTiles) {
  using Scalar = typename TypeParam::Scalar;
  this->in_space([&](const Sizes& sizes) {
    for (const double kept : {0.0, 0.97}) {
      for (const auto& shapes : {mixed_tree(), leaf_and_root(150, 90)}) {
        SCOPED_TRACE("kept " + std::to_string(kept));
        const auto problem = in_numbers_of<Scalar>(artificial_problem(shapes, {6, 0.6, 64, {}, kept}));
        EXPECT_EQ(this->check_followed(problem, sizes, default_tolerance<Scalar>()).perturbed, 0u);
      }
    }
  });
}

TYPED_TEST(PortableStagesTest, ReplacesZeroPivots) {
  using Scalar = typename TypeParam::Scalar;
  this->in_space([&](const Sizes& sizes) {
    for (const Vertex p : {1, 2, 33, 150}) {
      for (const Vertex b : {0, 1, 70}) {
        SCOPED_TRACE(std::to_string(p) + " pivots, border " + std::to_string(b));
        const auto problem = in_numbers_of<Scalar>(zero_pivot_block(p, b, 64, 100.0));
        if (b > 0) {
          EXPECT_GE(this->check_followed(problem, sizes, default_tolerance<Scalar>()).perturbed,
                    static_cast<unsigned long long>(p));
        }
      }
    }
  });
}

// Nothing is there (the pivot would be replaced), or so little that the multipliers would grow.
TYPED_TEST(PortableStagesTest, SearchesFurtherWhereATileHasNoPivots) {
  using Scalar = typename TypeParam::Scalar;
  this->in_space([&](const Sizes& sizes) {
    for (const double own : {0.0, 1e-3}) {
      SCOPED_TRACE("entries of size " + std::to_string(own));
      StageProblem<Scalar> problem = in_numbers_of<Scalar>(pivots_below_the_tile(300, 150, own));
      int passes = 0;
      EXPECT_EQ(this->check_followed(problem, sizes, default_tolerance<Scalar>(), &passes).perturbed, 0u);
      EXPECT_EQ(passes, TypeParam::Dense::kSearchesAll ? 1 : 2);
    }
  });
}

TYPED_TEST(PortableStagesTest, CountsPivotsThatAreNoNumbers) {
  using Scalar = typename TypeParam::Scalar;
  this->in_space([&](const Sizes& sizes) {
    for (const double bad : {std::numeric_limits<double>::infinity(), std::nan("")}) {
      for (const Vertex p : {3, 300}) {
        StageProblem<Scalar> problem = in_numbers_of<Scalar>(artificial_problem(leaf_and_root(p, 40), {9}));
        problem.values[problem.values.size() / 2] = Scalar(static_cast<RealOf<Scalar>>(bad));
        typename TestFixture::Bench bench(problem, sizes);
        EXPECT_GT(bench.factor(default_tolerance<Scalar>()).status.nonfinite, 0u) << bad << ", " << p;
      }
    }
  });
}

TYPED_TEST(PortableStagesTest, GivesTheSameBitsFromRunToRun) {
  using Scalar = typename TypeParam::Scalar;
  this->in_space([&](const Sizes& sizes) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Case<Scalar>& tested = trees<Scalar>()[k];
      SCOPED_TRACE(tested.name);
      if (this->refuses(*tested.problem.plan, sizes)) continue;
      const std::vector<Scalar> v = Random(5).vector<Scalar>(Offset(5) * tested.problem.plan->n);
      typename TestFixture::Bench bench(tested.problem, sizes), other(tested.problem, sizes);
      const FactoredFronts<Scalar> first = bench.factor(1e-4);
      const auto solution = bench.solve(5, v, false);
      const auto expect_the_same = [&](typename TestFixture::Bench& again) {
        const FactoredFronts<Scalar> second = again.factor(1e-4);
        EXPECT_EQ(second.row_at, first.row_at);
        for (std::size_t f = 0; f < first.fronts.size(); ++f) {
          EXPECT_TRUE(second.fronts[f].lower == first.fronts[f].lower) << "P and L of front " << f;
          EXPECT_TRUE(second.fronts[f].upper == first.fronts[f].upper) << "U of front " << f;
        }
        EXPECT_TRUE(again.solve(5, v, false).x == solution.x);
      };
      expect_the_same(bench);
      expect_the_same(other);
    }
  });
}

}  // namespace
}  // namespace mfs::test
