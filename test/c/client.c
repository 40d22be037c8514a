/* A program of C99 that knows mfs/mfs.h only: a right input and wrong ones of every phase. */
#include <mfs/mfs.h>

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int good, const char* what) {
  if (good) return;
  const char* text;
  mfs_last_error(&text, NULL, NULL);
  printf("failed: %s (last error: %s)\n", what, text);
  ++failures;
}

static void expect_error(int status, int expected, int64_t row, int64_t column, const char* part) {
  const char* text;
  int64_t r, c;
  const int last = mfs_last_error(&text, &r, &c);
  if (status == expected && last == expected && r == row && c == column && strstr(text, part) != NULL) return;
  printf("failed: status %d, last %d at (%ld, %ld): %s\n  instead of %d at (%ld, %ld): %s\n", status, last,
         (long)r, (long)c, text, expected, (long)row, (long)column, part);
  ++failures;
}

static const int32_t offsets[] = {0, 2, 5, 7}, columns[] = {0, 1, 0, 1, 2, 1, 2};

/* A = (4 -1 0; -1 4 -1; 0 -1 4), det 56; then 5 in its first place, det 71. */
static void solve_real(void) {
  double values[] = {4, -1, -1, 4, -1, -1, 4}, x[6], phase[2], log_abs, condition, figure;
  const double b[] = {3, 2, 3, 6, 4, 6};
  mfs_solver* solver = NULL;
  expect(mfs_create(MFS_DOUBLE, 32, &solver) == MFS_OK && solver != NULL, "create");
  expect(mfs_set_option(solver, "threads", "1") == MFS_OK, "threads");
  expect(mfs_set_option(solver, "precision", "full") == MFS_OK, "precision");
  expect(mfs_analyze(solver, 3, offsets, columns, NULL) == MFS_OK, "analyze");
  expect(mfs_factor(solver, 3, offsets, columns, values) == MFS_OK, "factor");
  expect(mfs_solve(solver, b, x, 2, 0, 0) == MFS_OK, "solve");
  for (int i = 0; i < 6; ++i) expect(fabs(x[i] - (i < 3 ? 1 : 2)) < 1e-14, "solution");
  expect(mfs_determinant(solver, phase, &log_abs) == MFS_OK, "determinant");
  expect(fabs(phase[0] * exp(log_abs) - 56) < 1e-12 && phase[1] == 0, "determinant is 56");
  expect(mfs_condition_estimate(solver, &condition) == MFS_OK, "condition");
  expect(fabs(condition - 6 * 3.0 / 7) < 1e-12, "condition is 18/7");
  expect(mfs_report(solver, "nnz", &figure) == MFS_OK && figure == 7, "nnz");
  expect(mfs_report(solver, "backward_error", &figure) == MFS_OK && figure < 1e-12, "backward error");
  values[0] = 5;
  expect(mfs_refactor(solver, values) == MFS_OK, "refactor");
  expect(mfs_determinant(solver, phase, &log_abs) == MFS_OK, "determinant");
  expect(fabs(phase[0] * exp(log_abs) - 71) < 1e-12, "determinant is 71");
  mfs_destroy(solver);
}

/* (1 i; 0 2): the transposed system has another solution, and is not conjugated. */
static void solve_complex(void) {
  const int64_t wide_offsets[] = {0, 2, 3}, wide_columns[] = {0, 1, 1};
  const double complex values[] = {1, I, 2}, b[] = {1 + I, 2};
  double complex x[2];
  mfs_solver* solver = NULL;
  expect(mfs_create(MFS_COMPLEX_DOUBLE, 64, &solver) == MFS_OK, "create");
  expect(mfs_factor(solver, 2, wide_offsets, wide_columns, values) == MFS_OK, "factor");
  expect(mfs_solve(solver, b, x, 1, 0, 0) == MFS_OK, "solve");
  expect(cabs(x[0] - 1) + cabs(x[1] - 1) < 1e-14, "solution");
  expect(mfs_solve_transpose(solver, b, x, 1, 0, 0) == MFS_OK, "solve transposed");
  expect(cabs(x[0] - (1 + I)) + cabs(x[1] - (1.5 - 0.5 * I)) < 1e-14, "solution of the transposed");
  mfs_destroy(solver);
}

static void refuse(void) {
  double values[] = {4, -1, -1, 4, -1, -1, 4}, x[3] = {7, 7, 7}, figure = 0;
  const double b[] = {3, 2, 3}, singular[] = {1, 1, 1, 1, 0, 0, 4};
  const int32_t wrong[] = {0, 1, 0, 3, 2, 1, 2}, other[] = {0, 2, 0, 1, 2, 1, 2};
  mfs_solver* solver = (mfs_solver*)&figure;
  expect_error(mfs_create(MFS_DOUBLE, 16, &solver), MFS_INVALID_INPUT, -1, -1, "not 32 or 64");
  expect(solver == NULL, "no solver");
  expect_error(mfs_create(4, 32, &solver), MFS_INVALID_INPUT, -1, -1, "scalar: 4 is none");
  expect_error(mfs_create(MFS_DOUBLE, 32, NULL), MFS_INVALID_INPUT, -1, -1, "solver: is NULL");
  expect_error(mfs_factor(NULL, 3, offsets, columns, values), MFS_INVALID_INPUT, -1, -1, "solver: is NULL");
  expect(mfs_create(MFS_DOUBLE, 32, &solver) == MFS_OK, "create");
  expect_error(mfs_set_option(solver, "treads", "1"), MFS_INVALID_INPUT, -1, -1, "treads: no option");
  expect_error(mfs_set_option(solver, "threads", "1x"), MFS_INVALID_INPUT, -1, -1,
               "threads: \"1x\" is not an integer");
  expect_error(mfs_set_option(solver, "threads", "-1"), MFS_INVALID_INPUT, -1, -1, "not be negative");
  expect_error(mfs_set_option(solver, "threads", NULL), MFS_INVALID_INPUT, -1, -1, "value: is NULL");
  expect_error(mfs_solve(solver, b, x, 1, 0, 0), MFS_STATE_ERROR, -1, -1, "nothing has been factored");
  expect_error(mfs_factor(solver, 3, offsets, wrong, values), MFS_INVALID_INPUT, 1, 3, "");
  expect_error(mfs_factor(solver, -3, offsets, columns, values), MFS_INVALID_INPUT, -1, -1, "");
  expect_error(mfs_factor(solver, 3, NULL, columns, values), MFS_INVALID_INPUT, -1, -1,
               "row_offsets: are NULL");
  expect_error(mfs_factor(solver, 3, offsets, columns, NULL), MFS_INVALID_INPUT, -1, -1, "values: are NULL");
  values[3] = NAN;
  expect_error(mfs_factor(solver, 3, offsets, columns, values), MFS_INVALID_INPUT, 1, 1, "");
  expect(strcmp(mfs_last_error_argument(), "values") == 0, "it is about the values");
  values[3] = 4;
  expect(mfs_factor(solver, 3, offsets, columns, values) == MFS_OK, "factor after errors");
  expect_error(mfs_set_option(solver, "threads", "1"), MFS_STATE_ERROR, -1, -1, "before the first analysis");
  expect_error(mfs_factor(solver, 3, offsets, other, values), MFS_PATTERN_CHANGED, 0, -1, "");
  expect(strcmp(mfs_last_error_argument(), "") == 0, "it is about no argument");
  expect(mfs_factor(solver, 3, offsets, columns, values) == MFS_OK, "the same pattern again");
  expect_error(mfs_solve(solver, b, NULL, 1, 0, 0), MFS_INVALID_INPUT, -1, -1, "x: is NULL");
  expect_error(mfs_solve(solver, b, x, 1, 2, 0), MFS_INVALID_INPUT, -1, -1, "");
  expect_error(mfs_solve_device(solver, b, x, 1, 0, 0, NULL), MFS_STATE_ERROR, -1, -1, "");
  expect_error(mfs_solve_transpose_device(solver, b, x, 1, 0, 0, NULL), MFS_STATE_ERROR, -1, -1, "");
  expect_error(mfs_refactor_device(solver, values, NULL), MFS_STATE_ERROR, -1, -1, "");
  expect_error(mfs_report(solver, "speed", &figure), MFS_INVALID_INPUT, -1, -1, "no figure \"speed\"");
  expect_error(mfs_determinant(solver, NULL, &figure), MFS_INVALID_INPUT, -1, -1, "phase: is NULL");
  expect_error(mfs_condition_estimate(solver, NULL), MFS_INVALID_INPUT, -1, -1, "condition: is NULL");
  expect(mfs_refactor(solver, singular) == MFS_OK || mfs_last_error(NULL, NULL, NULL) == MFS_SINGULAR_MATRIX,
         "singular");
  expect(mfs_solve(solver, b, x, 1, 0, 0) == MFS_SINGULAR_MATRIX, "a singular matrix has no solution");
  expect(x[0] == 7 && x[1] == 7 && x[2] == 7, "x is untouched");
  expect(mfs_refactor(solver, values) == MFS_OK && mfs_solve(solver, b, x, 1, 0, 0) == MFS_OK, "good again");
  expect(fabs(x[0] - 1) < 1e-14, "solution");
  expect_error(mfs_set_default_threads(-1), MFS_INVALID_INPUT, -1, -1, "");
  mfs_destroy(solver);
  mfs_destroy(NULL);
}

static void list_names(void) {
  int options = 0, figures = 0;
  mfs_solver* solver = NULL;
  double value;
  expect(mfs_create(MFS_FLOAT, 32, &solver) == MFS_OK, "create");
  while (mfs_option_name(options) != NULL) ++options;
  for (; mfs_report_name(figures) != NULL; ++figures)
    expect(mfs_report(solver, mfs_report_name(figures), &value) == MFS_OK, mfs_report_name(figures));
  expect(options == 21 && figures == 41, "21 options, 41 figures");
  expect(mfs_option_name(-1) == NULL && mfs_report_name(-1) == NULL, "no name before the first");
  expect(strcmp(mfs_option_name(0), "backend") == 0 && strchr(mfs_version(), '.') != NULL, "names");
  mfs_destroy(solver);
}

int main(void) {
  const char* text;
  expect(mfs_last_error(&text, NULL, NULL) == MFS_OK && text[0] == '\0', "no error yet");
  solve_real();
  solve_complex();
  refuse();
  list_names();
  if (failures == 0) printf("all is well\n");
  return failures == 0 ? 0 : 1;
}
