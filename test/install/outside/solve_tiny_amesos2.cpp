// MFS through Amesos2, from the installed tree: the diagonal system 2 x = 1.
#include <Amesos2_MFS.hpp>
#include <Tpetra_Core.hpp>
#include <Tpetra_CrsMatrix.hpp>

int main(int argc, char** argv) {
  using Matrix = Tpetra::CrsMatrix<double>;
  using Vector = Tpetra::MultiVector<double>;
  Tpetra::ScopeGuard scope(&argc, &argv);
  const auto map = Teuchos::rcp(new Matrix::map_type(5, 0, Tpetra::getDefaultComm()));
  auto a = Teuchos::rcp(new Matrix(map, 1));
  for (auto row = map->getMinGlobalIndex(); row <= map->getMaxGlobalIndex(); ++row) {
    a->insertGlobalValues(row, Teuchos::tuple(row), Teuchos::tuple(2.0));
  }
  a->fillComplete();
  auto x = Teuchos::rcp(new Vector(map, 1)), b = Teuchos::rcp(new Vector(map, 1));
  b->putScalar(1.0);
  Amesos2::create<Matrix, Vector>("MFS", a, x, b)->solve();
  x->update(-0.5, *b, 1.0);
  Teuchos::Array<double> norm(1);
  x->normInf(norm());
  return norm[0] == 0.0 ? 0 : 1;
}
