!> UMFPACK of SuiteSparse: multifrontal LU of unsymmetric matrices.
!>
!> UMFPACK works on columns, and the compressed rows of K are the columns of its transpose: the transpose is factorised
!> and the transposed system solved. The column order is given (the identity) and the strategy is symmetric, which
!> keeps the order except for a postorder of the elimination tree and uses diagonal pivots; a row is exchanged only if
!> a diagonal entry is below a thousandth of the largest of its column. Solutions are refined by up to two sweeps.
!> UMFPACK is under the GPL (docs/licences.md); a build without SuiteSparse uses `no_suitesparse/absent_solver.f90.in`
!> in place of this file.
module qsmpm_umfpack_solver
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_null_ptr, c_associated
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_other, error_singular
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_text, only: integer_text
  use qsmpm_linear_solver, only: linear_solver_type, pivot_floor, singular_at
  implicit none
  private

  public :: make_umfpack_solver

  !> Sizes, positions (from 1) and values of umfpack.h.
  integer, parameter :: control_size = 20, info_size = 90
  integer, parameter :: place_strategy = 6, place_singletons = 12
  integer, parameter :: place_flops = 43, place_lnz = 44, place_unz = 45
  real(c_double), parameter :: strategy_symmetric = 3.0_c_double
  integer(c_int), parameter :: status_ok = 0, status_singular = 1, status_no_memory = -1
  integer(c_int), parameter :: solve_transposed = 1

  !> The handles, the pattern numbered from 0, and the values, which a refined solution reads again.
  type, extends(linear_solver_type) :: umfpack_solver_type
    private
    type(c_ptr) :: symbolic = c_null_ptr, numeric = c_null_ptr
    real(c_double) :: control(control_size) = 0.0_c_double
    integer(c_int), allocatable :: first(:), row(:)
    real(wp), allocatable :: values(:)
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
    procedure :: release
  end type umfpack_solver_type

  interface
    subroutine umfpack_di_defaults(control) bind(c)
      import :: c_double
      real(c_double), intent(out) :: control(*)
    end subroutine umfpack_di_defaults

    integer(c_int) function umfpack_di_qsymbolic(rows, columns, first, row, values, order, symbolic, control, info) &
      bind(c)
      import :: c_ptr, c_int, c_double
      integer(c_int), value :: rows, columns
      integer(c_int), intent(in) :: first(*), row(*), order(*)
      type(c_ptr), value :: values
      type(c_ptr), intent(out) :: symbolic
      real(c_double), intent(in) :: control(*)
      real(c_double), intent(out) :: info(*)
    end function umfpack_di_qsymbolic

    integer(c_int) function umfpack_di_numeric(first, row, values, symbolic, numeric, control, info) bind(c)
      import :: c_ptr, c_int, c_double
      integer(c_int), intent(in) :: first(*), row(*)
      real(c_double), intent(in) :: values(*), control(*)
      type(c_ptr), value :: symbolic
      type(c_ptr), intent(out) :: numeric
      real(c_double), intent(out) :: info(*)
    end function umfpack_di_numeric

    integer(c_int) function umfpack_di_solve(system, first, row, values, x, rhs, numeric, control, &
        info) bind(c)
      import :: c_ptr, c_int, c_double
      integer(c_int), value :: system
      integer(c_int), intent(in) :: first(*), row(*)
      real(c_double), intent(in) :: values(*), rhs(*), control(*)
      real(c_double), intent(out) :: x(*), info(*)
      type(c_ptr), value :: numeric
    end function umfpack_di_solve

    !> Null pointers are passed for the parts of the factors that are not required.
    integer(c_int) function umfpack_di_get_numeric(lp, lj, lx, up, ui, ux, row_order, column_order, pivots, &
      reciprocal, scales, numeric) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: lp, lj, lx, up, ui, ux, row_order
      integer(c_int), intent(out) :: column_order(*), reciprocal
      real(c_double), intent(out) :: pivots(*), scales(*)
      type(c_ptr), value :: numeric
    end function umfpack_di_get_numeric

    subroutine umfpack_di_free_symbolic(symbolic) bind(c)
      import :: c_ptr
      type(c_ptr), intent(inout) :: symbolic
    end subroutine umfpack_di_free_symbolic

    subroutine umfpack_di_free_numeric(numeric) bind(c)
      import :: c_ptr
      type(c_ptr), intent(inout) :: numeric
    end subroutine umfpack_di_free_numeric
  end interface

contains

  !> Creates an UMFPACK solver; symmetric matrices are treated as any other.
  subroutine make_umfpack_solver(symmetric, solver)
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (umfpack_solver_type :: solver)
    solver%name = 'UMFPACK'
    solver%symmetric = .false.
  end subroutine make_umfpack_solver

  !> Computes the symbolic factorisation in the given order.
  subroutine analyse_pattern(self, matrix, error)
    class(umfpack_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    real(c_double) :: info(info_size)
    integer(c_int) :: status
    integer :: i

    call umfpack_di_defaults(self%control)
    self%control(place_strategy) = strategy_symmetric
    self%control(place_singletons) = 0.0_c_double
    self%first = matrix%row_first(:matrix%n + 1) - 1
    self%row = matrix%column(:self%first(matrix%n + 1)) - 1
    status = umfpack_di_qsymbolic(matrix%n, matrix%n, self%first, self%row, c_null_ptr, &
      [(int(i - 1, c_int), i=1, matrix%n)], self%symbolic, self%control, info)
    if (status /= status_ok) call library_error(status, error)
  end subroutine analyse_pattern

  !> Computes the numeric factorisation.
  subroutine factorise_values(self, matrix, error)
    class(umfpack_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    real(c_double) :: info(info_size)
    integer(c_int) :: status

    if (c_associated(self%numeric)) call umfpack_di_free_numeric(self%numeric)
    self%values = matrix%values(:size(self%row))
    status = umfpack_di_numeric(self%first, self%row, self%values, self%symbolic, self%numeric, &
      self%control, info)
    if (status < status_ok) then
      call library_error(status, error)
      return
    end if
    self%factor_nonzeros = int(info(place_lnz) + info(place_unz), long)
    self%factor_operations = info(place_flops)
    call judge_pivots(self, matrix%n, error)
    if (status == status_singular .and. .not. allocated(error)) then
      call fail(error, error_singular, 'the matrix is singular: UMFPACK found a zero pivot')
    end if
  end subroutine factorise_values

  !> Checks a pivot relative to the largest entry of its column in the scaled matrix. A column of the matrix passed to
  !> UMFPACK is an equation here.
  subroutine judge_pivots(self, n, error)
    class(umfpack_solver_type), intent(in) :: self
    !> Number of equations.
    integer, intent(in) :: n
    type(error_type), allocatable, intent(out) :: error

    integer(c_int) :: column_order(n), reciprocal, status
    real(c_double) :: pivots(n), scales(n)
    real(wp) :: largest, floor_share
    integer :: j, k

    status = umfpack_di_get_numeric(c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, &
      c_null_ptr, c_null_ptr, column_order, pivots, reciprocal, scales, self%numeric)
    if (status /= status_ok) then
      call library_error(status, error)
      return
    end if
    if (reciprocal == 0) scales = 1.0_wp/scales
    floor_share = pivot_floor(n)
    do k = 1, n
      j = column_order(k) + 1
      associate (first => self%first(j) + 1, last => self%first(j + 1))
        largest = maxval(abs(self%values(first:last))*scales(self%row(first:last) + 1))
      end associate
      if (abs(pivots(k)) > floor_share*largest) cycle
      call singular_at(j, error)
      return
    end do
  end subroutine judge_pivots

  !> Solves by forward and backward substitution with refinement.
  subroutine solve_factorised(self, rhs, x, error)
    class(umfpack_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    real(c_double) :: info(info_size)
    integer(c_int) :: status

    status = umfpack_di_solve(solve_transposed, self%first, self%row, self%values, x, rhs, &
      self%numeric, self%control, info)
    if (status /= status_ok) call library_error(status, error)
  end subroutine solve_factorised

  !> Frees the handles.
  subroutine release(self)
    class(umfpack_solver_type), intent(inout) :: self

    if (c_associated(self%numeric)) call umfpack_di_free_numeric(self%numeric)
    if (c_associated(self%symbolic)) call umfpack_di_free_symbolic(self%symbolic)
    self%numeric = c_null_ptr
    self%symbolic = c_null_ptr
  end subroutine release

  !> Converts a failure of the library to an error.
  subroutine library_error(status, error)
    !> Status of UMFPACK.
    integer(c_int), intent(in) :: status
    type(error_type), allocatable, intent(out) :: error

    if (status == status_no_memory) then
      call fail(error, error_other, 'UMFPACK: no memory for the factors')
    else
      call fail(error, error_other, 'UMFPACK failed with status '//integer_text(int(status)))
    end if
  end subroutine library_error
end module qsmpm_umfpack_solver
