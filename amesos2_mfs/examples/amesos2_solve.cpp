// A sparse system solved through Amesos2, by MFS and by KLU2 side by side.
//
//   amesos2_solve A.mtx                 a Matrix Market file
//   amesos2_solve                       3D convection and diffusion on a grid (--grid 16)
//   amesos2_solve A.mtx --solver MFS    one solver only
//
// The right-hand side belongs to the solution 1. For each solver: the times of its phases, and the
// componentwise backward error max_i |b - A x|_i / (|A| |x| + |b|)_i, computed here from the matrix as it was
// given. Exit codes: 0 solved, 1 backward error above 1e-12 or a failure, 2 usage.
#include <Amesos2_MFS.hpp>

#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <string>

#include <MatrixMarket_Tpetra.hpp>
#include <Teuchos_CommandLineProcessor.hpp>
#include <Tpetra_Core.hpp>

namespace {

using Teuchos::RCP;
using Teuchos::rcp;
using Matrix = Tpetra::CrsMatrix<double>;
using Vector = Tpetra::MultiVector<double>;
using Map = Tpetra::Map<>;
using Ordinal = Map::global_ordinal_type;

/// -lap(u) + 20 du/dx on a grid of n^3 unknowns, central differences.
RCP<const Matrix> convection_diffusion(int n, const RCP<const Teuchos::Comm<int>>& comm) {
  const auto map = rcp(new Map(static_cast<Tpetra::global_size_t>(n) * n * n, 0, comm));
  const auto a = rcp(new Matrix(map, 7));
  const double wind = 10.0 / (n + 1);
  for (std::size_t local = 0; local < map->getMyGlobalIndices().extent(0); ++local) {
    const Ordinal row = map->getGlobalElement(static_cast<int>(local));
    const Ordinal x = row % n, y = row / n % n, z = row / (Ordinal{n} * n);
    const auto insert = [&](bool inside, Ordinal column, double value) {
      if (inside) a->insertGlobalValues(row, Teuchos::tuple(column), Teuchos::tuple(value));
    };
    insert(z > 0, row - Ordinal{n} * n, -1.0);
    insert(y > 0, row - n, -1.0);
    insert(x > 0, row - 1, -1.0 - wind);
    insert(true, row, 6.0);
    insert(x < n - 1, row + 1, -1.0 + wind);
    insert(y < n - 1, row + n, -1.0);
    insert(z < n - 1, row + Ordinal{n} * n, -1.0);
  }
  a->fillComplete();
  return a;
}

/// The same pattern with the magnitudes of the entries.
RCP<const Matrix> magnitudes(const Matrix& a) {
  const auto result = rcp(new Matrix(a, Teuchos::Copy));
  auto values = result->getLocalMatrixHost().values;
  for (std::size_t k = 0; k < values.extent(0); ++k) values(k) = std::abs(values(k));
  return result;
}

double backward_error(const Matrix& a, const Vector& x, const Vector& b) {
  Vector residual(b, Teuchos::Copy), bound(b.getMap(), 1), size_x(x, Teuchos::Copy), size_b(b, Teuchos::Copy);
  a.apply(x, residual, Teuchos::NO_TRANS, -1.0, 1.0);
  size_x.abs(x);
  size_b.abs(b);
  magnitudes(a)->apply(size_x, bound);
  bound.update(1.0, size_b, 1.0);
  double local = 0.0, worst = 0.0;
  const auto r = residual.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto d = bound.getLocalViewHost(Tpetra::Access::ReadOnly);
  for (std::size_t i = 0; i < r.extent(0); ++i) {
    const double ratio = r(i, 0) == 0.0 ? 0.0 : std::abs(r(i, 0)) / d(i, 0);
    if (!(ratio <= local)) local = ratio;  // a NaN stays
  }
  Teuchos::reduceAll(*a.getComm(), Teuchos::REDUCE_MAX, local, Teuchos::outArg(worst));
  return worst;
}

/// Seconds of `work`.
template <class Work>
double seconds(const Work& work) {
  const double start = Teuchos::Time::wallTime();
  work();
  return Teuchos::Time::wallTime() - start;
}

/// Solves with the solver of that name and prints one line. Returns the backward error.
double solve_and_print(const std::string& name, const RCP<const Matrix>& a, std::ostream& out) {
  const auto x = rcp(new Vector(a->getDomainMap(), 1));
  const auto b = rcp(new Vector(a->getRangeMap(), 1));
  x->putScalar(1.0);
  a->apply(*x, *b);
  x->putScalar(0.0);
  RCP<Amesos2::Solver<Matrix, Vector>> solver;
  const double create = seconds([&] { solver = Amesos2::create<Matrix, Vector>(name, a, x, b); });
  const double symbolic = seconds([&] { solver->symbolicFactorization(); });
  const double numeric = seconds([&] { solver->numericFactorization(); });
  const double again = seconds([&] { solver->numericFactorization(); });
  const double substitution = seconds([&] { solver->solve(); });
  const double error = backward_error(*a, *x, *b);
  out << std::left << std::setw(8) << name << std::right << std::scientific << std::setprecision(2)
      << std::setw(11) << create << std::setw(11) << symbolic << std::setw(11) << numeric << std::setw(11)
      << again << std::setw(11) << substitution << std::setw(12) << solver->getStatus().getNnzLU()
      << std::setw(12) << error << std::endl;
  return error;
}

/// Whether the solver of that name solves A x = b to the last digits.
bool solve(const std::string& name, const RCP<const Matrix>& a, std::ostream& out) {
  try {
    return solve_and_print(name, a, out) <= 1e-12;
  } catch (const std::exception& e) {
    out << std::left << std::setw(8) << name << e.what() << std::endl;
    return false;
  }
}

int run(int argc, char** argv) {
  std::string only;
  int grid = 16;
  Teuchos::CommandLineProcessor line(false, true, true);
  line.setDocString("amesos2_solve [A.mtx] [--solver=NAME] [--grid=N]");
  line.setOption("solver", &only, "one solver instead of MFS and KLU2");
  line.setOption("grid", &grid, "unknowns per side, without a file");
  std::string file;
  if (argc > 1 && argv[1][0] != '-') {
    file = argv[1];
    --argc;
    ++argv;
  }
  const auto parsed = line.parse(argc, argv);
  if (parsed == Teuchos::CommandLineProcessor::PARSE_HELP_PRINTED) return 0;
  if (parsed != Teuchos::CommandLineProcessor::PARSE_SUCCESSFUL || grid < 1) return 2;

  const auto comm = Tpetra::getDefaultComm();
  const auto a = file.empty()
                     ? convection_diffusion(grid, comm)
                     : RCP<const Matrix>(Tpetra::MatrixMarket::Reader<Matrix>::readSparseFile(file, comm));
  Teuchos::oblackholestream nowhere;
  std::ostream& out = comm->getRank() == 0 ? std::cout : static_cast<std::ostream&>(nowhere);
  out << "n = " << a->getGlobalNumRows() << ", nnz = " << a->getGlobalNumEntries() << ", times in s\n"
      << "solver       create   symbolic    numeric      again      solve    nnz(L+U)  backward error\n";
  const bool solved = solve(only.empty() ? "MFS" : only, a, out);
  if (only.empty()) solve("KLU2", a, out);
  return solved ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Tpetra::ScopeGuard scope(&argc, &argv);
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "amesos2_solve: " << e.what() << "\n";
    return 1;
  }
}
