! MFS for Fortran: the functions of mfs/mfs.h, which tells what each does and which statuses it returns. The
! compiler makes the module mfs of this file; with CMake, link the target mfs::fortran.
!
!   type(mfs_solver) :: solver
!   integer :: status
!   status = mfs_create(MFS_DOUBLE, 32, solver)              ! real(c_double), integer(c_int32_t)
!   status = mfs_set_option(solver, "threads", "4")
!   status = mfs_factor(solver, offsets - 1, columns - 1, values)
!   status = mfs_solve(solver, b, x)                         ! b(n), x(n), or b(n, k), x(n, k)
!   status = mfs_refactor(solver, values)
!   call mfs_destroy(solver)
!
! Offsets and columns count from 0, and so do rows and columns of errors. Arrays of other kinds than those
! that the solver was made for are refused with MFS_INVALID_INPUT, and so are arrays that are too short, and
! sections of arrays whose elements are no neighbours.
module mfs
  use, intrinsic :: iso_c_binding
  implicit none
  private

  integer, parameter, public :: MFS_FLOAT = 0, MFS_DOUBLE = 1, MFS_COMPLEX_FLOAT = 2, MFS_COMPLEX_DOUBLE = 3
  integer, parameter, public :: MFS_OK = 0, MFS_INVALID_INPUT = 3, MFS_SINGULAR_MATRIX = 4, &
    MFS_OUT_OF_MEMORY = 5, MFS_ACCURACY_NOT_REACHED = 6, MFS_BACKEND_ERROR = 7, MFS_STATE_ERROR = 8, &
    MFS_PATTERN_CHANGED = 9, MFS_INTERNAL_ERROR = 10

  type, public :: mfs_solver
    private
    type(c_ptr) :: handle = c_null_ptr
    integer :: scalar = -1, index_bits = 0
    integer(c_int64_t) :: n = -1, nnz = -1
  end type mfs_solver

  public :: mfs_create, mfs_destroy, mfs_set_option, mfs_last_error, mfs_analyze, mfs_factor, mfs_refactor, &
    mfs_solve, mfs_solve_transpose, mfs_refactor_device, mfs_solve_device, mfs_solve_transpose_device, &
    mfs_condition_estimate, mfs_determinant, mfs_report, mfs_version, mfs_set_default_threads

  type :: numbers
    type(c_ptr) :: address = c_null_ptr
    integer :: scalar = -1
    integer(c_int64_t) :: rows = 0, columns = 0
    logical :: dense = .false.
  end type numbers

  interface mfs_solve
    module procedure solve_vector, solve_columns
  end interface mfs_solve
  interface mfs_solve_transpose
    module procedure solve_transpose_vector, solve_transpose_columns
  end interface mfs_solve_transpose

  interface
    integer(c_int) function c_create(scalar, index_bits, solver) bind(C, name="mfs_create")
      import :: c_int, c_ptr
      integer(c_int), value :: scalar, index_bits
      type(c_ptr), intent(out) :: solver
    end function c_create
    subroutine c_destroy(solver) bind(C, name="mfs_destroy")
      import :: c_ptr
      type(c_ptr), value :: solver
    end subroutine c_destroy
    integer(c_int) function c_set_option(solver, name, text) bind(C, name="mfs_set_option")
      import :: c_int, c_ptr, c_char
      type(c_ptr), value :: solver
      character(kind=c_char), intent(in) :: name(*), text(*)
    end function c_set_option
    integer(c_int) function c_last_error(text, row, column) bind(C, name="mfs_last_error")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), intent(out) :: text
      integer(c_int64_t), intent(out) :: row, column
    end function c_last_error
    integer(c_int) function c_analyze(solver, n, offsets, columns, values) bind(C, name="mfs_analyze")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: solver, offsets, columns, values
      integer(c_int64_t), value :: n
    end function c_analyze
    integer(c_int) function c_factor(solver, n, offsets, columns, values) bind(C, name="mfs_factor")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: solver, offsets, columns, values
      integer(c_int64_t), value :: n
    end function c_factor
    integer(c_int) function c_refactor(solver, values) bind(C, name="mfs_refactor")
      import :: c_int, c_ptr
      type(c_ptr), value :: solver, values
    end function c_refactor
    integer(c_int) function c_solve(solver, b, x, columns, ldb, ldx) bind(C, name="mfs_solve")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: solver, b, x
      integer(c_int64_t), value :: columns, ldb, ldx
    end function c_solve
    integer(c_int) function c_solve_transpose(solver, b, x, columns, ldb, ldx) bind(C, name="mfs_solve_transpose")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: solver, b, x
      integer(c_int64_t), value :: columns, ldb, ldx
    end function c_solve_transpose
    integer(c_int) function c_refactor_device(solver, values, stream) bind(C, name="mfs_refactor_device")
      import :: c_int, c_ptr
      type(c_ptr), value :: solver, values, stream
    end function c_refactor_device
    integer(c_int) function c_solve_device(solver, b, x, columns, ldb, ldx, stream) bind(C, name="mfs_solve_device")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: solver, b, x, stream
      integer(c_int64_t), value :: columns, ldb, ldx
    end function c_solve_device
    integer(c_int) function c_solve_transpose_device(solver, b, x, columns, ldb, ldx, stream) &
      bind(C, name="mfs_solve_transpose_device")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: solver, b, x, stream
      integer(c_int64_t), value :: columns, ldb, ldx
    end function c_solve_transpose_device
    integer(c_int) function c_condition_estimate(solver, condition) bind(C, name="mfs_condition_estimate")
      import :: c_int, c_ptr, c_double
      type(c_ptr), value :: solver
      real(c_double), intent(inout) :: condition
    end function c_condition_estimate
    integer(c_int) function c_determinant(solver, phase, log_abs) bind(C, name="mfs_determinant")
      import :: c_int, c_ptr, c_double, c_double_complex
      type(c_ptr), value :: solver
      complex(c_double_complex), intent(inout) :: phase
      real(c_double), intent(inout) :: log_abs
    end function c_determinant
    integer(c_int) function c_report(solver, name, number) bind(C, name="mfs_report")
      import :: c_int, c_ptr, c_char, c_double
      type(c_ptr), value :: solver
      character(kind=c_char), intent(in) :: name(*)
      real(c_double), intent(inout) :: number
    end function c_report
    type(c_ptr) function c_version() bind(C, name="mfs_version")
      import :: c_ptr
    end function c_version
    integer(c_int) function c_set_default_threads(threads) bind(C, name="mfs_set_default_threads")
      import :: c_int
      integer(c_int), value :: threads
    end function c_set_default_threads
    integer(c_size_t) function c_strlen(text) bind(C, name="strlen")
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function c_strlen
  end interface

  ! The last error, where it was found here.
  logical, save :: found_here = .false.
  character(len=80), save :: text_here = ""
  !$omp threadprivate(found_here, text_here)

contains

  !> `scalar` is one of MFS_FLOAT ..., `index_bits` 32 or 64.
  integer function mfs_create(scalar, index_bits, solver) result(status)
    integer, intent(in) :: scalar, index_bits
    type(mfs_solver), intent(inout) :: solver
    call mfs_destroy(solver)
    status = from_c(c_create(int(scalar, c_int), int(index_bits, c_int), solver%handle))
    solver%scalar = scalar
    solver%index_bits = index_bits
  end function mfs_create

  subroutine mfs_destroy(solver)
    type(mfs_solver), intent(inout) :: solver
    call c_destroy(solver%handle)
    solver%handle = c_null_ptr
    solver%n = -1
    solver%nnz = -1
  end subroutine mfs_destroy

  integer function mfs_set_option(solver, name, text) result(status)
    type(mfs_solver), intent(in) :: solver
    character(len=*), intent(in) :: name, text
    status = from_c(c_set_option(solver%handle, trim(name)//c_null_char, trim(text)//c_null_char))
  end function mfs_set_option

  !> The status of the last error of this thread, its text, and its place from 0 (-1: none).
  integer function mfs_last_error(text, row, column) result(status)
    character(len=:), allocatable, intent(out), optional :: text
    integer(c_int64_t), intent(out), optional :: row, column
    type(c_ptr) :: words
    integer(c_int64_t) :: r, c
    status = c_last_error(words, r, c)
    if (found_here) then
      status = MFS_INVALID_INPUT
      r = -1
      c = -1
    end if
    if (present(text)) then
      if (found_here) then
        text = trim(text_here)
      else
        text = string_of(words)
      end if
    end if
    if (present(row)) row = r
    if (present(column)) column = c
  end function mfs_last_error

  !> offsets(n + 1), columns(nnz), and values(nnz) or none: the pattern alone.
  integer function mfs_analyze(solver, offsets, columns, values) result(status)
    type(mfs_solver), intent(inout) :: solver
    class(*), intent(in), target :: offsets(:), columns(:)
    class(*), intent(in), target, optional :: values(:)
    type(c_ptr) :: o, c, v
    status = rows_of(solver, offsets, columns, o, c)
    v = c_null_ptr
    if (status == MFS_OK .and. present(values)) status = values_of(solver, values, size(columns, kind=c_int64_t), v)
    if (status /= MFS_OK) return
    status = from_c(c_analyze(solver%handle, size(offsets, kind=c_int64_t) - 1, o, c, v))
    call remember(solver, status, size(offsets, kind=c_int64_t) - 1, size(columns, kind=c_int64_t))
  end function mfs_analyze

  integer function mfs_factor(solver, offsets, columns, values) result(status)
    type(mfs_solver), intent(inout) :: solver
    class(*), intent(in), target :: offsets(:), columns(:), values(:)
    type(c_ptr) :: o, c, v
    status = rows_of(solver, offsets, columns, o, c)
    if (status == MFS_OK) status = values_of(solver, values, size(columns, kind=c_int64_t), v)
    if (status /= MFS_OK) return
    status = from_c(c_factor(solver%handle, size(offsets, kind=c_int64_t) - 1, o, c, v))
    call remember(solver, status, size(offsets, kind=c_int64_t) - 1, size(columns, kind=c_int64_t))
  end function mfs_factor

  integer function mfs_refactor(solver, values) result(status)
    type(mfs_solver), intent(in) :: solver
    class(*), intent(in), target :: values(:)
    type(c_ptr) :: v
    status = values_of(solver, values, solver%nnz, v)
    if (status == MFS_OK) status = from_c(c_refactor(solver%handle, v))
  end function mfs_refactor

  integer function solve_vector(solver, b, x) result(status)
    type(mfs_solver), intent(in) :: solver
    class(*), intent(in), target :: b(:)
    class(*), intent(inout), target :: x(:)
    status = solve_any(solver, vector_of(b), vector_of(x), .false.)
  end function solve_vector

  integer function solve_transpose_vector(solver, b, x) result(status)
    type(mfs_solver), intent(in) :: solver
    class(*), intent(in), target :: b(:)
    class(*), intent(inout), target :: x(:)
    status = solve_any(solver, vector_of(b), vector_of(x), .true.)
  end function solve_transpose_vector

  integer function solve_columns(solver, b, x) result(status)
    type(mfs_solver), intent(in) :: solver
    class(*), intent(in), target :: b(:, :)
    class(*), intent(inout), target :: x(:, :)
    status = solve_any(solver, matrix_of(b), matrix_of(x), .false.)
  end function solve_columns

  integer function solve_transpose_columns(solver, b, x) result(status)
    type(mfs_solver), intent(in) :: solver
    class(*), intent(in), target :: b(:, :)
    class(*), intent(inout), target :: x(:, :)
    status = solve_any(solver, matrix_of(b), matrix_of(x), .true.)
  end function solve_transpose_columns

  !> `values`, `b` and `x` are addresses on the device, `stream` a stream of CUDA or c_null_ptr. After an analysis of
  !> values this may be the first factorization.
  integer function mfs_refactor_device(solver, values, stream) result(status)
    type(mfs_solver), intent(in) :: solver
    type(c_ptr), intent(in) :: values, stream
    status = from_c(c_refactor_device(solver%handle, values, stream))
  end function mfs_refactor_device

  integer function mfs_solve_device(solver, b, x, columns, ldb, ldx, stream) result(status)
    type(mfs_solver), intent(in) :: solver
    type(c_ptr), intent(in) :: b, x, stream
    integer(c_int64_t), intent(in) :: columns, ldb, ldx
    status = from_c(c_solve_device(solver%handle, b, x, columns, ldb, ldx, stream))
  end function mfs_solve_device

  integer function mfs_solve_transpose_device(solver, b, x, columns, ldb, ldx, stream) result(status)
    type(mfs_solver), intent(in) :: solver
    type(c_ptr), intent(in) :: b, x, stream
    integer(c_int64_t), intent(in) :: columns, ldb, ldx
    status = from_c(c_solve_transpose_device(solver%handle, b, x, columns, ldb, ldx, stream))
  end function mfs_solve_transpose_device

  integer function mfs_condition_estimate(solver, condition) result(status)
    type(mfs_solver), intent(in) :: solver
    real(c_double), intent(inout) :: condition
    status = from_c(c_condition_estimate(solver%handle, condition))
  end function mfs_condition_estimate

  !> phase * exp(log_abs)
  integer function mfs_determinant(solver, phase, log_abs) result(status)
    type(mfs_solver), intent(in) :: solver
    complex(c_double_complex), intent(inout) :: phase
    real(c_double), intent(inout) :: log_abs
    status = from_c(c_determinant(solver%handle, phase, log_abs))
  end function mfs_determinant

  integer function mfs_report(solver, name, number) result(status)
    type(mfs_solver), intent(in) :: solver
    character(len=*), intent(in) :: name
    real(c_double), intent(inout) :: number
    status = from_c(c_report(solver%handle, trim(name)//c_null_char, number))
  end function mfs_report

  function mfs_version() result(text)
    character(len=:), allocatable :: text
    text = string_of(c_version())
  end function mfs_version

  integer function mfs_set_default_threads(threads) result(status)
    integer, intent(in) :: threads
    status = from_c(c_set_default_threads(int(threads, c_int)))
  end function mfs_set_default_threads

  ! ---- what the functions above have in common ----

  !> A status of C, whose error then is the last one.
  integer function from_c(status_of_c) result(status)
    integer(c_int), intent(in) :: status_of_c
    status = status_of_c
    if (status /= MFS_OK) found_here = .false.
  end function from_c

  integer function refused(name, what) result(status)
    character(len=*), intent(in) :: name, what
    found_here = .true.
    text_here = name//what
    status = MFS_INVALID_INPUT
  end function refused

  integer function refused_kind(solver, name) result(status)
    type(mfs_solver), intent(in) :: solver
    character(len=*), intent(in) :: name
    if (c_associated(solver%handle)) then
      status = refused(name, " are of another kind than the solver's")
    else
      status = refused("solver", " has not been created")
    end if
  end function refused_kind

  subroutine remember(solver, status, n, nnz)
    type(mfs_solver), intent(inout) :: solver
    integer, intent(in) :: status
    integer(c_int64_t), intent(in) :: n, nnz
    if (status /= MFS_OK .and. status /= MFS_SINGULAR_MATRIX) return
    solver%n = n
    solver%nnz = nnz
  end subroutine remember

  !> `a` where it lies; of a kind that is none of the four, scalar is -1. (Dummy arguments that are class(*) and
  !> contiguous would be simpler, but gfortran 12 passes every second element of an array to them as if they were
  !> neighbours.)
  function vector_of(a) result(found)
    class(*), intent(in), target :: a(:)
    type(numbers) :: found
    found%rows = size(a, kind=c_int64_t)
    found%columns = 1
    select type (a)
    type is (real(c_float))
      found%scalar = MFS_FLOAT
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    type is (real(c_double))
      found%scalar = MFS_DOUBLE
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    type is (complex(c_float_complex))
      found%scalar = MFS_COMPLEX_FLOAT
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    type is (complex(c_double_complex))
      found%scalar = MFS_COMPLEX_DOUBLE
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    end select
  end function vector_of

  function matrix_of(a) result(found)
    class(*), intent(in), target :: a(:, :)
    type(numbers) :: found
    found%rows = size(a, 1, kind=c_int64_t)
    found%columns = size(a, 2, kind=c_int64_t)
    select type (a)
    type is (real(c_float))
      found%scalar = MFS_FLOAT
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    type is (real(c_double))
      found%scalar = MFS_DOUBLE
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    type is (complex(c_float_complex))
      found%scalar = MFS_COMPLEX_FLOAT
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    type is (complex(c_double_complex))
      found%scalar = MFS_COMPLEX_DOUBLE
      found%address = c_loc(a)
      found%dense = is_contiguous(a)
    end select
  end function matrix_of

  integer function values_of(solver, values, nnz, address) result(status)
    type(mfs_solver), intent(in) :: solver
    class(*), intent(in), target :: values(:)
    integer(c_int64_t), intent(in) :: nnz
    type(c_ptr), intent(out) :: address
    type(numbers) :: found
    found = vector_of(values)
    address = found%address
    status = MFS_OK
    if (found%scalar /= solver%scalar) then
      status = refused_kind(solver, "values")
    else if (.not. found%dense) then
      status = refused("values", " are not contiguous")
    else if (nnz >= 0 .and. found%rows < nnz) then
      status = refused("values", " are fewer than the matrix has entries")
    end if
  end function values_of

  integer function indices_of(solver, name, indices, address) result(status)
    type(mfs_solver), intent(in) :: solver
    character(len=*), intent(in) :: name
    class(*), intent(in), target :: indices(:)
    type(c_ptr), intent(out) :: address
    integer :: bits
    logical :: dense
    bits = 0
    dense = .false.
    address = c_null_ptr
    select type (indices)
    type is (integer(c_int32_t))
      bits = 32
      address = c_loc(indices)
      dense = is_contiguous(indices)
    type is (integer(c_int64_t))
      bits = 64
      address = c_loc(indices)
      dense = is_contiguous(indices)
    end select
    status = MFS_OK
    if (bits /= solver%index_bits) then
      status = refused_kind(solver, name)
    else if (.not. dense) then
      status = refused(name, " are not contiguous")
    end if
  end function indices_of

  integer function rows_of(solver, offsets, columns, offsets_at, columns_at) result(status)
    type(mfs_solver), intent(in) :: solver
    class(*), intent(in), target :: offsets(:), columns(:)
    type(c_ptr), intent(out) :: offsets_at, columns_at
    integer(c_int64_t) :: nnz
    columns_at = c_null_ptr
    status = indices_of(solver, "offsets", offsets, offsets_at)
    if (status == MFS_OK) status = indices_of(solver, "columns", columns, columns_at)
    if (status /= MFS_OK) return
    nnz = -1
    if (size(offsets) > 0) then
      select type (offsets)
      type is (integer(c_int32_t))
        nnz = offsets(size(offsets))
      type is (integer(c_int64_t))
        nnz = offsets(size(offsets))
      end select
    end if
    if (nnz /= size(columns, kind=c_int64_t)) &
      status = refused("columns", " are not as many as the last of the offsets says")
  end function rows_of

  integer function solve_any(solver, b, x, transposed) result(status)
    type(mfs_solver), intent(in) :: solver
    type(numbers), intent(in) :: b, x
    logical, intent(in) :: transposed
    if (b%scalar /= solver%scalar .or. x%scalar /= solver%scalar) then
      status = refused_kind(solver, "b and x")
    else if (.not. (b%dense .and. x%dense)) then
      status = refused("b and x", " are not contiguous")
    else if (b%columns /= x%columns) then
      status = refused("x", " has another number of columns than b")
    else if (min(b%rows, x%rows) < solver%n) then
      status = refused("b and x", " need as many rows as the matrix")
    else if (transposed) then
      status = from_c(c_solve_transpose(solver%handle, b%address, x%address, b%columns, b%rows, x%rows))
    else
      status = from_c(c_solve(solver%handle, b%address, x%address, b%columns, b%rows, x%rows))
    end if
  end function solve_any

  function string_of(text) result(string)
    type(c_ptr), intent(in) :: text
    character(len=:), allocatable :: string
    character(kind=c_char), pointer :: letters(:)
    integer :: i
    call c_f_pointer(text, letters, [c_strlen(text)])
    allocate (character(len=size(letters)) :: string)
    do i = 1, size(letters)
      string(i:i) = letters(i)
    end do
  end function string_of
end module mfs
