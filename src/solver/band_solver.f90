!> LAPACK band solver: Cholesky (dpbtrf) for symmetric positive definite matrices, LU with partial pivoting (dgbtrf)
!> for others. It is suitable for one dimension and for very small bandwidths; memory is n times the bandwidth, so the
!> equations must be numbered by `order_bandwidth`.
module qsmpm_band_solver
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_sparse_matrix, only: sparse_matrix_type, bandwidth
  use qsmpm_linear_solver, only: linear_solver_type, pivot_floor, singular_at, indefinite_at
  implicit none
  private

  public :: make_band_solver

  !> Band matrix and its factors.
  type, extends(linear_solver_type) :: band_solver_type
    private
    !> Half bandwidth k, excluding the diagonal.
    integer :: half = 0
    !> Symmetric: lower band, a(i,j) at (1+i-j, j), (k+1, n). Otherwise LAPACK's general band, a(i,j) at (2k+1+i-j, j),
    !> (3k+1, n).
    real(wp), allocatable :: band(:, :)
    !> Row exchanges (n).
    integer, allocatable :: exchanged(:)
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
  end type band_solver_type

  interface
    !> Computes the Cholesky factors of a symmetric band matrix.
    subroutine dpbtrf(uplo, n, kd, ab, ldab, info)
      import :: wp
      character, intent(in) :: uplo
      integer, intent(in) :: n, kd, ldab
      real(wp), intent(inout) :: ab(ldab, *)
      integer, intent(out) :: info
    end subroutine dpbtrf

    !> Solves with the factors of dpbtrf.
    subroutine dpbtrs(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
      import :: wp
      character, intent(in) :: uplo
      integer, intent(in) :: n, kd, nrhs, ldab, ldb
      real(wp), intent(in) :: ab(ldab, *)
      real(wp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dpbtrs

    !> Computes the LU factors of a general band matrix.
    subroutine dgbtrf(m, n, kl, ku, ab, ldab, ipiv, info)
      import :: wp
      integer, intent(in) :: m, n, kl, ku, ldab
      real(wp), intent(inout) :: ab(ldab, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgbtrf

    !> Solves with the factors of dgbtrf.
    subroutine dgbtrs(trans, n, kl, ku, nrhs, ab, ldab, ipiv, b, ldb, info)
      import :: wp
      character, intent(in) :: trans
      integer, intent(in) :: n, kl, ku, nrhs, ldab, ldb
      real(wp), intent(in) :: ab(ldab, *)
      integer, intent(in) :: ipiv(*)
      real(wp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dgbtrs
  end interface

contains

  !> Creates a band solver.
  subroutine make_band_solver(symmetric, solver)
    !> Whether Cholesky is used.
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (band_solver_type :: solver)
    solver%name = 'band (LAPACK)'
    solver%symmetric = symmetric
  end subroutine make_band_solver

  !> Finds the bandwidth and allocates the band.
  subroutine analyse_pattern(self, matrix, error)
    class(band_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer :: rows, status

    if (allocated(self%band)) deallocate (self%band, self%exchanged)
    self%half = bandwidth(matrix)
    rows = 3*self%half + 1
    if (self%symmetric) rows = self%half + 1
    allocate (self%band(rows, matrix%n), self%exchanged(matrix%n), stat=status)
    if (status /= 0) call fail(error, error_other, 'no memory for the band of the matrix')
  end subroutine analyse_pattern

  !> Fills the band and factorises it.
  subroutine factorise_values(self, matrix, error)
    class(band_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: largest(matrix%n)

    self%factor_nonzeros = size(self%band, kind=long)
    call fill_band(self, matrix, largest)
    self%factor_operations = operations(matrix%n, self%half, self%symmetric)
    if (self%symmetric) then
      call factorise_symmetric(self, error)
    else
      call factorise_general(self, largest, error)
    end if
  end subroutine factorise_values

  !> Returns the number of multiplications, additions and divisions; for a general matrix without row exchanges.
  pure real(wp) function operations(n, half, symmetric)
    !> Number of equations.
    integer, intent(in) :: n
    !> Half bandwidth.
    integer, intent(in) :: half
    logical, intent(in) :: symmetric

    operations = real(n, wp)*(2.0_wp*half + 1.0_wp)*half
    if (symmetric) operations = real(n, wp)*(half + 1.0_wp)**2
  end function operations

  !> Copies the rows to the band. The rows above it, filled by row exchanges, are cleared by LAPACK.
  pure subroutine fill_band(self, matrix, largest)
    class(band_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    !> Largest absolute value of each column (n).
    real(wp), intent(out) :: largest(:)

    integer :: i, j, k

    self%band(merge(1, self%half + 1, self%symmetric):, :) = 0.0_wp
    largest = 0.0_wp
    do i = 1, matrix%n
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        j = matrix%column(k)
        largest(j) = max(largest(j), abs(matrix%values(k)))
        if (.not. self%symmetric) then
          self%band(2*self%half + 1 + i - j, j) = matrix%values(k)
        else if (j >= i) then
          self%band(1 + j - i, i) = matrix%values(k)
        end if
      end do
    end do
  end subroutine fill_band

  !> Computes the Cholesky factors; a pivot l(i,i)**2 is checked relative to its diagonal entry.
  subroutine factorise_symmetric(self, error)
    class(band_solver_type), intent(inout) :: self
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: diagonal(size(self%band, 2)), floor_share
    integer :: i, n, info

    n = size(self%band, 2)
    diagonal = self%band(1, :)
    call dpbtrf('L', n, self%half, self%band, self%half + 1, info)
    if (info > 0) then
      self%indefinite = .true.
      call indefinite_at(info, error)
      return
    end if
    self%negative_pivots = 0
    floor_share = pivot_floor(n)
    do i = 1, n
      if (self%band(1, i)**2 > floor_share*diagonal(i)) cycle
      call singular_at(i, error)
      return
    end do
  end subroutine factorise_symmetric

  !> Computes the LU factors; a pivot u(j,j) is checked relative to the largest entry of its column.
  subroutine factorise_general(self, largest, error)
    class(band_solver_type), intent(inout) :: self
    !> Largest absolute value of each column (n).
    real(wp), intent(in) :: largest(:)
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: floor_share
    integer :: j, n, info

    n = size(self%band, 2)
    call dgbtrf(n, n, self%half, self%half, self%band, size(self%band, 1), self%exchanged, info)
    floor_share = pivot_floor(n)
    do j = 1, n
      if (abs(self%band(2*self%half + 1, j)) > floor_share*largest(j)) cycle
      call singular_at(j, error)
      return
    end do
  end subroutine factorise_general

  !> Solves by forward and backward substitution.
  subroutine solve_factorised(self, rhs, x, error)
    class(band_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: work(size(rhs), 1)
    integer :: n, info

    n = size(rhs)
    work(:, 1) = rhs
    if (self%symmetric) then
      call dpbtrs('L', n, self%half, 1, self%band, self%half + 1, work, n, info)
    else
      call dgbtrs('N', n, self%half, self%half, 1, self%band, size(self%band, 1), self%exchanged, &
        work, n, info)
    end if
    if (info /= 0) call fail(error, error_other, 'LAPACK refused the band solve')
    x = work(:, 1)
  end subroutine solve_factorised
end module qsmpm_band_solver
