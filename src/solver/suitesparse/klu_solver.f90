!> KLU of SuiteSparse: LU of unsymmetric matrices by left-looking columns, without blocks.
!>
!> KLU works on columns, and the compressed rows of K are the columns of its transpose: the transpose is factorised
!> and the transposed system solved. Rows are scaled by their largest value. The order is given (the identity) and
!> kept, but for rows that are exchanged where a diagonal entry falls below a thousandth of the largest of its column.
!> The records of KLU are mirrored from klu.h of version 1.3; other settings than its defaults show another layout.
!> KLU is under the LGPL, but it comes with SuiteSparse.
module qsmpm_klu_solver
  use, intrinsic :: iso_c_binding, only: c_ptr, c_funptr, c_int, c_double, c_size_t, c_null_ptr, c_null_funptr, &
    c_associated, c_f_pointer
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type, pivot_floor, singular_at, text_of
  implicit none
  private

  public :: make_klu_solver

  integer(c_int), parameter :: status_ok = 0, status_singular = 1, status_no_memory = -2, status_too_large = -4

  !> klu_common: settings and statistics.
  type, bind(c) :: klu_common
    real(c_double) :: pivot_tolerance = 0, memory_growth = 0, first_memory_amd = 0, first_memory = 0, most_work = 0
    integer(c_int) :: block_triangular = 0, ordering = 0, scaling = 0
    type(c_funptr) :: user_order = c_null_funptr
    type(c_ptr) :: user_data = c_null_ptr
    integer(c_int) :: halt_if_singular = 0
    integer(c_int) :: status = 0, reallocations = 0, structural_rank = 0, numerical_rank = 0, singular_column = 0, &
      off_diagonal = 0
    real(c_double) :: operations = 0, reciprocal_condition = 0, condition = 0, pivot_growth = 0, work = 0
    integer(c_size_t) :: memory = 0, most_memory = 0
  end type klu_common

  !> The head of klu_numeric: the factors.
  type, bind(c) :: klu_numeric
    integer(c_int) :: n, blocks, lower_count, upper_count, largest_lower, largest_upper
    type(c_ptr) :: row_order, row_place, lower_first, upper_first, lower_length, upper_length, factors, sizes
    type(c_ptr) :: diagonal, scales
  end type klu_numeric

  !> The handles, and the pattern counted from 0.
  type, extends(linear_solver_type) :: klu_solver_type
    private
    type(c_ptr) :: symbolic = c_null_ptr, numeric = c_null_ptr
    type(klu_common) :: common
    integer(c_int), allocatable :: first(:), row(:)
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
    procedure :: release
  end type klu_solver_type

  interface
    integer(c_int) function klu_defaults(common) bind(c)
      import :: c_int, klu_common
      type(klu_common), intent(inout) :: common
    end function klu_defaults

    !> Null pointers stand for the identity.
    type(c_ptr) function klu_analyze_given(n, first, row, row_order, column_order, common) bind(c)
      import :: c_ptr, c_int, klu_common
      integer(c_int), value :: n
      integer(c_int), intent(in) :: first(*), row(*)
      type(c_ptr), value :: row_order, column_order
      type(klu_common), intent(inout) :: common
    end function klu_analyze_given

    type(c_ptr) function klu_factor(first, row, values, symbolic, common) bind(c)
      import :: c_ptr, c_int, c_double, klu_common
      integer(c_int), intent(in) :: first(*), row(*)
      real(c_double), intent(in) :: values(*)
      type(c_ptr), value :: symbolic
      type(klu_common), intent(inout) :: common
    end function klu_factor

    integer(c_int) function klu_flops(symbolic, numeric, common) bind(c)
      import :: c_ptr, c_int, klu_common
      type(c_ptr), value :: symbolic, numeric
      type(klu_common), intent(inout) :: common
    end function klu_flops

    !> The right-hand sides become the solutions.
    integer(c_int) function klu_tsolve(symbolic, numeric, rows, columns, rhs, common) bind(c)
      import :: c_ptr, c_int, c_double, klu_common
      type(c_ptr), value :: symbolic, numeric
      integer(c_int), value :: rows, columns
      real(c_double), intent(inout) :: rhs(*)
      type(klu_common), intent(inout) :: common
    end function klu_tsolve

    integer(c_int) function klu_free_symbolic(symbolic, common) bind(c)
      import :: c_ptr, c_int, klu_common
      type(c_ptr), intent(inout) :: symbolic
      type(klu_common), intent(inout) :: common
    end function klu_free_symbolic

    integer(c_int) function klu_free_numeric(numeric, common) bind(c)
      import :: c_ptr, c_int, klu_common
      type(c_ptr), intent(inout) :: numeric
      type(klu_common), intent(inout) :: common
    end function klu_free_numeric
  end interface

contains

  !> A KLU solver; symmetric matrices are treated as any other.
  subroutine make_klu_solver(symmetric, solver)
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    associate (unused => symmetric)
    end associate
    allocate (klu_solver_type :: solver)
    solver%name = 'KLU'
  end subroutine make_klu_solver

  !> Symbolic factorisation in the given order, in one block.
  subroutine analyse_pattern(self, matrix, error)
    class(klu_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error
    integer(c_int) :: status

    status = klu_defaults(self%common)
    if (self%common%block_triangular /= 1 .or. self%common%scaling /= 2 .or. self%common%halt_if_singular /= 1) then
      call fail(error, error_other, 'KLU: the settings of this library are not laid out as in version 1.3')
      return
    end if
    self%common%block_triangular = 0
    self%first = matrix%row_first(:matrix%n + 1) - 1
    self%row = matrix%column(:self%first(matrix%n + 1)) - 1
    self%symbolic = klu_analyze_given(matrix%n, self%first, self%row, c_null_ptr, c_null_ptr, self%common)
    if (.not. c_associated(self%symbolic)) call library_error(self%common%status, error)
  end subroutine analyse_pattern

  !> Numeric factorisation.
  subroutine factorise_values(self, matrix, error)
    class(klu_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error
    type(klu_numeric), pointer :: factors
    integer(c_int) :: status

    if (c_associated(self%numeric)) status = klu_free_numeric(self%numeric, self%common)
    self%numeric = klu_factor(self%first, self%row, matrix%values, self%symbolic, self%common)
    if (self%common%status == status_singular) then
      call singular_at(self%common%singular_column + 1, error)
    else if (self%common%status /= status_ok) then
      call library_error(self%common%status, error)
    else
      call c_f_pointer(self%numeric, factors)
      self%factor_nonzeros = int(factors%lower_count, long) + factors%upper_count
      if (klu_flops(self%symbolic, self%numeric, self%common) == 1) self%factor_operations = self%common%operations
      call judge_pivots(self, factors, matrix%values, error)
    end if
  end subroutine factorise_values

  !> A pivot is judged against the largest entry of its column in the scaled matrix. A column of the matrix that KLU
  !> sees is an equation here; its scales stand in the order of the pivots.
  subroutine judge_pivots(self, factors, values, error)
    class(klu_solver_type), intent(in) :: self
    type(klu_numeric), intent(in) :: factors
    real(wp), intent(in) :: values(:)
    type(error_type), allocatable, intent(out) :: error
    real(c_double), pointer :: pivots(:), scales(:)
    integer(c_int), pointer :: place(:)
    real(wp) :: largest
    integer :: j

    call c_f_pointer(factors%diagonal, pivots, [factors%n])
    call c_f_pointer(factors%scales, scales, [factors%n])
    call c_f_pointer(factors%row_place, place, [factors%n])
    do j = 1, factors%n
      associate (first => self%first(j) + 1, last => self%first(j + 1))
        largest = maxval(abs(values(first:last))/scales(place(self%row(first:last) + 1) + 1))
      end associate
      if (abs(pivots(j)) > pivot_floor(int(factors%n))*largest) cycle
      call singular_at(j, error)
      return
    end do
  end subroutine judge_pivots

  !> Forward and backward substitution.
  subroutine solve_factorised(self, rhs, x, error)
    class(klu_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    x = rhs
    if (klu_tsolve(self%symbolic, self%numeric, size(x), 1_c_int, x, self%common) /= 1) &
      call library_error(self%common%status, error)
  end subroutine solve_factorised

  !> Free the handles.
  subroutine release(self)
    class(klu_solver_type), intent(inout) :: self
    integer(c_int) :: status

    if (c_associated(self%numeric)) status = klu_free_numeric(self%numeric, self%common)
    if (c_associated(self%symbolic)) status = klu_free_symbolic(self%symbolic, self%common)
    self%numeric = c_null_ptr
    self%symbolic = c_null_ptr
    if (allocated(self%first)) deallocate (self%first, self%row)
  end subroutine release

  !> A failure of the library as an error.
  subroutine library_error(status, error)
    !> KLU's status.
    integer(c_int), intent(in) :: status
    type(error_type), allocatable, intent(out) :: error

    select case (status)
    case (status_no_memory)
      call fail(error, error_other, 'KLU: no memory for the factors')
    case (status_too_large)
      call fail(error, error_other, 'KLU: the factors hold more entries than its integers can count')
    case default
      call fail(error, error_other, 'KLU failed with status '//text_of(int(status)))
    end select
  end subroutine library_error
end module qsmpm_klu_solver
