// Numbers, phases and errors of Amesos2::MFS. Every test runs on any number of ranks; CTest also runs them
// all on two (test amesos2_two_ranks).
#include <Amesos2_MFS.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <exception>
#include <limits>
#include <string>

#include <mfs/mfs.hpp>

#include "test/amesos2/systems.hpp"

namespace {

using namespace mfs::test;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using Solver = Amesos2::Solver<Matrix, Vector>;

constexpr double kSmall = 1e-11;

RCP<Solver> make(const RCP<const Matrix>& a) {
  return Amesos2::create<Matrix, Vector>("MFS", a);
}

/// Solves for the image of the samples and returns the error.
double solve_error(Solver& solver, const Matrix& a, std::size_t columns = 1,
                   Teuchos::ETransp mode = Teuchos::NO_TRANS) {
  const auto b = image(a, columns, mode);
  Vector x(mode == Teuchos::NO_TRANS ? a.getDomainMap() : a.getRangeMap(), columns);
  solver.solve(&x, b.get());
  return distance_from_samples(x);
}

/// An error of class E, kept as it was thrown.
template <class E>
class Caught {
 public:
  template <class Work>
  explicit Caught(const Work& work) {
    try {
      work();
    } catch (const E& e) {
      hold_ = std::current_exception();
      error_ = &e;
    }
    if (error_ == nullptr) throw std::logic_error("nothing was thrown");
  }
  const E* operator->() const { return error_; }

 private:
  std::exception_ptr hold_;
  const E* error_ = nullptr;
};

void scale(Matrix& a, double factor) {
  a.resumeFill();
  a.scale(factor);
  a.fillComplete(a.getDomainMap(), a.getRangeMap());
}

// ---- numbers ----

TEST(Amesos2Solve, OneRightHandSide) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  EXPECT_LT(solve_error(*make(a), *a), kSmall);
}

TEST(Amesos2Solve, ManyRightHandSides) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  EXPECT_LT(solve_error(*make(a), *a, 17), kSmall);
}

TEST(Amesos2Solve, NoRightHandSide) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  Vector x(a->getDomainMap(), 0), b(a->getRangeMap(), 0);
  EXPECT_NO_THROW(make(a)->solve(&x, &b));
}

TEST(Amesos2Solve, OneUnknown) {
  const auto a = assemble({{{0, 0}, -3.0}}, even_map(1));
  EXPECT_LT(solve_error(*make(a), *a), kSmall);
}

TEST(Amesos2Solve, ColumnsThatDoNotLieAtOneDistance) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto b = image(*a, 4);
  Vector x(a->getDomainMap(), 4);
  const Teuchos::Array<std::size_t> columns = Teuchos::tuple<std::size_t>(0, 1, 3);
  const auto some_b = b->subView(columns());
  const auto some_x = x.subViewNonConst(columns());
  ASSERT_FALSE(some_x->isConstantStride());
  make(a)->solve(some_x.get(), some_b.get());
  const auto expected = samples(a->getDomainMap(), 4);
  for (std::size_t j = 0; j < 4; ++j) {
    const auto got = x.getData(j), want = expected->getData(j);
    for (int i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], j == 2 ? 0.0 : want[i], kSmall) << i << " " << j;
  }
}

TEST(Amesos2Solve, SolutionOverRightHandSide) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto b = image(*a, 2);
  make(a)->solve(b.get(), b.get());
  EXPECT_LT(distance_from_samples(*b), kSmall);
}

TEST(Amesos2Solve, Transpose) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  const auto list = Teuchos::parameterList("Amesos2");
  list->set("Transpose", true);
  solver->setParameters(list);
  EXPECT_LT(solve_error(*solver, *a, 3, Teuchos::TRANS), kSmall);
  list->set("Transpose", false);
  solver->setParameters(list);
  EXPECT_LT(solve_error(*solver, *a, 3), kSmall);
  EXPECT_EQ(solver->getStatus().getNumNumericFact(), 1);
}

TEST(Amesos2Solve, TransposeInTheSublist) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  for (const char* trans : {"TRANS", "CONJ", "NOTRANS"}) {
    solver->setParameters(amesos2_parameters([&](auto& list) { list.set("Trans", trans); }));
    const auto mode = std::string(trans) == "NOTRANS" ? Teuchos::NO_TRANS : Teuchos::TRANS;
    EXPECT_LT(solve_error(*solver, *a, 1, mode), kSmall) << trans;
  }
  solver->setParameters(amesos2_parameters([&](auto& list) { list.set("Transpose", true); }));
  EXPECT_LT(solve_error(*solver, *a, 1, Teuchos::TRANS), kSmall);
  EXPECT_EQ(solver->getStatus().getNumNumericFact(), 1);
}

// ---- global ids ----

TEST(Amesos2Ids, Gapped) {
  const auto id = [](Ordinal k) { return 5 + 3 * ((7 * k) % 30); };
  Ids ids;
  for (Ordinal k = 0; k < 30; ++k) ids.push_back(id(k));
  const auto a = assemble(renamed(grid_entries(6, 5), id, id), dealt_map(ids));
  for (const bool contiguous : {true, false}) {
    const auto solver = make(a);
    solver->setParameters(amesos2_parameters([&](auto& list) { list.set("IsContiguous", contiguous); }));
    EXPECT_LT(solve_error(*solver, *a, 2), kSmall) << contiguous;
    scale(*a, 2.0);
    solver->numericFactorization();
    EXPECT_LT(solve_error(*solver, *a, 2), kSmall) << contiguous;
  }
}

TEST(Amesos2Ids, FromOne) {
  const auto id = [](Ordinal k) { return k + 1; };
  const auto a = assemble(renamed(grid_entries(6, 5), id, id), even_map(30, 1));
  EXPECT_LT(solve_error(*make(a), *a, 2), kSmall);
}

TEST(Amesos2Ids, UnknownsWithIdsOfTheirOwn) {
  const auto column_id = [](Ordinal k) { return 1000 + 2 * k; };
  Ids rows, columns;
  for (Ordinal k = 0; k < 30; ++k) {
    rows.push_back(k);
    columns.push_back(column_id(k));
  }
  const auto a = assemble(renamed(
                              grid_entries(6, 5), [](Ordinal k) { return k; }, column_id),
                          dealt_map(rows), dealt_map(columns));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a, 2), kSmall);
  const auto list = Teuchos::parameterList("Amesos2");
  list->set("Transpose", true);
  solver->setParameters(list);
  EXPECT_LT(solve_error(*solver, *a, 2, Teuchos::TRANS), kSmall);
}

/// The unknowns are spread in reverse: the diagonal is still the diagonal, and needs no matching.
TEST(Amesos2Ids, UnknownsInAnotherOrderThanRows) {
  Ids reversed;
  for (Ordinal k = 30; k-- > 0;) reversed.push_back(k);
  const auto a = assemble(grid_entries(6, 5), even_map(30), dealt_map(reversed));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a, 2), kSmall);
  EXPECT_FALSE((dynamic_cast<const Amesos2::MFS<Matrix, Vector>&>(*solver).report().matched));
}

TEST(Amesos2Ids, LocalColumnsInAnotherOrder) {
  const auto rows = even_map(30);
  const auto plain = assemble(grid_entries(6, 5), rows);
  Teuchos::Array<Ordinal> columns;
  for (std::size_t k = plain->getColMap()->getMyGlobalIndices().extent(0); k-- > 0;)
    columns.push_back(plain->getColMap()->getGlobalElement(static_cast<int>(k)));
  const auto column_map =
      rcp(new Map(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(), columns(), 0, world()));
  const auto a = rcp(new Matrix(rows, column_map, 16));
  for (const auto& [place, value] : grid_entries(6, 5))
    if (rows->isNodeGlobalElement(place.first))
      a->insertGlobalValues(place.first, Teuchos::tuple(place.second), Teuchos::tuple(value));
  a->fillComplete(rows, rows);
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  scale(*a, 3.0);
  solver->numericFactorization();
  EXPECT_LT(solve_error(*solver, *a), kSmall);

  // The same pattern, written in another order: it may be taken or refused, but never be mistaken.
  solver->setA(plain, Amesos2::SYMBFACT);
  try {
    solver->numericFactorization();
    EXPECT_LT(solve_error(*solver, *plain), kSmall);
  } catch (const mfs::PatternChanged&) {
  }
  solver->setA(a, Amesos2::SYMBFACT);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
}

TEST(Amesos2Ids, VectorsSpreadInAnotherWay) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  Ids reversed;
  for (Ordinal k = 30; k-- > 0;) reversed.push_back(k);
  const auto other = dealt_map(reversed);
  const auto even_b = image(*a, 2);
  Vector b(other, 2), x(other, 2);
  b.doExport(*even_b, Tpetra::Export<>(even_b->getMap(), other), Tpetra::INSERT);
  const auto solver = make(a);
  solver->solve(&x, &b);
  EXPECT_LT(distance_from_samples(x), kSmall);
  EXPECT_LT(solve_error(*solver, *a), kSmall) << "the first distribution again";
}

TEST(Amesos2Ids, VectorOfForeignIds) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  Vector x(a->getDomainMap(), 1), b(even_map(30, 7), 1);
  const auto solver = make(a);
  const Caught<mfs::InvalidInput> e([&] { solver->solve(&x, &b); });
  EXPECT_EQ(e->row(), 30) << e->what();
  EXPECT_LT(solve_error(*solver, *a), kSmall);
}

// ---- phases ----

TEST(Amesos2Phases, EachIsCounted) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  solver->preOrdering().symbolicFactorization().numericFactorization();
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  const auto& status = solver->getStatus();
  EXPECT_EQ(status.getNumPreOrder(), 1);
  EXPECT_EQ(status.getNumSymbolicFact(), 1);
  EXPECT_EQ(status.getNumNumericFact(), 1);
  EXPECT_EQ(status.getNumSolve(), 1);
  EXPECT_TRUE(world()->getRank() > 0 || status.getNnzLU() >= a->getGlobalNumEntries());
}

TEST(Amesos2Phases, SolveRunsThoseThatAreMissing) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  EXPECT_EQ(solver->getStatus().getNumNumericFact(), 1);
  EXPECT_EQ(solver->getStatus().getNumSolve(), 2);
}

TEST(Amesos2Phases, NewValuesKeepTheAnalysis) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  for (int step = 0; step < 3; ++step) {
    scale(*a, 1.5);
    solver->numericFactorization();
    EXPECT_LT(solve_error(*solver, *a), kSmall) << step;
  }
  EXPECT_EQ(solver->getStatus().getNumSymbolicFact(), 1);
  EXPECT_EQ(solver->getStatus().getNumNumericFact(), 3);
}

TEST(Amesos2Phases, AnotherMatrixOfThePatternKeepsTheAnalysis) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  solver->numericFactorization();
  const auto next = assemble(grid_entries(6, 5), even_map(30));
  scale(*next, -2.0);
  solver->setA(next, Amesos2::SYMBFACT);
  EXPECT_LT(solve_error(*solver, *next), kSmall);
  EXPECT_EQ(solver->getStatus().getNumSymbolicFact(), 1);
}

TEST(Amesos2Phases, AnotherSizeStartsAgain) {
  const auto a = assemble(grid_entries(6, 5), even_map(30)),
             bigger = assemble(grid_entries(7, 6), even_map(42));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  solver->setA(bigger);
  EXPECT_LT(solve_error(*solver, *bigger), kSmall);
}

TEST(Amesos2Phases, ParametersOfTheAnalysisStartAgain) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  solver->setParameters(
      amesos2_parameters([](auto& list) { list.set("MaxBlockSize", 1024); }));  // the default
  EXPECT_EQ(solver->getStatus().getNumNumericFact(), 1);
  solver->setParameters(amesos2_parameters([](auto& list) { list.set("MaxBlockSize", 64); }));
  EXPECT_EQ(solver->getStatus().getNumNumericFact(), 0);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
}

TEST(Amesos2Phases, NumericWithoutSymbolic) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  solver->setA(a, Amesos2::SYMBFACT);  // claims an analysis that there is not
  EXPECT_THROW(solver->numericFactorization(), mfs::StateError);
  solver->setA(a, Amesos2::NUMFACT);
  Vector x(a->getDomainMap(), 1), b(a->getRangeMap(), 1);
  EXPECT_THROW(solver->solve(&x, &b), mfs::StateError);
  solver->setA(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
}

// ---- errors ----

TEST(Amesos2Errors, ChangedPattern) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  Entries entries = grid_entries(6, 5);
  entries[{17, 3}] = 1.0;
  const auto changed = assemble(entries, even_map(30));
  solver->setA(changed, Amesos2::SYMBFACT);
  const Caught<mfs::PatternChanged> e([&] { solver->numericFactorization(); });
  EXPECT_EQ(e->row(), 17) << e->what();
  Vector x(a->getDomainMap(), 1), b(a->getRangeMap(), 1);
  EXPECT_ANY_THROW(solver->solve(&x, &b)) << "the old factors must not answer";
  solver->setA(changed);
  EXPECT_LT(solve_error(*solver, *changed), kSmall);
}

TEST(Amesos2Errors, PatternChangedInPlace) {
  const auto a = open_matrix(grid_entries(6, 5), even_map(30));
  a->fillComplete();
  const auto solver = make(a);
  solver->numericFactorization();
  const auto other = assemble(grid_entries(5, 6), even_map(30));
  solver->setA(other, Amesos2::SYMBFACT);
  EXPECT_THROW(solver->numericFactorization(), mfs::PatternChanged);
  EXPECT_THROW(solver->numericFactorization(), mfs::PatternChanged);
  solver->setA(a, Amesos2::SYMBFACT);
  solver->numericFactorization();
  EXPECT_LT(solve_error(*solver, *a), kSmall) << "the analysis was kept";
}

TEST(Amesos2Errors, OtherIdsAreAnotherPattern) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  solver->numericFactorization();
  const auto id = [](Ordinal k) { return k + 1; };
  solver->setA(assemble(renamed(grid_entries(6, 5), id, id), even_map(30, 1)), Amesos2::SYMBFACT);
  EXPECT_THROW(solver->numericFactorization(), mfs::PatternChanged);
}

TEST(Amesos2Errors, Shapes) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  Vector x(even_map(30), 2), b(even_map(30), 2), short_x(even_map(29), 2), long_b(even_map(31), 2),
      narrow(even_map(30), 1);
  EXPECT_THROW(solver->solve(&short_x, &b), std::invalid_argument);
  EXPECT_THROW(solver->solve(&x, &long_b), std::invalid_argument);
  EXPECT_THROW(solver->solve(&x, &narrow), std::invalid_argument);
  EXPECT_THROW(solver->solve(&narrow, &b), std::invalid_argument);
  EXPECT_ANY_THROW(solver->solve());  // neither X nor B was given
  EXPECT_ANY_THROW(solver->solve(nullptr, &b));
  EXPECT_LT(solve_error(*solver, *a, 2), kSmall);
}

TEST(Amesos2Errors, Dimensions) {
  const auto a = assemble(grid_entries(6, 5), even_map(30)),
             bigger = assemble(grid_entries(7, 6), even_map(42));
  const auto wide = assemble(grid_entries(6, 5), even_map(30), even_map(33));
  const auto solver = make(a);
  solver->numericFactorization();
  EXPECT_THROW(solver->setA(bigger, Amesos2::SYMBFACT), std::invalid_argument);
  EXPECT_THROW(solver->setA(bigger, Amesos2::NUMFACT), std::invalid_argument);
  EXPECT_THROW(solver->setA(wide), std::invalid_argument);
  EXPECT_THROW(solver->setA(RCP<const Matrix>()), std::invalid_argument);
  EXPECT_THROW(make(wide), std::invalid_argument);
  EXPECT_LT(solve_error(*solver, *a), kSmall) << "what was there is still there";
}

TEST(Amesos2Errors, MatrixNotComplete) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  a->resumeFill();
  EXPECT_THROW(solver->numericFactorization(), std::invalid_argument);
  a->fillComplete();
  EXPECT_THROW(solve_error(*solver, *a), mfs::StateError) << "the old factors must not answer";
  a->resumeFill();
  EXPECT_THROW(solver->symbolicFactorization(), std::invalid_argument);
  a->fillComplete();
  solver->symbolicFactorization();
  EXPECT_LT(solve_error(*solver, *a), kSmall);
}

/// Rows 8 and 21 are (1 1) in columns 8 and 21, also after any elimination; ids are 3 k + 5.
TEST(Amesos2Errors, NumericallySingularNamesTheRow) {
  const auto id = [](Ordinal k) { return 3 * k + 5; };
  Ids ids;
  for (Ordinal k = 0; k < 30; ++k) ids.push_back(id(k));
  Entries entries;
  for (const auto& [place, value] : grid_entries(6, 5))
    if (place.first != 8 && place.first != 21) entries[place] = value;
  for (const Ordinal row : {8, 21}) entries[{row, 8}] = entries[{row, 21}] = 1.0;
  const auto a = assemble(renamed(entries, id, id), dealt_map(ids));
  const auto solver = make(a);
  Vector x(a->getDomainMap(), 1), b(a->getRangeMap(), 1);
  b.putScalar(1.0);
  if (a->getRowMap()->isNodeGlobalElement(id(8))) b.replaceGlobalValue(id(8), 0, -1.0);  // no solution
  const Caught<mfs::SingularMatrix> e([&] { solver->solve(&x, &b); });
  EXPECT_EQ(e->kind(), mfs::SingularMatrix::Kind::numerical);
  EXPECT_THAT(e->row(), AnyOf(id(8), id(21))) << e->what();
  EXPECT_THAT(e->column(), AnyOf(id(8), id(21))) << e->what();
  EXPECT_THAT(e->what(), HasSubstr("global ids: row " + std::to_string(e->row())));
}

/// Rows 8 and 21 are equal, and so are their right-hand sides.
TEST(Amesos2Solve, SingularOnRequest) {
  Entries entries;
  for (const auto& [place, value] : grid_entries(6, 5)) {
    if (place.first == 21) continue;
    entries[place] = value;
    if (place.first == 8) entries[{21, place.second}] = value;
  }
  const auto a = assemble(entries, even_map(30));
  const auto solver = make(a);
  EXPECT_THROW(solve_error(*solver, *a), mfs::SingularMatrix);
  solver->setParameters(amesos2_parameters([](auto& list) { list.set("SolveSingular", true); }));
  Vector x(a->getDomainMap(), 1), b(a->getRangeMap(), 1), residual(a->getRangeMap(), 1);
  x.putScalar(1.0);
  a->apply(x, b);
  solver->solve(&x, &b);
  a->apply(x, residual);
  residual.update(1.0, b, -1.0);
  EXPECT_LT(residual.getVector(0)->normInf(), 1e-12);
  solver->setParameters(amesos2_parameters([](auto& list) { list.set("SolveSingular", false); }));
  EXPECT_THROW(solve_error(*solver, *a), mfs::SingularMatrix);
}

TEST(Amesos2Errors, StructurallySingularNamesTheColumn) {
  Entries entries = grid_entries(6, 5);
  for (Ordinal row = 0; row < 30; ++row) entries.erase({row, 13});
  const auto a = assemble(entries, even_map(30));
  const auto solver = make(a);
  const Caught<mfs::SingularMatrix> e([&] { solver->symbolicFactorization(); });
  EXPECT_EQ(e->kind(), mfs::SingularMatrix::Kind::structural);
  EXPECT_EQ(e->column(), 13) << e->what();
  const auto good = assemble(grid_entries(6, 5), even_map(30));
  solver->setA(good);
  EXPECT_LT(solve_error(*solver, *good), kSmall);
}

/// FROSch of Trilinos 16.1 analyses a subdomain before its values are there.
TEST(Amesos2Solve, AnalysesBeforeTheValuesAreThere) {
  const auto set_values = [](Matrix& a, double factor) {
    a.resumeFill();
    for (const auto& [place, value] : grid_entries(6, 5))
      if (a.getRowMap()->isNodeGlobalElement(place.first))
        a.replaceGlobalValues(place.first, Teuchos::tuple(place.second), Teuchos::tuple(factor * value));
    a.fillComplete();
  };
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  set_values(*a, 0.0);
  const auto solver = make(a);
  solver->symbolicFactorization();
  const Caught<mfs::SingularMatrix> e([&] { solver->numericFactorization(); });
  EXPECT_EQ(e->kind(), mfs::SingularMatrix::Kind::structural);
  for (const double factor : {1.0, 3.0}) {
    set_values(*a, factor);
    solver->numericFactorization();
    EXPECT_LT(solve_error(*solver, *a), kSmall);
  }
  EXPECT_EQ(solver->getStatus().getNumSymbolicFact(), 1);

  Entries entries = grid_entries(6, 5);
  for (Ordinal row = 0; row < 30; ++row) entries.erase({row, 13});
  for (auto& [place, value] : entries) value = 0.0;
  const Caught<mfs::SingularMatrix> never(
      [&] { make(assemble(entries, even_map(30)))->symbolicFactorization(); });
  EXPECT_EQ(never->column(), 13) << never->what();
}

TEST(Amesos2Errors, RecoversFromASingularStep) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  a->resumeFill();
  a->setAllToScalar(0.0);
  a->fillComplete();
  Vector x(a->getDomainMap(), 1), b(a->getRangeMap(), 1);
  b.putScalar(1.0);
  EXPECT_THROW(
      {
        solver->numericFactorization();
        solver->solve(&x, &b);
      },
      mfs::SingularMatrix);
  a->resumeFill();
  for (const auto& [place, value] : grid_entries(6, 5))
    if (a->getRowMap()->isNodeGlobalElement(place.first))
      a->replaceGlobalValues(place.first, Teuchos::tuple(place.second), Teuchos::tuple(value));
  a->fillComplete();
  solver->numericFactorization();
  EXPECT_LT(solve_error(*solver, *a), kSmall);
  EXPECT_EQ(solver->getStatus().getNumSymbolicFact(), 1);
}

TEST(Amesos2Errors, NotANumberHasAPlace) {
  const auto id = [](Ordinal k) { return 2 * k + 100; };
  Ids ids;
  for (Ordinal k = 0; k < 30; ++k) ids.push_back(id(k));
  Entries entries = grid_entries(6, 5);
  entries[{25, 26}] = std::numeric_limits<double>::quiet_NaN();
  const auto a = assemble(renamed(entries, id, id), dealt_map(ids));
  const Caught<mfs::InvalidInput> e([&] { make(a)->numericFactorization(); });
  EXPECT_EQ(e->row(), id(25)) << e->what();
  EXPECT_EQ(e->column(), id(26)) << e->what();
  EXPECT_THAT(e->what(), HasSubstr("row 150, column 152"));
}

TEST(Amesos2Errors, NotANumberInTheRightHandSide) {
  const auto id = [](Ordinal k) { return 2 * k + 100; };
  Ids ids;
  for (Ordinal k = 0; k < 30; ++k) ids.push_back(id(k));
  const auto a = assemble(renamed(grid_entries(6, 5), id, id), dealt_map(ids));
  const auto b = image(*a, 2);
  if (b->getMap()->isNodeGlobalElement(id(4)))
    b->replaceGlobalValue(id(4), 1, std::numeric_limits<double>::infinity());
  Vector x(a->getDomainMap(), 2);
  x.putScalar(7.0);
  const auto solver = make(a);
  const Caught<mfs::InvalidInput> e([&] { solver->solve(&x, b.get()); });
  EXPECT_EQ(e->row(), id(4)) << e->what();
  EXPECT_EQ(e->column(), 1) << e->what();
  for (std::size_t j = 0; j < 2; ++j)
    for (const double value : x.getData(j)) EXPECT_EQ(value, 7.0) << "x was touched";
}

TEST(Amesos2Errors, ValuesOnADeviceWithoutABackendForIt) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  solver->symbolicFactorization().numericFactorization();
  auto& mfs_solver = dynamic_cast<Amesos2::MFS<Matrix, Vector>&>(*solver);
  EXPECT_FALSE(mfs_solver.takesDeviceValues());
  EXPECT_THROW(mfs_solver.setDeviceValues(nullptr), mfs::StateError);
  EXPECT_LT(solve_error(*solver, *a), kSmall);
}

TEST(Amesos2Errors, ABackendThatIsNotThere) {
  for (const mfs::Backend backend : mfs::backends())
    if (backend == mfs::Backend::cuda) GTEST_SKIP() << "there is one";
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  const auto solver = make(a);
  solver->setParameters(amesos2_parameters([](auto& list) { list.set("Backend", "cuda"); }));
  EXPECT_THROW(solver->symbolicFactorization(), mfs::Error);
  solver->setParameters(amesos2_parameters([](auto& list) { list.set("Backend", "serial"); }));
  EXPECT_LT(solve_error(*solver, *a), kSmall);
}

}  // namespace
