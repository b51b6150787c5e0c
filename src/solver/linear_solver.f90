!> Interface of all direct solvers of the equations K x = b: analyse the pattern, factorise the values, solve, destroy.
!>
!> The equations are numbered in a fill-reducing order (`node_ordering`), which a solver retains. Checks common to all
!> solvers are made here and the work is deferred to the solver: values and right-hand side are finite, no row is zero,
!> the pattern is the analysed one, and no solution contains a NaN. All handles and work arrays are components, so that
!> several solvers can exist at the same time. `destroy` must be called; there is no automatic finalisation.
!>
!> A pivot smaller than `pivot_floor` times the entries from which it results is round-off: the matrix is singular to
!> working precision, and the error names the equation if the library reports it. Other cases are detected from the
!> solution: if the round-off of K x alone is as large as b, no digit of x is correct.
module qsmpm_linear_solver
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_other, error_singular
  use qsmpm_node_blocks, only: node_blocks_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type, row_sums, first_not_finite
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: linear_solver_type, pivot_floor, singular_at, indefinite_at

  !> A direct solver.
  type, abstract :: linear_solver_type
    !> Name of the solver for the log.
    character(len=:), allocatable :: name
    !> Whether the values are symmetric and the solver may use this.
    logical :: symmetric = .false.
    !> Whether the pattern has been analysed; whether there is a factorisation.
    logical :: analysed = .false.
    logical :: factorised = .false.
    !> Whether the last factorisation failed because the matrix is not positive definite; a solver for symmetric
    !> indefinite or unsymmetric matrices may still factorise it.
    logical :: indefinite = .false.
    !> Number of negative pivots of the last factorisation; -1 if the solver does not count them.
    integer :: negative_pivots = -1
    !> Whether the factors are not those of the matrix to working precision: the solution is then computed by a Krylov
    !> method that they precondition (qsmpm_krylov).
    logical :: approximate = .false.
    !> Whether the solver has its own Krylov method: `solve` iterates to the residual `tolerance`, relative to the
    !> right-hand side, in at most the given number of sweeps, fails otherwise, and counts the sweeps.
    logical :: iterates = .false.
    real(wp) :: tolerance = 1.0e-10_wp
    integer :: most_sweeps = 1000, sweeps = 0
    !> Whether the equations are not numbered for elimination: a direct solver finds an order, the same in every run.
    logical :: orders_itself = .false.
    !> Whether no data of an earlier factorisation may be used in the next one.
    logical :: afresh = .true.
    !> Nodes of the equations, if set.
    type(node_blocks_type) :: blocks
    !> Numbers stored in the factors.
    integer(long) :: factor_nonzeros = 0
    !> Floating-point operations of the last factorisation; 0 if the solver does not report them.
    real(wp) :: factor_operations = 0.0_wp
    !> Size and number of entries of the analysed pattern.
    integer, private :: n = 0
    integer, private :: entry_count = 0
    !> Largest sum of absolute values in a row of the factorised matrix.
    real(wp), private :: norm = 0.0_wp
  contains
    procedure, non_overridable :: analyse
    procedure, non_overridable :: factorise
    procedure, non_overridable :: solve
    procedure, non_overridable :: destroy
    procedure(matrix_interface), deferred :: analyse_pattern
    procedure(matrix_interface), deferred :: factorise_values
    procedure(solve_interface), deferred :: solve_factorised
    procedure :: forget => free_nothing
    procedure :: release => free_nothing
  end type linear_solver_type

  abstract interface
    !> Analyses the pattern, for which the values need not be set; or factorises finite values of the analysed pattern
    !> without zero rows.
    subroutine matrix_interface(self, matrix, error)
      import :: linear_solver_type, sparse_matrix_type, error_type
      class(linear_solver_type), intent(inout) :: self
      type(sparse_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error
    end subroutine matrix_interface

    !> Solves with the factors for a finite right-hand side.
    subroutine solve_interface(self, rhs, x, error)
      import :: linear_solver_type, wp, error_type
      class(linear_solver_type), intent(inout) :: self
      real(wp), intent(in) :: rhs(:)
      real(wp), intent(out) :: x(:)
      type(error_type), allocatable, intent(out) :: error
    end subroutine solve_interface
  end interface

contains

  !> `forget` frees data of a factorisation that are not used again, where a solver with large data may do so before the
  !> next one. `release` frees handles and memory that the next analysis or the end of the solver does not free; it is
  !> allowed at any time and repeatedly. Nothing, unless extended.
  subroutine free_nothing(self)
    class(linear_solver_type), intent(inout) :: self
  end subroutine free_nothing

  !> Analyses a pattern; previous analyses and factorisations are discarded.
  subroutine analyse(self, matrix, error)
    class(linear_solver_type), intent(inout) :: self
    !> Matrix with the pattern; its values are not used.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Set when the pattern is not that of a square matrix, or when the library fails.
    type(error_type), allocatable, intent(out) :: error

    call self%destroy()
    if (matrix%n < 1) then
      call fail(error, error_other, self%name//': there are no equations to solve')
      return
    end if
    if (matrix%symmetric .and. .not. self%symmetric) then
      call fail(error, error_other, self%name//': takes no matrix of which one triangle is stored')
      return
    end if
    self%n = matrix%n
    self%entry_count = matrix%row_first(matrix%n + 1) - 1
    call self%analyse_pattern(matrix, error)
    self%analysed = .not. allocated(error)
  end subroutine analyse

  !> Factorises the values of a matrix of the analysed pattern.
  subroutine factorise(self, matrix, error)
    class(linear_solver_type), intent(inout) :: self
    !> Matrix of the analysed pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> `error_singular` when the matrix is singular, or not positive definite (see `indefinite`).
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: sums(matrix%n)
    integer :: row

    self%factorised = .false.
    self%indefinite = .false.
    self%negative_pivots = -1
    self%factor_nonzeros = 0
    self%factor_operations = 0.0_wp
    if (.not. self%analysed) then
      call fail(error, error_other, self%name//': the pattern was not analysed')
      return
    end if
    if (matrix%n /= self%n .or. matrix%row_first(matrix%n + 1) - 1 /= self%entry_count) then
      call fail(error, error_other, self%name//': the pattern is not the one that was analysed')
      return
    end if
    row = first_not_finite(matrix)
    if (row > 0) then
      call fail(error, error_singular, 'the matrix has a value that is not finite in equation '// &
        integer_text(row))
      return
    end if
    call row_sums(matrix, sums)
    row = findloc(sums > 0.0_wp, .false., dim=1)
    if (row > 0) then
      call fail(error, error_singular, &
        'the matrix is singular: equation '//integer_text(row)//' is zero')
      return
    end if
    self%norm = maxval(sums)
    call self%factorise_values(matrix, error)
    self%factorised = .not. allocated(error)
  end subroutine factorise

  !> Solves K x = b with the last factorisation.
  subroutine solve(self, rhs, x, error)
    class(linear_solver_type), intent(inout) :: self
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Solution (n); zero after an error.
    real(wp), intent(out) :: x(:)
    !> Set when there is no factorisation, when a number is not finite, or when the matrix is found to be singular.
    type(error_type), allocatable, intent(out) :: error

    x = 0.0_wp
    if (.not. self%factorised) then
      call fail(error, error_other, self%name//': there is no factorisation to solve with')
    else if (size(rhs) /= self%n .or. size(x) /= self%n) then
      call fail(error, error_other, self%name//': right-hand side or solution has a wrong length')
    else if (.not. all(ieee_is_finite(rhs))) then
      call fail(error, error_other, &
        'the right-hand side has a value that is not finite in equation '// &
        integer_text(findloc(ieee_is_finite(rhs), .false., dim=1)))
    else
      call self%solve_factorised(rhs, x, error)
      if (.not. allocated(error)) call judge_solution(self%norm, rhs, x, error)
      if (allocated(error)) x = 0.0_wp
    end if
  end subroutine solve

  !> Rejects a solution that is not finite, or so large that the round-off of K x exceeds b.
  pure subroutine judge_solution(norm, rhs, x, error)
    !> Row-sum norm of K.
    real(wp), intent(in) :: norm
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Solution (n).
    real(wp), intent(in) :: x(:)
    !> `error_singular`.
    type(error_type), allocatable, intent(out) :: error

    logical :: good

    good = all(ieee_is_finite(x))
    if (good) good = epsilon(1.0_wp)*norm*maxval(abs(x)) <= maxval(abs(rhs))
    if (good) return
    call fail(error, error_singular, &
      'the matrix is singular to working precision: no digit of the solution is right')
  end subroutine judge_solution

  !> Frees all data. The solver may be used again from `analyse`.
  subroutine destroy(self)
    class(linear_solver_type), intent(inout) :: self

    call self%release()
    self%analysed = .false.
    self%factorised = .false.
  end subroutine destroy

  !> Returns the minimum ratio of a pivot to the entries from which it results. The round-off of cancelling pivots
  !> grows with the square root of the number of updates, at most n of them.
  pure real(wp) function pivot_floor(n)
    !> Number of equations.
    integer, intent(in) :: n

    pivot_floor = max(100.0_wp, 10.0_wp*sqrt(real(n, wp)))*epsilon(1.0_wp)
  end function pivot_floor

  !> Sets the error of a singular matrix whose equation is known.
  pure subroutine singular_at(equation, error)
    !> Number of the equation, 1 to n.
    integer, intent(in) :: equation
    type(error_type), allocatable, intent(out) :: error

    call fail(error, error_singular, &
      'the matrix is singular: nothing is left of the pivot of equation '//integer_text(equation))
  end subroutine singular_at

  !> Sets the error of a matrix that is not positive definite.
  pure subroutine indefinite_at(equation, error)
    !> Number of the equation, 1 to n.
    integer, intent(in) :: equation
    type(error_type), allocatable, intent(out) :: error

    call fail(error, error_singular, &
      'the matrix is not positive definite: the pivot of equation '//integer_text(equation)// &
      ' is not positive')
  end subroutine indefinite_at
end module qsmpm_linear_solver
