! The example of the README in Fortran.
program solve_tiny
  use mfs
  implicit none
  type(mfs_solver) :: solver
  integer :: offsets(4) = [1, 3, 6, 8], columns(7) = [1, 2, 1, 2, 3, 2, 3]
  double precision :: values(7) = [4, -1, -1, 4, -1, -1, 4], b(3) = [3, 2, 3], x(3) = 0
  if (mfs_create(MFS_DOUBLE, 32, solver) /= MFS_OK) error stop 1
  if (mfs_factor(solver, offsets - 1, columns - 1, values) /= MFS_OK) error stop 2
  if (mfs_solve(solver, b, x) /= MFS_OK) error stop 3
  print *, "x =", x
  if (any(abs(x - 1) > 1d-14)) error stop 4
  if (mfs_refactor(solver, values(1:3)) /= MFS_INVALID_INPUT) error stop 5
  call mfs_destroy(solver)
end program solve_tiny
