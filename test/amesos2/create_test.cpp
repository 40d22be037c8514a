// How MFS is reached and told what to do: create, query, Trilinos' own callers of create, Epetra, parameters,
// description.
#include <Amesos2_MFS.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <sstream>
#include <string>

#include <Teuchos_DefaultSerialComm.hpp>
#include <Teuchos_FancyOStream.hpp>
#include <Teuchos_VerboseObject.hpp>
#include <Trilinos_Details_LinearSolver.hpp>
#include <Trilinos_Details_LinearSolverFactory.hpp>
#ifdef HAVE_AMESOS2_EPETRA
#include <Epetra_Map.h>
#include <Epetra_MpiComm.h>
#endif
#ifdef MFS_TEST_IFPACK2
#include <Ifpack2_Factory.hpp>
#endif

#include <mfs/mfs.hpp>

#include "test/amesos2/other_unit.hpp"
#include "test/amesos2/systems.hpp"
#include "test/program/temporary_folder.hpp"

namespace {

using namespace mfs::test;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Solver = Amesos2::Solver<Matrix, Vector>;

constexpr double kSmall = 1e-11;

RCP<const Matrix> grid() {
  return assemble(grid_entries(6, 5), even_map(30));
}

// ---- create and query ----

TEST(Amesos2Create, EachForm) {
  const auto a = grid();
  const RCP<const Vector> b = image(*a);
  const auto x = rcp(new Vector(a->getDomainMap(), 1));
  for (const auto& solver :
       {Amesos2::create<Matrix, Vector>(std::string("MFS"), a, x, b),
        Amesos2::create<Matrix, Vector>("MFS", a, x, b), Amesos2::create("MFS", a, x, b)}) {
    EXPECT_EQ(solver->name(), "MFS");
    x->putScalar(0.0);
    solver->solve();
    EXPECT_LT(distance_from_samples(*x), kSmall);
  }
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", a);
  EXPECT_EQ(solver->name(), "MFS");
  solver->setX(x);
  solver->setB(b);
  x->putScalar(0.0);
  solver->solve();
  EXPECT_LT(distance_from_samples(*x), kSmall);
}

TEST(Amesos2Create, EachSpelling) {
  const auto a = grid();
  for (const char* name : {"MFS", "mfs", "Mfs", "amesos2_mfs", "Amesos2_MFS"}) {
    EXPECT_EQ((Amesos2::create<Matrix, Vector>(name, a))->name(), "MFS") << name;
    EXPECT_TRUE(Amesos2::query(name)) << name;
    EXPECT_TRUE(Amesos2::query(std::string(name))) << name;
  }
}

TEST(Amesos2Create, OtherNamesStayWhatTheyWere) {
  const auto a = grid();
  for (const char* name : {"KLU2", "klu", "amesos2_klu2"}) {
    EXPECT_EQ((Amesos2::create<Matrix, Vector>(name, a))->name(), "KLU2");
    EXPECT_TRUE(Amesos2::query(name));
  }
  EXPECT_FALSE(Amesos2::query("nobody"));
  EXPECT_FALSE(Amesos2::query(std::string("mfs2")));
}

TEST(Amesos2Create, UnknownNameGetsTheUsualException) {
  const auto a = grid();
  for (const char* name : {"nobody", "", "mfs ", "amesos2_"}) {
    try {
      Amesos2::create<Matrix, Vector>(name, a);
      FAIL() << name;
    } catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), HasSubstr(std::string(name) + " is not enabled or is not supported"));
    }
  }
}

TEST(Amesos2Create, NoMatrix) {
  EXPECT_THROW((Amesos2::create<Matrix, Vector>("MFS", RCP<const Matrix>())), std::invalid_argument);
}

TEST(Amesos2Create, SideBySideWithKLU2) {
  if (world()->getSize() > 1) GTEST_SKIP() << "KLU2 of Trilinos 13.2 is wrong on several ranks";
  const auto a = grid();
  const auto b = image(*a, 2);
  const auto ours = Amesos2::create<Matrix, Vector>("MFS", a),
             theirs = Amesos2::create<Matrix, Vector>("KLU2", a);
  Vector x(a->getDomainMap(), 2), y(a->getDomainMap(), 2);
  ours->solve(&x, b.get());
  theirs->solve(&y, b.get());
  EXPECT_LT(distance_from_samples(x), kSmall);
  EXPECT_LT(distance_from_samples(y), kSmall);
}

TEST(Amesos2Create, FromAUnitThatNeverSawTheHeader) {
  for (int form = 0; form < 3; ++form) {
    const OtherUnit made = create_in_other_unit("amesos2_mfs", form);
    EXPECT_EQ(made.solver, "MFS") << form;
    EXPECT_LT(made.error, kSmall) << form;
    EXPECT_TRUE(made.known);
  }
  EXPECT_EQ(create_in_other_unit("klu2", 2).solver, "KLU2");
}

TEST(Amesos2Create, ThroughTheLinearSolverFactory) {
  const auto a = grid();
  const auto b = image(*a);
  Vector x(a->getDomainMap(), 1);
  const auto solver = Trilinos::Details::getLinearSolver<Vector, Tpetra::Operator<double>, Vector::mag_type>(
      "Amesos2", "MFS");
  ASSERT_FALSE(solver.is_null());
  solver->setMatrix(a);
  solver->symbolic();
  solver->numeric();
  solver->solve(x, *b);
  EXPECT_LT(distance_from_samples(x), kSmall);
  EXPECT_THAT(dynamic_cast<const Teuchos::Describable&>(*solver).description(), HasSubstr("MFS"));
}

#ifdef MFS_TEST_IFPACK2
/// On several ranks Ifpack2's AMESOS2 solves with each rank's own block.
TEST(Amesos2Create, ThroughIfpack2) {
  const auto a = grid();
  const auto preconditioner = Ifpack2::Factory::create<Tpetra::RowMatrix<double>>("AMESOS2", a);
  Teuchos::ParameterList list;
  list.set("Amesos2 solver name", "MFS");
  list.sublist("Amesos2").sublist("MFS").set("Threads", 1);
  preconditioner->setParameters(list);
  preconditioner->initialize();
  preconditioner->compute();
  const auto b = image(*a);
  Vector x(a->getDomainMap(), 1);
  preconditioner->apply(*b, x);
  EXPECT_TRUE(world()->getSize() > 1 || distance_from_samples(x) < kSmall);
  EXPECT_THAT(preconditioner->description(), HasSubstr("MFS solver interface"));
}
#endif

// ---- Epetra ----

#ifdef HAVE_AMESOS2_EPETRA

RCP<Epetra_CrsMatrix> epetra_matrix(const Entries& entries, const Epetra_Map& map) {
  const auto a = rcp(new Epetra_CrsMatrix(Copy, map, 8));
  for (const auto& [place, value] : entries) {
    const int column = static_cast<int>(place.second);
    if (map.MyGID(static_cast<int>(place.first)))
      a->InsertGlobalValues(static_cast<int>(place.first), 1, &value, &column);
  }
  a->FillComplete();
  return a;
}

double epetra_distance(const Epetra_MultiVector& x) {
  double worst = 0.0;
  for (int j = 0; j < x.NumVectors(); ++j)
    for (int i = 0; i < x.MyLength(); ++i)
      worst = std::max(worst, std::abs(x[j][i] - sample(x.Map().GID(i), static_cast<std::size_t>(j))));
  return worst;
}

TEST(Amesos2Epetra, SolvesAndRefactors) {
  const Epetra_MpiComm comm(MPI_COMM_WORLD);
  for (const bool gapped : {false, true}) {
    std::vector<int> ids;
    for (int k = 0; k < 30; ++k)
      if (k % comm.NumProc() == comm.MyPID()) ids.push_back(gapped ? 4 * k + 9 : k);
    const Epetra_Map map(30, static_cast<int>(ids.size()), ids.data(), 0, comm);
    const auto id = [&](Ordinal k) { return gapped ? 4 * k + 9 : k; };
    const auto a = epetra_matrix(renamed(grid_entries(6, 5), id, id), map);
    const auto x = rcp(new Epetra_MultiVector(map, 2)), b = rcp(new Epetra_MultiVector(map, 2));
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < x->MyLength(); ++i) (*x)[j][i] = sample(map.GID(i), static_cast<std::size_t>(j));
    a->Multiply(false, *x, *b);
    x->PutScalar(0.0);
    const auto solver = Amesos2::create<Epetra_CrsMatrix, Epetra_MultiVector>("MFS", a, x, b);
    EXPECT_EQ(solver->name(), "MFS");
    solver->solve();
    EXPECT_LT(epetra_distance(*x), kSmall);
    a->Scale(0.5);
    b->Scale(0.5);
    solver->numericFactorization();
    solver->solve();
    EXPECT_LT(epetra_distance(*x), kSmall);
    EXPECT_EQ(solver->getStatus().getNumSymbolicFact(), 1);

    Entries other = grid_entries(6, 5);
    other[{3, 22}] = 1.0;
    solver->setA(epetra_matrix(renamed(other, id, id), map), Amesos2::SYMBFACT);
    try {
      solver->numericFactorization();
      FAIL();
    } catch (const mfs::PatternChanged& e) {
      EXPECT_EQ(e.row(), id(3)) << e.what();
    }
  }
}

TEST(Amesos2Epetra, OtherFormsAndNames) {
  const Epetra_MpiComm comm(MPI_COMM_WORLD);
  const Epetra_Map map(30, 0, comm);
  const RCP<const Epetra_CrsMatrix> a = epetra_matrix(grid_entries(6, 5), map);
  EXPECT_EQ((Amesos2::create<Epetra_CrsMatrix, Epetra_MultiVector>("mfs", a))->name(), "MFS");
  EXPECT_EQ((Amesos2::create<Epetra_CrsMatrix, Epetra_MultiVector>("klu2", a))->name(), "KLU2");
}

#endif  // HAVE_AMESOS2_EPETRA

// ---- parameters ----

TEST(Amesos2Parameters, EveryNameOfTheDocumentation) {
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", grid());
  const auto all = [](Teuchos::ParameterList& list) {
    list.set("Trans", "NOTRANS");
    list.set("IsContiguous", false);
    list.set("Backend", "serial");
    list.set("Threads", 1);
    list.set("DefaultThreads", 0);
    list.set("AnalysisThreads", 1);
    list.set("Matching", "never");
    list.set("Scaling", false);
    list.set("MaxBlockSize", 128);
    list.set("MemoryLimit", 0.0);
    list.set("OutOfCoreDir", "/tmp");
    list.set("LeafSize", 16);
    list.set("Precision", "full");
    list.set("PivotTolerance", 1e-10);
    list.set("MaxReanalyses", 2);
    list.set("Tolerance", 1e-13);
    list.set("MaxRefinementSteps", 5);
    list.set("RowFloor", 0.5);
    list.set("SolveSingular", true);
    list.set("DumpPrefix", "");
    list.set("Verbosity", 0);
  };
  EXPECT_NO_THROW(solver->setParameters(amesos2_parameters(all)));
  Teuchos::ParameterList given;
  all(given);
  const auto valid = Amesos2::mfs_valid_parameters();
  EXPECT_EQ(valid->numParams(), given.numParams());
  for (auto entry = valid->begin(); entry != valid->end(); ++entry) {
    EXPECT_TRUE(given.isParameter(valid->name(entry))) << valid->name(entry);
    EXPECT_THAT(valid->entry(entry).docString(), Not(IsEmpty())) << valid->name(entry);
  }
  solver->numericFactorization();
  if (world()->getRank() > 0) return;
  const mfs::Report& report = dynamic_cast<const Amesos2::MFS<Matrix, Vector>&>(*solver).report();
  EXPECT_EQ(report.threads, 1);
  EXPECT_EQ(report.backend, mfs::Backend::serial);
}

TEST(Amesos2Parameters, WrongOnesAreRefused) {
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", grid());
  const auto refused = [&](const std::function<void(Teuchos::ParameterList&)>& fill) {
    EXPECT_THROW(solver->setParameters(amesos2_parameters(fill)), Teuchos::Exceptions::InvalidParameter);
  };
  refused([](auto& list) { list.set("Tolerence", 1e-12); });
  refused([](auto& list) { list.set("Tolerance", "small"); });
  refused([](auto& list) { list.set("Tolerance", -1e-12); });
  refused([](auto& list) { list.set("Tolerance", std::nan("")); });
  refused([](auto& list) { list.set("PivotTolerance", 2.0); });
  refused([](auto& list) { list.set("RowFloor", 2.0); });
  refused([](auto& list) { list.set("SolveSingular", 1); });
  refused([](auto& list) { list.set("SolveSingular", "yes"); });
  refused([](auto& list) { list.set("Threads", -1); });
  refused([](auto& list) { list.set("Threads", 2.0); });
  refused([](auto& list) { list.set("DefaultThreads", -1); });
  refused([](auto& list) { list.set("AnalysisThreads", -1); });
  refused([](auto& list) { list.set("MaxBlockSize", 0); });
  refused([](auto& list) { list.set("MemoryLimit", -8e9); });
  refused([](auto& list) { list.set("MemoryLimit", std::nan("")); });
  refused([](auto& list) { list.set("MemoryLimit", "8GB"); });
  refused([](auto& list) { list.set("OutOfCoreDir", 3); });
  refused([](auto& list) { list.set("MaxRefinementSteps", -1); });
  refused([](auto& list) { list.set("Backend", "gpu"); });
  refused([](auto& list) { list.set("Matching", "perhaps"); });
  refused([](auto& list) { list.set("Precision", "double"); });
  refused([](auto& list) { list.set("MaxReanalyses", -2); });
  refused([](auto& list) { list.set("Trans", "T"); });
  refused([](auto& list) { list.set("DumpPrefix", 3); });
  refused([](auto& list) { list.set("Verbosity", 3); });
  const auto list = Teuchos::parameterList("Amesos2");
  list->set("Transposed", true);
  EXPECT_THROW(solver->setParameters(list), Teuchos::Exceptions::InvalidParameter);
  solver->numericFactorization();  // it still works, with what it had
}

int threads_of(const Solver& solver) {
  return dynamic_cast<const Amesos2::MFS<Matrix, Vector>&>(solver).report().threads;
}

/// What this process has to take: an equal part of all processors that the ranks of its node may use, of
/// which it may use these. MPI counts them here.
int share_of_node() {
  int ranks = 1;
  cpu_set_t own, all;
  CPU_ZERO(&own);
  sched_getaffinity(0, sizeof own, &own);
  all = own;
#ifdef HAVE_MPI
  MPI_Comm node;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
  MPI_Comm_size(node, &ranks);
  MPI_Allreduce(&own, &all, sizeof own, MPI_BYTE, MPI_BOR, node);
  MPI_Comm_free(&node);
#endif
  return std::max(1, std::min(CPU_COUNT(&own), CPU_COUNT(&all) / ranks));
}

/// Each rank has a matrix of its own, as the subdomains of a Schwarz method are, and nobody is asked.
TEST(Amesos2Threads, OfSubdomainsAreAShareOfTheNode) {
  const int share = share_of_node();
  const RCP<const Teuchos::Comm<int>> alone = rcp(new Teuchos::SerialComm<int>);
  const auto rows = rcp(new const Map(Tpetra::global_size_t{30}, 0, alone));
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", assemble(grid_entries(6, 5), rows));
  solver->numericFactorization();
  EXPECT_EQ(threads_of(*solver), share);
  solver->setParameters(amesos2_parameters([](auto& list) { list.set("DefaultThreads", 3); }));
  solver->numericFactorization();
  EXPECT_EQ(threads_of(*solver), 3);
  const auto other = Amesos2::create<Matrix, Vector>("MFS", assemble(grid_entries(6, 5), rows));
  other->numericFactorization();
  EXPECT_EQ(threads_of(*other), 3) << "a solver that was given no parameters";
  other->setParameters(amesos2_parameters([](auto& list) { list.set("Threads", 2); }));
  other->numericFactorization();
  EXPECT_EQ(threads_of(*other), 2);
  EXPECT_THROW(other->setParameters(amesos2_parameters([](auto& l) { l.set("DefaultThreads", 513); })),
               mfs::InvalidInput);
  mfs::set_default_threads(0);
}

TEST(Amesos2Parameters, DumpPrefixLeavesAFailingSystemInAFile) {
  const TemporaryFolder folder;  // that of rank 0 counts
  Entries entries = grid_entries(6, 5);
  for (Ordinal row = 0; row < 30; ++row) entries.erase({row, 13});
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", assemble(entries, even_map(30)));
  solver->setParameters(amesos2_parameters([&](auto& list) { list.set("DumpPrefix", folder.path("left")); }));
  try {
    solver->symbolicFactorization();
    FAIL();
  } catch (const mfs::SingularMatrix& e) {
    EXPECT_THAT(e.what(), HasSubstr("left_A.mtx")) << "on every rank";
  }
  if (world()->getRank() > 0) return;
  EXPECT_THAT(text_of(folder.path("left_A.mtx")), HasSubstr("\n30 30 "));
}

TEST(Amesos2Parameters, AListOfAnotherNameIsIgnored) {
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", grid());
  const auto list = Teuchos::parameterList("Ifpack2");
  list->set("whatever", 1);
  EXPECT_NO_THROW(solver->setParameters(list));
}

TEST(Amesos2Parameters, ListedByTheSolver) {
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", grid());
  const auto valid = solver->getValidParameters();
  EXPECT_TRUE(valid->isSublist("MFS"));
  EXPECT_EQ(valid->sublist("MFS").get<double>("Tolerance"), mfs::Options().solve.tolerance);
  EXPECT_EQ(valid->sublist("MFS").get<int>("MaxBlockSize"), mfs::Options().analysis.max_block_size);
}

// ---- totals ----

TEST(Amesos2Totals, CountWhatTheSolversOfTheProcessDo) {
  const auto a = grid();
  const auto b = image(*a, 3);
  Vector x(a->getDomainMap(), 3);
  const Amesos2::MfsTotals before = Amesos2::mfs_totals();
  const std::int64_t once = world()->getRank() == 0 ? 1 : 0;
  {
    const auto first = Amesos2::create<Matrix, Vector>("MFS", a),
               second = Amesos2::create<Matrix, Vector>("MFS", a);
    first->symbolicFactorization().numericFactorization().numericFactorization();
    second->solve(&x, b.get());
    const Amesos2::MfsTotals now = Amesos2::mfs_totals();
    EXPECT_EQ(now.analyses - before.analyses, 2 * once);
    EXPECT_EQ(now.factorizations - before.factorizations, 3 * once);
    EXPECT_EQ(now.solves - before.solves, 3 * once);
    EXPECT_EQ(now.bytes > before.bytes, once == 1);
    EXPECT_EQ(now.seconds_analyses > before.seconds_analyses, once == 1);
  }
  EXPECT_EQ(Amesos2::mfs_totals().bytes, before.bytes);
}

// ---- description ----

std::string described(const Solver& solver, Teuchos::EVerbosityLevel level) {
  std::ostringstream text;
  const auto out = Teuchos::getFancyOStream(Teuchos::rcpFromRef(text));
  solver.describe(*out, level);
  return text.str();
}

TEST(Amesos2Describe, Levels) {
  const auto a = grid();
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", a);
  EXPECT_EQ(solver->description(), "MFS solver interface: 30 unknowns, not analysed");
  const auto b = image(*a);
  Vector x(a->getDomainMap(), 1);
  solver->solve(&x, b.get());
  EXPECT_EQ(solver->description(), "MFS solver interface: 30 unknowns, factored");
  EXPECT_THAT(described(*solver, Teuchos::VERB_NONE), IsEmpty());
  if (world()->getRank() > 0) {
    EXPECT_THAT(described(*solver, Teuchos::VERB_EXTREME), IsEmpty());
    return;
  }
  const std::string low = described(*solver, Teuchos::VERB_LOW);
  EXPECT_THAT(
      low, AllOf(HasSubstr("30 rows, 128 entries"), HasSubstr("entries of L and U"), HasSubstr("threads")));
  EXPECT_THAT(low, Not(HasSubstr("flops")));
  EXPECT_EQ(described(*solver, Teuchos::VERB_DEFAULT), low);
  const std::string medium = described(*solver, Teuchos::VERB_MEDIUM);
  EXPECT_THAT(medium, AllOf(HasSubstr("flops"), HasSubstr("backward error"), HasSubstr("perturbed pivots: 0"),
                            Not(HasSubstr("MaxBlockSize"))));
  const std::string high = described(*solver, Teuchos::VERB_HIGH);
  EXPECT_THAT(high, AllOf(HasSubstr("MaxBlockSize"), HasSubstr("Tolerance"), Not(HasSubstr("max front"))));
  EXPECT_THAT(described(*solver, Teuchos::VERB_EXTREME),
              AllOf(HasSubstr("max front"), HasSubstr("Number of numeric factorizations = 1")));
}

TEST(Amesos2Describe, VerbosityTalksOnTheDefaultStream) {
  std::ostringstream text;
  const auto before = Teuchos::VerboseObjectBase::getDefaultOStream();
  Teuchos::VerboseObjectBase::setDefaultOStream(Teuchos::getFancyOStream(Teuchos::rcpFromRef(text)));
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", grid());
  solver->numericFactorization();
  EXPECT_THAT(text.str(), IsEmpty());
  solver->setParameters(amesos2_parameters([](auto& list) { list.set("Verbosity", 1); }));
  solver->numericFactorization();
  Teuchos::VerboseObjectBase::setDefaultOStream(before);
  if (world()->getRank() == 0)
    EXPECT_THAT(text.str(), HasSubstr("MFS: "));
  else
    EXPECT_THAT(text.str(), IsEmpty());
}

}  // namespace
