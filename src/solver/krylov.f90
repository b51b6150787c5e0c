!> Krylov methods for K x = b with any solver of this folder as preconditioner: conjugate gradients for symmetric
!> positive definite matrices, restarted GMRES with right preconditioning for others. The preconditioner may be an
!> incomplete factor, one of single precision, or the factor of an older matrix.
!>
!> Both stop when |b - K x| <= tolerance |b|, and both give up when they stall: a preconditioner that does not reduce
!> the residual sufficiently in every sweep is not worth its cost, and the caller has better ones. Sums follow the
!> order of the equations, so that the result is determined by the number of sweeps alone.
module qsmpm_krylov
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type, multiply
  use qsmpm_linear_solver, only: linear_solver_type
  implicit none
  private

  public :: krylov_limits_type, krylov_result_type, solve_cg, solve_gmres

  !> Number of GMRES directions before a restart.
  integer, parameter :: directions = 40

  !> Stopping criteria.
  type :: krylov_limits_type
    !> Required residual, relative to the right-hand side.
    real(wp) :: tolerance = 1.0e-10_wp
    !> Maximum number of products with K.
    integer :: most_sweeps = 1000
    !> Largest mean reduction factor of the residual per sweep allowed after the first few sweeps; 1 for no
    !> requirement.
    real(wp) :: rate = 1.0_wp
  end type krylov_limits_type

  !> Result of the iterations.
  type :: krylov_result_type
    logical :: converged = .false.
    integer :: sweeps = 0
    !> Residual relative to the right-hand side.
    real(wp) :: residual = 1.0_wp
  end type krylov_result_type

contains

  !> Solves by conjugate gradients.
  subroutine solve_cg(matrix, preconditioner, rhs, limits, x, outcome)
    !> K, symmetric positive definite.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Factorised preconditioner.
    class(linear_solver_type), intent(inout) :: preconditioner
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    !> Result of the iterations.
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
      ! Direction without positive curvature: the matrix or the preconditioner is not positive definite.
      if (.not. (rho > 0.0_wp .and. curvature > 0.0_wp)) return
      x = x + (rho/curvature)*p
      r = r - (rho/curvature)*q
      rho_before = rho
      if (judged(norm2(r)/length, limits, outcome)) exit
    end do
    if (outcome%converged .and. length > 0.0_wp) call confirm(matrix, rhs, x, limits, outcome)
  end subroutine solve_cg

  !> Solves by GMRES, restarted from the true residual.
  subroutine solve_gmres(matrix, preconditioner, rhs, limits, x, outcome)
    !> K.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Factorised preconditioner.
    class(linear_solver_type), intent(inout) :: preconditioner
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    !> Result of the iterations.
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

    !> Computes a cycle of GMRES: Arnoldi with modified Gram-Schmidt, least squares by Givens rotations.
    subroutine run_cycle(r, basis, z)
      !> Residual at the start of the cycle (n); overwritten.
      real(wp), intent(inout) :: r(:)
      !> Workspace (n, directions + 1).
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

  !> Returns the combination of directions from the solution of the triangular least-squares system.
  pure subroutine combine(h, basis, last, share, r)
    !> Triangular matrix (directions + 1, directions); directions (n, directions + 1).
    real(wp), intent(in) :: h(:, :), basis(:, :)
    !> Number of directions.
    integer, intent(in) :: last
    !> On entry right-hand side, on return coefficients (directions + 1).
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

  !> Applies the previous Givens rotations to the new column of the Hessenberg matrix and eliminates its last entry.
  pure subroutine rotate(column, turn, share)
    !> New column (j+1).
    real(wp), intent(inout) :: column(:)
    !> Cosine and sine of each rotation (2, j); the last one is set.
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

  !> Records a residual; returns true if it is small enough, not finite, or decreases too slowly.
  logical function judged(residual, limits, outcome)
    !> Residual relative to the right-hand side.
    real(wp), intent(in) :: residual
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Result of the iterations.
    type(krylov_result_type), intent(inout) :: outcome
    !> Sweeps before the rate is checked.
    integer, parameter :: trial = 4

    outcome%residual = residual
    outcome%converged = residual <= limits%tolerance
    judged = outcome%converged .or. .not. ieee_is_finite(residual)
    if (judged .or. outcome%sweeps < trial .or. limits%rate >= 1.0_wp) return
    judged = residual > limits%rate**outcome%sweeps
  end function judged

  !> Checks the true residual, from which the recursive residual of conjugate gradients may deviate.
  subroutine confirm(matrix, rhs, x, limits, outcome)
    !> K.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Solution (n).
    real(wp), intent(in) :: x(:)
    !> Stopping criteria.
    type(krylov_limits_type), intent(in) :: limits
    !> Result of the iterations.
    type(krylov_result_type), intent(inout) :: outcome
    !> Factor by which the true residual may be larger.
    real(wp), parameter :: drift = 10.0_wp
    real(wp), allocatable :: product_vector(:)

    allocate (product_vector(size(rhs)))
    call multiply(matrix, x, product_vector)
    outcome%residual = norm2(rhs - product_vector)/norm2(rhs)
    outcome%converged = outcome%residual <= drift*limits%tolerance
  end subroutine confirm
end module qsmpm_krylov
