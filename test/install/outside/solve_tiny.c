/* The example of the README in C, and the position of a bad entry. */
#include <mfs/mfs.h>
#include <stdio.h>

int main(void) {
  const int row_offsets[] = {0, 2, 5, 7}, columns[] = {0, 1, 0, 1, 2, 1, 2};
  const double values[] = {4, -1, -1, 4, -1, -1, 4}, b[] = {3, 2, 3};
  const int wrong[] = {0, 1, 0, 3, 2, 1, 2};
  double x[3];
  int64_t row, column;
  const char* text;
  mfs_solver* solver;
  if (mfs_create(MFS_DOUBLE, 32, &solver) || mfs_factor(solver, 3, row_offsets, columns, values) ||
      mfs_solve(solver, b, x, 1, 0, 0)) {
    mfs_last_error(&text, NULL, NULL);
    printf("%s\n", text);
    return 1;
  }
  printf("x = %g %g %g\n", x[0], x[1], x[2]);
  mfs_analyze(solver, 3, row_offsets, wrong, values);
  mfs_destroy(solver);
  return mfs_last_error(NULL, &row, &column) == MFS_INVALID_INPUT && row == 1 && column == 3 ? 0 : 2;
}
