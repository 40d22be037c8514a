#include "test/amesos2/other_unit.hpp"

#include <Amesos2.hpp>

#include "test/amesos2/systems.hpp"

namespace mfs::test {

OtherUnit create_in_other_unit(const std::string& name, int form) {
  const RCP<const Matrix> a = assemble(grid_entries(4, 3), even_map(12));
  const RCP<const Vector> b = image(*a);
  const auto x = rcp(new Vector(a->getDomainMap(), 1));
  RCP<Amesos2::Solver<Matrix, Vector>> solver;
  switch (form) {
    case 0:
      solver = Amesos2::create<Matrix, Vector>(name, a);
      break;
    case 1:
      solver = Amesos2::create<Matrix, Vector>(name.c_str(), a, x, b);
      break;
    default:
      solver = Amesos2::create<Matrix, Vector>(name, a, x, b);
  }
  solver->setX(x);
  solver->setB(b);
  solver->solve();
  return {solver->name(), distance_from_samples(*x), Amesos2::query(name)};
}

}  // namespace mfs::test
