!> CHOLMOD of SuiteSparse: supernodal Cholesky for symmetric positive definite matrices. A matrix that is not positive
!> definite sets `indefinite`, so that the caller can change to MUMPS.
!>
!> The equations keep the given order except for a postorder of the elimination tree. The structs of CHOLMOD are
!> accessed in `cholmod_shim.c`. CHOLMOD requests four OpenMP threads in its supernodal loops regardless of the
!> environment, which then wait actively between the loops: a factorisation is therefore run with parallel regions
!> disabled. Its supernodal module is under the GPL (docs/licences.md); a build without SuiteSparse uses
!> `no_suitesparse/absent_solver.f90.in` in place of this file.
module qsmpm_cholmod_solver
  !$ use omp_lib, only: omp_set_max_active_levels, omp_get_max_active_levels
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_null_ptr, c_associated
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_text, only: integer_text
  use qsmpm_linear_solver, only: linear_solver_type, pivot_floor, singular_at, indefinite_at
  implicit none
  private

  public :: make_cholmod_solver

  !> Status values of CHOLMOD (cholmod_core.h).
  integer(c_int), parameter :: status_ok = 0, status_no_memory = -2, status_too_large = -3, &
    status_not_positive = 1

  !> A handle and the pattern numbered from 0.
  type, extends(linear_solver_type) :: cholmod_solver_type
    private
    type(c_ptr) :: handle = c_null_ptr
    integer(c_int), allocatable :: first(:), row(:)
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
    procedure :: release
  end type cholmod_solver_type

  interface
    type(c_ptr) function qsmpm_cholmod_analyse(n, first, row, status) bind(c)
      import :: c_ptr, c_int
      integer(c_int), value :: n
      integer(c_int), intent(in) :: first(*), row(*)
      integer(c_int), intent(out) :: status
    end function qsmpm_cholmod_analyse

    integer(c_int) function qsmpm_cholmod_factorise(handle, n, first, row, values, failed) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: handle
      integer(c_int), value :: n
      integer(c_int), intent(in) :: first(*), row(*)
      real(c_double), intent(in) :: values(*)
      integer(c_int), intent(out) :: failed
    end function qsmpm_cholmod_factorise

    subroutine qsmpm_cholmod_pivots(handle, pivots) bind(c)
      import :: c_ptr, c_double
      type(c_ptr), value :: handle
      real(c_double), intent(out) :: pivots(*)
    end subroutine qsmpm_cholmod_pivots

    real(c_double) function qsmpm_cholmod_factor_size(handle) bind(c)
      import :: c_ptr, c_double
      type(c_ptr), value :: handle
    end function qsmpm_cholmod_factor_size

    real(c_double) function qsmpm_cholmod_operations(handle) bind(c)
      import :: c_ptr, c_double
      type(c_ptr), value :: handle
    end function qsmpm_cholmod_operations

    integer(c_int) function qsmpm_cholmod_solve(handle, n, rhs, x) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: handle
      integer(c_int), value :: n
      real(c_double), intent(in) :: rhs(*)
      real(c_double), intent(out) :: x(*)
    end function qsmpm_cholmod_solve

    subroutine qsmpm_cholmod_free(handle) bind(c)
      import :: c_ptr
      type(c_ptr), value :: handle
    end subroutine qsmpm_cholmod_free
  end interface

contains

  !> Creates a CHOLMOD solver, for symmetric matrices only.
  subroutine make_cholmod_solver(symmetric, solver)
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (cholmod_solver_type :: solver)
    solver%name = 'CHOLMOD'
    solver%symmetric = .true.
  end subroutine make_cholmod_solver

  !> Computes the symbolic factorisation. The rows of a symmetric matrix are its columns.
  subroutine analyse_pattern(self, matrix, error)
    class(cholmod_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer(c_int) :: status

    self%first = matrix%row_first(:matrix%n + 1) - 1
    self%row = matrix%column(:self%first(matrix%n + 1)) - 1
    self%handle = qsmpm_cholmod_analyse(matrix%n, self%first, self%row, status)
    if (.not. c_associated(self%handle)) call library_error(status, error)
  end subroutine analyse_pattern

  !> Computes the numeric factorisation.
  subroutine factorise_values(self, matrix, error)
    class(cholmod_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer(c_int) :: status, failed
    integer :: levels

    levels = 0
    !$ levels = omp_get_max_active_levels()
    !$ call omp_set_max_active_levels(0)
    status = qsmpm_cholmod_factorise(self%handle, matrix%n, self%first, self%row, matrix%values, &
      failed)
    !$ if (levels > 0) call omp_set_max_active_levels(levels)
    if (status == status_not_positive) then
      self%indefinite = .true.
      call indefinite_at(failed + 1, error)
    else if (status < status_ok) then
      call library_error(status, error)
    else
      self%negative_pivots = 0
      self%factor_nonzeros = int(qsmpm_cholmod_factor_size(self%handle), long)
      self%factor_operations = qsmpm_cholmod_operations(self%handle)
      call judge_pivots(self, matrix, error)
    end if
  end subroutine factorise_values

  !> Checks a pivot relative to its diagonal entry.
  subroutine judge_pivots(self, matrix, error)
    class(cholmod_solver_type), intent(in) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: pivots(matrix%n), floor_share
    integer :: i, k

    call qsmpm_cholmod_pivots(self%handle, pivots)
    floor_share = pivot_floor(matrix%n)
    do i = 1, matrix%n
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        if (matrix%column(k) /= i) cycle
        if (pivots(i) > floor_share*matrix%values(k)) exit
        call singular_at(i, error)
        return
      end do
    end do
  end subroutine judge_pivots

  !> Solves by forward and backward substitution.
  subroutine solve_factorised(self, rhs, x, error)
    class(cholmod_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    if (qsmpm_cholmod_solve(self%handle, size(rhs), rhs, x) == 0) then
      call fail(error, error_other, 'CHOLMOD refused to solve')
    end if
  end subroutine solve_factorised

  !> Frees the handle.
  subroutine release(self)
    class(cholmod_solver_type), intent(inout) :: self

    if (c_associated(self%handle)) call qsmpm_cholmod_free(self%handle)
    self%handle = c_null_ptr
  end subroutine release

  !> Converts a failure of the library to an error.
  subroutine library_error(status, error)
    !> Status of CHOLMOD.
    integer(c_int), intent(in) :: status
    type(error_type), allocatable, intent(out) :: error

    select case (status)
    case (status_no_memory)
      call fail(error, error_other, 'CHOLMOD: no memory for the factor')
    case (status_too_large)
      call fail(error, error_other, &
        'CHOLMOD: the factor is too large for 32-bit integers; use MUMPS')
    case default
      call fail(error, error_other, 'CHOLMOD failed with status '//integer_text(int(status)))
    end select
  end subroutine library_error
end module qsmpm_cholmod_solver
