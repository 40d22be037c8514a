// MFS as a concrete solver of Amesos2, on any number of ranks: two right-hand sides, a wrong option, a
// singular matrix. In Amesos2 itself the solver is made by Amesos2::create<Matrix, Vector>("MFS", ...), which
// needs the lines in README.md.
#include <Tpetra_Core.hpp>
#include <Tpetra_CrsMatrix.hpp>
#include <exception>
#include <iostream>

#include "Amesos2_MFS.hpp"
// With explicit instantiation the library would have these.
#include <Amesos2_SolverCore_def.hpp>

#include "Amesos2_MFS_def.hpp"

using Matrix = Tpetra::CrsMatrix<double>;
using Vector = Tpetra::MultiVector<double>;

template <class Work>
bool throws(const Work& work) {
  try {
    work();
  } catch (const std::exception&) {
    return true;
  }
  return false;
}

Teuchos::RCP<Matrix> tridiagonal(const Teuchos::RCP<const Matrix::map_type>& map, int n) {
  auto a = Teuchos::rcp(new Matrix(map, 3));
  for (auto row = map->getMinGlobalIndex(); row <= map->getMaxGlobalIndex(); ++row) {
    a->insertGlobalValues(row, Teuchos::tuple(row), Teuchos::tuple(4.0));
    if (row > 0) a->insertGlobalValues(row, Teuchos::tuple(row - 1), Teuchos::tuple(-2.0));
    if (row < n - 1) a->insertGlobalValues(row, Teuchos::tuple(row + 1), Teuchos::tuple(-1.0));
  }
  a->fillComplete();
  return a;
}

int main(int argc, char** argv) {
  Tpetra::ScopeGuard scope(&argc, &argv);
  const int n = 30;
  const auto map = Teuchos::rcp(new Matrix::map_type(n, 0, Tpetra::getDefaultComm()));
  const auto a = tridiagonal(map, n);
  const auto x = Teuchos::rcp(new Vector(map, 2)), b = Teuchos::rcp(new Vector(map, 2)),
             r = Teuchos::rcp(new Vector(map, 2));
  b->randomize();
  Amesos2::MFS<Matrix, Vector> solver(a, x, b);
  const auto parameters = Teuchos::parameterList("Amesos2");
  parameters->sublist("MFS")
      .set("threads", 1)
      .set("tolerance", 1e-11)
      .set("precision", "full")
      .set("scaling", true);
  solver.setParameters(parameters);
  solver.symbolicFactorization().numericFactorization().solve();
  a->apply(*x, *r);
  r->update(-1, *b, 1);
  Teuchos::Array<double> norms(2);
  r->normInf(norms());
  const bool solved = norms[0] < 1e-14 && norms[1] < 1e-14;

  parameters->sublist("MFS").set("treads", 1);
  const bool refused = throws([&] { solver.setParameters(parameters); });

  a->resumeFill();
  a->setAllToScalar(0.0);
  a->fillComplete();
  const bool singular = throws([&] { solver.numericFactorization().solve(); });
  if (map->getComm()->getRank() == 0)
    std::cout << "solved " << solved << ", wrong option refused " << refused << ", singular matrix refused "
              << singular << "\n";
  return solved && refused && singular ? 0 : 1;
}
