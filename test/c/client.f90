! A program of Fortran that knows the module mfs only: a right input and wrong ones.
program client
  use, intrinsic :: iso_c_binding
  use mfs
  implicit none
  integer :: failures = 0
  integer(c_int32_t) :: offsets(4) = [1, 3, 6, 8], columns(7) = [1, 2, 1, 2, 3, 2, 3]

  call solve_real()
  call solve_complex()
  call refuse()
  if (failures > 0) error stop 1
  print '(a)', "all is well"

contains

  subroutine expect(good, what)
    logical, intent(in) :: good
    character(len=*), intent(in) :: what
    character(len=:), allocatable :: text
    integer :: status
    if (good) return
    status = mfs_last_error(text)
    print '(4a,i0)', "failed: ", what, "; last error: ", text, status
    failures = failures + 1
  end subroutine expect

  subroutine expect_error(status, expected, row, column, part)
    integer, intent(in) :: status, expected, row, column
    character(len=*), intent(in) :: part
    character(len=:), allocatable :: text
    integer(c_int64_t) :: r, c
    integer :: last
    last = mfs_last_error(text, r, c)
    if (status == expected .and. last == expected .and. r == row .and. c == column .and. index(text, part) > 0) return
    print '(a,4(i0,1x),4a)', "failed: ", status, last, r, c, text, " instead of '", part, "'"
    failures = failures + 1
  end subroutine expect_error

  subroutine solve_real()
    type(mfs_solver) :: solver
    real(c_double) :: values(7) = [4, -1, -1, 4, -1, -1, 4], b(3) = [3, 2, 3], x(3), many(4, 2), log_abs, figure
    complex(c_double_complex) :: phase
    call expect(mfs_create(MFS_DOUBLE, 32, solver) == MFS_OK, "create")
    call expect(mfs_set_option(solver, "threads ", "1") == MFS_OK, "threads")
    call expect(mfs_analyze(solver, offsets - 1, columns - 1) == MFS_OK, "analyze")
    call expect(mfs_factor(solver, offsets - 1, columns - 1, values) == MFS_OK, "factor")
    call expect(mfs_solve(solver, b, x) == MFS_OK, "solve")
    call expect(all(abs(x - 1) < 1e-14), "solution")
    many(1:3, 1) = b
    many(1:3, 2) = 2*b
    many(4, :) = -7
    call expect(mfs_solve_transpose(solver, many, many) == MFS_OK, "many columns in place")
    call expect(all(abs(many(1:3, 1) - 1) < 1e-14) .and. all(abs(many(1:3, 2) - 2) < 1e-14), "their solutions")
    call expect(all(many(4, :) == -7), "the row below is left alone")
    call expect(mfs_solve(solver, 2*b, many(2:4, 2)) == MFS_OK, "an expression, and a section")
    call expect(all(abs(many(2:4, 2) - 2) < 1e-13) .and. all(abs(many(1:3, 1) - 1) < 1e-14), "its solution")
    call expect(mfs_determinant(solver, phase, log_abs) == MFS_OK, "determinant")
    call expect(abs(phase*exp(log_abs) - 56) < 1e-12, "determinant is 56")
    values(1) = 5
    call expect(mfs_refactor(solver, values) == MFS_OK, "refactor")
    call expect(mfs_condition_estimate(solver, figure) == MFS_OK, "condition")
    call expect(abs(figure - 2) < 1, "condition is about 2")
    call expect(mfs_report(solver, "nnz", figure) == MFS_OK, "report")
    call expect(nint(figure) == 7, "7 entries")
    call expect(index(mfs_version(), ".") > 0, "version")
    call mfs_destroy(solver)
    call mfs_destroy(solver)
  end subroutine solve_real

  ! (1 i; 0 2), 64-bit indices, single precision
  subroutine solve_complex()
    type(mfs_solver) :: solver
    complex(c_float_complex) :: values(3) = [(1, 0), (0, 1), (2, 0)], b(2) = [(1, 1), (2, 0)], x(2)
    integer(c_int64_t) :: wide_offsets(3) = [0, 2, 3], wide_columns(3) = [0, 1, 1]
    call expect(mfs_create(MFS_COMPLEX_FLOAT, 64, solver) == MFS_OK, "create")
    call expect(mfs_factor(solver, wide_offsets, wide_columns, values) == MFS_OK, "factor")
    call expect(mfs_solve_transpose(solver, b, x) == MFS_OK, "solve transposed")
    call expect(abs(x(1) - (1, 1)) + abs(x(2) - (1.5, -0.5)) < 1e-6, "solution")
    call mfs_destroy(solver)
  end subroutine solve_complex

  subroutine refuse()
    type(mfs_solver) :: solver
    real(c_double) :: values(7) = [4, -1, -1, 4, -1, -1, 4], b(3) = [3, 2, 3], x(3) = 7, many(3, 2), apart(14) = -7, two(4, 2)
    real(c_float) :: short(7) = 1
    integer(c_int32_t) :: wrong(7)
    call expect_error(mfs_factor(solver, offsets - 1, columns - 1, values), MFS_INVALID_INPUT, -1, -1, "not been created")
    call expect_error(mfs_solve(solver, b, x), MFS_INVALID_INPUT, -1, -1, "not been created")
    call expect_error(mfs_create(MFS_DOUBLE, 31, solver), MFS_INVALID_INPUT, -1, -1, "not 32 or 64")
    call expect(mfs_create(MFS_DOUBLE, 32, solver) == MFS_OK, "create")
    call expect_error(mfs_set_option(solver, "backend", "abacus"), MFS_INVALID_INPUT, -1, -1, "abacus")
    call expect_error(mfs_solve(solver, b, x), MFS_STATE_ERROR, -1, -1, "nothing has been factored")
    call expect_error(mfs_factor(solver, offsets - 1, columns - 1, short), MFS_INVALID_INPUT, -1, -1, "another kind")
    call expect_error(mfs_factor(solver, int(offsets - 1, c_int64_t), columns - 1, values), MFS_INVALID_INPUT, -1, -1, &
                      "offsets are of another kind")
    call expect_error(mfs_factor(solver, offsets, columns, values), MFS_INVALID_INPUT, -1, -1, "columns are not as many")
    call expect_error(mfs_factor(solver, offsets - 1, columns, values), MFS_INVALID_INPUT, 1, 3, "")
    call expect_error(mfs_factor(solver, offsets - 1, columns - 1, values(1:6)), MFS_INVALID_INPUT, -1, -1, "fewer")
    wrong = columns - 1
    wrong(2) = 2
    call expect(mfs_factor(solver, offsets - 1, columns - 1, values) == MFS_OK, "factor")
    call expect_error(mfs_factor(solver, offsets - 1, wrong, values), MFS_PATTERN_CHANGED, 0, -1, "")
    call expect_error(mfs_refactor(solver, values(1:3)), MFS_INVALID_INPUT, -1, -1, "fewer")
    call expect_error(mfs_solve(solver, b(1:2), x), MFS_INVALID_INPUT, -1, -1, "need as many rows")
    call expect_error(mfs_solve(solver, reshape(b, [3, 1]), many), MFS_INVALID_INPUT, -1, -1, "number of columns")
    call expect_error(mfs_solve(solver, b, apart(1:5:2)), MFS_INVALID_INPUT, -1, -1, "not contiguous")
    call expect_error(mfs_solve(solver, apart(6:1:-1), b), MFS_INVALID_INPUT, -1, -1, "not contiguous")
    call expect_error(mfs_solve(solver, two(1:3, :), two), MFS_INVALID_INPUT, -1, -1, "not contiguous")
    call expect_error(mfs_refactor(solver, apart(1:13:2)), MFS_INVALID_INPUT, -1, -1, "not contiguous")
    call expect(all(apart == -7), "nothing is written")
    call expect_error(mfs_refactor_device(solver, c_null_ptr, c_null_ptr), MFS_INVALID_INPUT, -1, -1, "values: is NULL")
    call expect_error(mfs_set_default_threads(-1), MFS_INVALID_INPUT, -1, -1, "")
    call expect(mfs_solve(solver, b, x) == MFS_OK, "good again")
    call expect(all(abs(x - 1) < 1e-14), "and right")
    call mfs_destroy(solver)
  end subroutine refuse
end program client
