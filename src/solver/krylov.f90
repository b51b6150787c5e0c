!> Krylov methods for K x = b with any solver of the house as the preconditioner: conjugate gradients
!> for symmetric positive definite matrices, restarted GMRES, preconditioned from the right, for the
!> others. The preconditioner may hold an incomplete factor, one of single precision, or the factor of
!> an older matrix.
!>
!> Both stop when |b - K x| <= tolerance |b|, and both give up where they stall: a preconditioner that
!> does not take a fair share of the residual at every sweep is not worth its solves, and the caller has
!> better ones. Sums run in the order of the equations: the result is that of the counted sweeps alone.
module qsmpm_krylov
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type, multiply
  use qsmpm_linear_solver, only: linear_solver_type
  implicit none
  private

  public :: krylov_limits_type, krylov_result_type, solve_cg, solve_gmres

  !> Directions of GMRES before a restart.
  integer, parameter :: directions = 40

  !> Stopping criteria.
  type :: krylov_limits_type
    !> Residual wanted, relative to the right-hand side.
    real(wp) :: tolerance = 1.0e-10_wp
    !> Products with K allowed.
    integer :: most_sweeps = 1000
    !> Share of the residual that a sweep must take at least, in the mean of all sweeps after the first
    !> few; 1 asks for nothing.
    real(wp) :: rate = 1.0_wp
  end type krylov_limits_type

  !> Record of the solution.
  type :: krylov_result_type
    logical :: converged = .false.
    integer :: sweeps = 0
    !> Residual relative to the right-hand side.
    real(wp) :: residual = 1.0_wp
  end type krylov_result_type

contains

  !> Conjugate gradients.
  subroutine solve_cg(matrix, preconditioner, rhs, limits, x, outcome)
    !> K, symmetric positive definite.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Holds a factorisation.
    class(linear_solver_type), intent(inout) :: preconditioner
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    !> Record of the solution.
    type(krylov_result_type), intent(out) :: outcome
    type(error_type), allocatable :: error
    real(wp), allocatable :: r(:), z(:), p(:), q(:)
    real(wp) :: rho, rho_before, curvature, length

    allocate (r, source=rhs)
    allocate (z(size(rhs)), p(size(rhs)), q(size(rhs)))
    x = 0.0_wp
    p = 0.0_wp
    rho_before = 1.0_wp
    length = norm2(rhs)
    outcome%converged = .not. length > 0.0_wp
    do while (.not. outcome%converged .and. outcome%sweeps < limits%most_sweeps)
      call preconditioner%solve_factorised(r, z, error)
      if (allocated(error)) return
      rho = dot_product(r, z)
      if (outcome%sweeps > 0) z = z + (rho/rho_before)*p
      p = z
      call multiply(matrix, p, q)
      curvature = dot_product(p, q)
      outcome%sweeps = outcome%sweeps + 1
      ! A direction of no curvature: the matrix or the preconditioner is not positive definite.
      if (.not. (rho > 0.0_wp .and. curvature > 0.0_wp)) return
      x = x + (rho/curvature)*p
      r = r - (rho/curvature)*q
      rho_before = rho
      if (judged(norm2(r)/length, limits, outcome)) exit
    end do
    if (outcome%converged .and. length > 0.0_wp) call confirm(matrix, rhs, x, limits, outcome)
  end subroutine solve_cg

  !> GMRES, restarted from the true residual.
  subroutine solve_gmres(matrix, preconditioner, rhs, limits, x, outcome)
    !> K.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Holds a factorisation.
    class(linear_solver_type), intent(inout) :: preconditioner
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    !> Record of the solution.
    type(krylov_result_type), intent(out) :: outcome
    type(error_type), allocatable :: error
    real(wp), allocatable :: basis(:, :), r(:), z(:)
    real(wp) :: length

    allocate (basis(size(rhs), min(directions, limits%most_sweeps) + 1), z(size(rhs)))
    allocate (r, source=rhs)
    x = 0.0_wp
    length = norm2(rhs)
    outcome%converged = .not. length > 0.0_wp
    do while (.not. outcome%converged .and. outcome%sweeps < limits%most_sweeps)
      call run_cycle(r, basis, z)
      if (allocated(error)) return
      x = x + z
      call multiply(matrix, x, r)
      r = rhs - r
      if (judged(norm2(r)/length, limits, outcome)) exit
    end do

  contains

    !> One cycle of GMRES: Arnoldi with modified Gram-Schmidt, least squares by Givens rotations.
    subroutine run_cycle(r, basis, z)
      !> Residual at the start of the cycle (n); scratch afterwards.
      real(wp), intent(inout) :: r(:)
      !> Scratch (n, directions + 1).
      real(wp), intent(inout) :: basis(:, :)
      !> Change of the solution (n).
      real(wp), intent(out) :: z(:)
      real(wp) :: h(directions + 1, directions), turn(2, directions), share(directions + 1)
      integer :: i, j, last

      share = 0.0_wp
      share(1) = norm2(r)
      basis(:, 1) = r/share(1)
      last = 0
      do j = 1, size(basis, 2) - 1
        call preconditioner%solve_factorised(basis(:, j), z, error)
        if (allocated(error)) return
        call multiply(matrix, z, r)
        outcome%sweeps = outcome%sweeps + 1
        do i = 1, j
          h(i, j) = dot_product(r, basis(:, i))
          r = r - h(i, j)*basis(:, i)
        end do
        h(j + 1, j) = norm2(r)
        last = j
        if (h(j + 1, j) > 0.0_wp) basis(:, j + 1) = r/h(j + 1, j)
        call rotate(h(:j + 1, j), turn(:, :j), share(:j + 1))
        if (judged(abs(share(j + 1))/length, limits, outcome)) exit
        if (outcome%sweeps >= limits%most_sweeps) exit
      end do
      call combine(h, basis, last, share, r)
      call preconditioner%solve_factorised(r, z, error)
    end subroutine run_cycle
  end subroutine solve_gmres

  !> Sum of the directions whose shares solve the triangular system of the least squares.
  pure subroutine combine(h, basis, last, share, r)
    !> Triangle (directions + 1, directions), and the directions (n, directions + 1).
    real(wp), intent(in) :: h(:, :), basis(:, :)
    !> How many directions there are.
    integer, intent(in) :: last
    !> In: right-hand side. Out: shares (directions + 1).
    real(wp), intent(inout) :: share(:)
    !> (n)
    real(wp), intent(out) :: r(:)
    integer :: j

    do j = last, 1, -1
      share(j) = (share(j) - dot_product(h(j, j + 1:last), share(j + 1:last)))/h(j, j)
    end do
    r = 0.0_wp
    do j = 1, last
      r = r + share(j)*basis(:, j)
    end do
  end subroutine combine

  !> Turn the new column of the Hessenberg matrix as the earlier ones, and its last entry away.
  pure subroutine rotate(column, turn, share)
    !> New column (j+1).
    real(wp), intent(inout) :: column(:)
    !> Cosine and sine of each turn (2, j); the last is set.
    real(wp), intent(inout) :: turn(:, :)
    !> Right-hand side of the least squares (j+1).
    real(wp), intent(inout) :: share(:)
    real(wp) :: size_of_pair, upper
    integer :: i, j

    j = size(turn, 2)
    do i = 1, j - 1
      upper = turn(1, i)*column(i) + turn(2, i)*column(i + 1)
      column(i + 1) = turn(1, i)*column(i + 1) - turn(2, i)*column(i)
      column(i) = upper
    end do
    size_of_pair = max(hypot(column(j), column(j + 1)), tiny(1.0_wp))
    turn(:, j) = [column(j), column(j + 1)]/size_of_pair
    column(j) = size_of_pair
    column(j + 1) = 0.0_wp
    share(j + 1) = -turn(2, j)*share(j)
    share(j) = turn(1, j)*share(j)
  end subroutine rotate

  !> Note a residual; true when it is small enough, not finite, or falls too slowly.
  logical function judged(residual, limits, outcome)
    !> Residual relative to the right-hand side.
    real(wp), intent(in) :: residual
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Record of the solution.
    type(krylov_result_type), intent(inout) :: outcome
    !> Sweeps before the rate is judged.
    integer, parameter :: trial = 4

    outcome%residual = residual
    outcome%converged = residual <= limits%tolerance
    judged = outcome%converged .or. .not. ieee_is_finite(residual)
    if (judged .or. outcome%sweeps < trial .or. limits%rate >= 1.0_wp) return
    judged = residual > limits%rate**outcome%sweeps
  end function judged

  !> The residual that conjugate gradients carry along may have left the true one.
  subroutine confirm(matrix, rhs, x, limits, outcome)
    !> K.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Solution (n).
    real(wp), intent(in) :: x(:)
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Record of the solution.
    type(krylov_result_type), intent(inout) :: outcome
    !> Factor by which the true residual may be the larger.
    real(wp), parameter :: drift = 10.0_wp
    real(wp), allocatable :: product_vector(:)

    allocate (product_vector(size(rhs)))
    call multiply(matrix, x, product_vector)
    outcome%residual = norm2(rhs - product_vector)/norm2(rhs)
    outcome%converged = outcome%residual <= drift*limits%tolerance
  end subroutine confirm
end module qsmpm_krylov
