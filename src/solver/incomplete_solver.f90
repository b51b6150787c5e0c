!> Incomplete factors on the pattern of the matrix, as preconditioners: L D L^T of a symmetric matrix, L U of an
!> unsymmetric one (IC(0), ILU(0)). `solve` applies the factors; it does not solve the equations.
!>
!> Since all equations of a node are coupled with all those of a neighbour, the pattern consists of node blocks, and
!> the factors are those of the incomplete block factorisation. They are computed in double precision and stored in
!> single precision, since a sweep is limited by memory bandwidth. If a pivot loses nearly all of its diagonal entry
!> the whole diagonal is shifted and the factorisation is repeated (Manteuffel).
module qsmpm_incomplete_solver
  use qsmpm_kinds, only: wp, sp, long
  use qsmpm_error, only: error_type, fail, error_singular
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type
  implicit none
  private

  public :: incomplete_solver_type, make_incomplete_solver

  !> Minimum ratio of a pivot to its diagonal entry.
  real(wp), parameter :: least_share = 1.0e-3_wp
  !> First and largest shift of the diagonal; factor between two attempts.
  real(wp), parameter :: first_shift = 1.0e-3_wp, largest_shift = 10.0_wp, shift_growth = 3.0_wp

  !> Factors on the pattern of the matrix.
  type, extends(linear_solver_type) :: incomplete_solver_type
    !> Relative shift of the diagonal, 0 without a breakdown.
    real(wp) :: shift = 0.0_wp
    integer, allocatable, private :: first(:), column(:)
    !> Position of the diagonal in each row (n).
    integer, allocatable, private :: middle(:)
    !> Symmetric: L^T with a unit diagonal. Unsymmetric: L with a unit diagonal below, U above.
    real(sp), allocatable, private :: factor(:)
    !> Reciprocal pivots (n).
    real(wp), allocatable, private :: pivot(:)
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
  end type incomplete_solver_type

contains

  !> Creates a preconditioner with incomplete factors.
  subroutine make_incomplete_solver(symmetric, solver)
    !> Whether it is IC(0), otherwise ILU(0).
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (incomplete_solver_type :: solver)
    solver%name = 'ILU(0)'
    if (symmetric) solver%name = 'IC(0)'
    solver%symmetric = symmetric
    solver%approximate = .true.
  end subroutine make_incomplete_solver

  !> Copies the pattern; of a symmetric matrix the upper triangle.
  subroutine analyse_pattern(self, matrix, error)
    class(incomplete_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer :: i, k, entry_count

    if (allocated(self%first)) deallocate (self%first, self%column, self%middle, self%factor, self%pivot)
    allocate (self%first(matrix%n + 1), self%middle(matrix%n), self%pivot(matrix%n))
    allocate (self%column(matrix%row_first(matrix%n + 1) - 1))
    entry_count = 0
    do i = 1, matrix%n
      self%first(i) = entry_count + 1
      self%middle(i) = 0
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        if (self%symmetric .and. matrix%column(k) < i) cycle
        entry_count = entry_count + 1
        self%column(entry_count) = matrix%column(k)
        if (matrix%column(k) == i) self%middle(i) = entry_count
      end do
      if (self%middle(i) == 0) call fail(error, error_singular, 'the matrix has a row without a diagonal entry')
    end do
    self%first(matrix%n + 1) = entry_count + 1
    allocate (self%factor(entry_count))
  end subroutine analyse_pattern

  !> Factorises with the smallest shift for which all pivots are valid.
  subroutine factorise_values(self, matrix, error)
    class(incomplete_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer :: broken

    self%shift = 0.0_wp
    self%factor_nonzeros = size(self%factor, kind=long)
    do
      call take_values(self, matrix)
      if (self%symmetric) then
        call factorise_symmetric(self, broken)
      else
        call factorise_general(self, broken)
      end if
      if (broken == 0) return
      self%shift = merge(shift_growth*self%shift, first_shift, self%shift > 0.0_wp)
      if (self%shift > largest_shift) exit
    end do
    call fail(error, error_singular, 'no diagonal shift makes the incomplete factorisation possible')
  end subroutine factorise_values

  !> Copies the values and shifts the diagonal; `pivot` temporarily stores the unshifted diagonal.
  subroutine take_values(self, matrix)
    class(incomplete_solver_type), intent(inout) :: self
    !> Matrix of the analysed pattern.
    type(sparse_matrix_type), intent(in) :: matrix

    integer :: i, below

    do i = 1, matrix%n
      associate (length => self%first(i + 1) - self%first(i))
        below = matrix%row_first(i + 1) - length
        self%factor(self%first(i):self%first(i + 1) - 1) = real(matrix%values(below:below + length - 1), sp)
        self%pivot(i) = matrix%values(below + self%middle(i) - self%first(i))
      end associate
    end do
  end subroutine take_values

  !> Computes L D L^T, left-looking. Each finished row is in the list of the next column in which it is needed.
  subroutine factorise_symmetric(self, broken)
    class(incomplete_solver_type), intent(inout) :: self
    !> Equation whose pivot is too small, 0 if all are valid.
    integer, intent(out) :: broken

    integer, allocatable :: waiting(:), link(:), next(:), place(:)
    real(wp) :: scale, diagonal
    integer :: i, j, k, follower

    allocate (waiting(size(self%pivot)), link(size(self%pivot)), next(size(self%pivot)), place(size(self%pivot)))
    waiting = 0
    place = 0
    do j = 1, size(self%pivot)
      do k = self%first(j), self%first(j + 1) - 1
        place(self%column(k)) = k
      end do
      diagonal = self%pivot(j)*(1.0_wp + self%shift)
      i = waiting(j)
      do while (i > 0)
        follower = link(i)
        k = next(i)
        scale = real(self%factor(k), wp)/self%pivot(i)
        diagonal = diagonal - scale*real(self%factor(k), wp)
        call subtract(self, k + 1, self%first(i + 1) - 1, scale, place, self%first(j))
        call wait_on(self, i, k + 1, next, waiting, link)
        i = follower
      end do
      broken = j
      if (.not. diagonal > least_share*abs(self%pivot(j))) return
      self%pivot(j) = 1.0_wp/diagonal
      do k = self%first(j) + 1, self%first(j + 1) - 1
        self%factor(k) = real(self%factor(k)*self%pivot(j), sp)
      end do
      call wait_on(self, j, self%first(j) + 1, next, waiting, link)
    end do
    broken = 0
  end subroutine factorise_symmetric

  !> Adds row i to the list of the column at a position of the row.
  pure subroutine wait_on(self, i, k, next, waiting, link)
    class(incomplete_solver_type), intent(in) :: self
    !> Row; position in it.
    integer, intent(in) :: i, k
    !> Current position of each row, first row of each list, next row in the list (n).
    integer, intent(inout) :: next(:), waiting(:), link(:)

    if (k >= self%first(i + 1)) return
    next(i) = k
    link(i) = waiting(self%column(k))
    waiting(self%column(k)) = i
  end subroutine wait_on

  !> Subtracts a multiple of a part of a row where the target row has entries.
  pure subroutine subtract(self, start, finish, scale, place, least)
    class(incomplete_solver_type), intent(inout) :: self
    !> First and last position of the part.
    integer, intent(in) :: start, finish
    !> Multiplier.
    real(wp), intent(in) :: scale
    !> Position of each column in the target row; smaller than `least` where it has none (n).
    integer, intent(in) :: place(:), least

    integer :: k, there

    do k = start, finish
      there = place(self%column(k))
      if (there >= least) self%factor(there) = real(self%factor(there) - scale*self%factor(k), sp)
    end do
  end subroutine subtract

  !> Computes L U row by row.
  subroutine factorise_general(self, broken)
    class(incomplete_solver_type), intent(inout) :: self
    !> Equation whose pivot is too small, 0 if all are valid.
    integer, intent(out) :: broken

    integer, allocatable :: place(:)
    real(wp) :: scale, diagonal
    integer :: i, j, k

    allocate (place(size(self%pivot)), source=0)
    do i = 1, size(self%pivot)
      do k = self%first(i), self%first(i + 1) - 1
        place(self%column(k)) = k
      end do
      self%factor(self%middle(i)) = real(self%pivot(i)*(1.0_wp + self%shift), sp)
      do k = self%first(i), self%middle(i) - 1
        j = self%column(k)
        scale = self%factor(k)*self%pivot(j)
        self%factor(k) = real(scale, sp)
        call subtract(self, self%middle(j) + 1, self%first(j + 1) - 1, scale, place, self%first(i))
      end do
      broken = i
      diagonal = self%factor(self%middle(i))
      if (.not. diagonal*sign(1.0_wp, self%pivot(i)) > least_share*abs(self%pivot(i))) return
      self%pivot(i) = 1.0_wp/diagonal
    end do
    broken = 0
  end subroutine factorise_general

  !> Applies forward and backward substitution with the incomplete factors.
  subroutine solve_factorised(self, rhs, x, error)
    class(incomplete_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    integer :: i, k
    real(wp) :: total

    x = rhs
    do i = 1, size(x)
      if (self%symmetric) then
        do k = self%first(i) + 1, self%first(i + 1) - 1
          x(self%column(k)) = x(self%column(k)) - self%factor(k)*x(i)
        end do
      else
        total = x(i)
        do k = self%first(i), self%middle(i) - 1
          total = total - self%factor(k)*x(self%column(k))
        end do
        x(i) = total
      end if
    end do
    if (self%symmetric) x = x*self%pivot
    do i = size(x), 1, -1
      total = x(i)
      do k = self%middle(i) + 1, self%first(i + 1) - 1
        total = total - self%factor(k)*x(self%column(k))
      end do
      x(i) = total
      if (.not. self%symmetric) x(i) = total*self%pivot(i)
    end do
  end subroutine solve_factorised
end module qsmpm_incomplete_solver
