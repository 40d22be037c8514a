// The example of the README: a 3 x 3 system, and the position of a bad entry.
#include <cmath>
#include <cstdio>
#include <limits>
#include <mfs/mfs.hpp>

int main() {
  const int row_offsets[] = {0, 2, 5, 7};
  const int columns[] = {0, 1, 0, 1, 2, 1, 2};
  double values[] = {4, -1, -1, 4, -1, -1, 4};
  const double b[] = {3, 2, 3};
  double x[3];

  const mfs::CsrView<double> a{3, 3, row_offsets, columns, values};
  mfs::Solver solver;
  solver.factor(a);
  solver.solve(b, x);
  std::printf("x = %g %g %g, backward error %.1e\n", x[0], x[1], x[2], solver.report().backward_error);
  for (double value : x) {
    if (!(std::fabs(value - 1.0) < 1e-14)) return 1;
  }

  values[3] = std::numeric_limits<double>::quiet_NaN();
  try {
    solver.refactor(a);
  } catch (const mfs::InvalidInput& error) {
    return error.row() == 1 && error.column() == 1 ? 0 : 2;
  }
  return 3;
}
