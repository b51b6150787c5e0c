!> The matrix of the equations in compressed rows, and the few operations on it that need no
!> factorisation: product, residual, bandwidth, and the checks that come before a factorisation.
!>
!> Both triangles are stored whatever the symmetry, the columns of a row in increasing order. The
!> rows are those of the active equations in elimination order. Assembly is left to `equations`,
!> factorisation to the back ends of `linear_solver`.
module qsmpm_sparse_matrix
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: sparse_matrix_type, multiply, residual_norm, bandwidth, row_sum_norm, &
    first_not_finite, first_zero_row

  !> A square matrix in compressed rows.
  type :: sparse_matrix_type
    !> Number of rows.
    integer :: n = 0
    !> Place in `column` and `values` where each row begins (n+1); the last is the count plus one.
    integer, allocatable :: row_first(:)
    !> Column of each entry, increasing in a row.
    integer, allocatable :: column(:)
    !> Value of each entry.
    real(wp), allocatable :: values(:)
  end type sparse_matrix_type

contains

  !> Product y = A x.
  pure subroutine multiply(matrix, x, y)
    !> The matrix A.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Vector (n).
    real(wp), intent(in) :: x(:)
    !> Product (n).
    real(wp), intent(out) :: y(:)

    integer :: i, k
    real(wp) :: total

    do i = 1, matrix%n
      total = 0.0_wp
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        total = total + matrix%values(k)*x(matrix%column(k))
      end do
      y(i) = total
    end do
  end subroutine multiply

  !> Euclidean norm of b - A x.
  pure real(wp) function residual_norm(matrix, x, rhs)
    !> The matrix A.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Solution to judge (n).
    real(wp), intent(in) :: x(:)
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)

    real(wp) :: product_vector(matrix%n)

    call multiply(matrix, x, product_vector)
    residual_norm = norm2(rhs(:matrix%n) - product_vector)
  end function residual_norm

  !> Largest distance of an entry from the diagonal; 0 for a diagonal matrix.
  pure integer function bandwidth(matrix)
    !> The matrix.
    type(sparse_matrix_type), intent(in) :: matrix

    integer :: i, first, last

    bandwidth = 0
    do i = 1, matrix%n
      first = matrix%row_first(i)
      last = matrix%row_first(i + 1) - 1
      if (last < first) cycle
      bandwidth = max(bandwidth, i - matrix%column(first), matrix%column(last) - i)
    end do
  end function bandwidth

  !> Largest sum of absolute values in a row.
  pure real(wp) function row_sum_norm(matrix)
    !> The matrix.
    type(sparse_matrix_type), intent(in) :: matrix

    integer :: i

    row_sum_norm = 0.0_wp
    do i = 1, matrix%n
      row_sum_norm = max(row_sum_norm, &
        sum(abs(matrix%values(matrix%row_first(i):matrix%row_first(i + 1) - 1))))
    end do
  end function row_sum_norm

  !> First row that holds a NaN or an infinity; 0 when there is none.
  pure integer function first_not_finite(matrix)
    !> The matrix.
    type(sparse_matrix_type), intent(in) :: matrix

    integer :: i

    do i = 1, matrix%n
      if (all(ieee_is_finite(matrix%values(matrix%row_first(i):matrix%row_first(i + 1) - 1)))) cycle
      first_not_finite = i
      return
    end do
    first_not_finite = 0
  end function first_not_finite

  !> First row that is empty or holds zeros only; 0 when there is none.
  pure integer function first_zero_row(matrix)
    !> The matrix, of finite values.
    type(sparse_matrix_type), intent(in) :: matrix

    integer :: i

    do i = 1, matrix%n
      if (any(abs(matrix%values(matrix%row_first(i):matrix%row_first(i + 1) - 1)) > 0.0_wp)) cycle
      first_zero_row = i
      return
    end do
    first_zero_row = 0
  end function first_zero_row
end module qsmpm_sparse_matrix
