!> The matrix of the equations in compressed rows, and operations on it that need no factorisation: product, residual,
!> bandwidth, and the checks before a factorisation.
!>
!> For a symmetric matrix only the upper triangle may be stored (`symmetric`), which halves memory and assembly; a row
!> then begins with its diagonal. The columns of a row ascend. The rows are those of the active equations in
!> elimination order. Assembly is left to `equations`, factorisation to the extensions of `linear_solver`.
module qsmpm_sparse_matrix
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: sparse_matrix_type, multiply, bandwidth, entry_count, row_sums, first_not_finite

  !> A square matrix in compressed rows.
  type :: sparse_matrix_type
    !> Number of rows.
    integer :: n = 0
    !> Whether only the entries on and above the diagonal are stored.
    logical :: symmetric = .false.
    !> Position in `column` and `values` where each row begins (n+1); the last one is the count plus one.
    integer, allocatable :: row_first(:)
    !> Column of each entry, increasing in a row.
    integer, allocatable :: column(:)
    !> Value of each entry.
    real(wp), allocatable :: values(:)
  end type sparse_matrix_type

contains

  !> Computes the product y = A x.
  pure subroutine multiply(matrix, x, y)
    type(sparse_matrix_type), intent(in) :: matrix
    !> Vector (n).
    real(wp), intent(in) :: x(:)
    !> Product (n).
    real(wp), intent(out) :: y(:)

    integer :: i, k
    real(wp) :: total

    if (matrix%symmetric) then
      call multiply_triangle(matrix, x, y)
      return
    end if
    do i = 1, matrix%n
      total = 0.0_wp
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        total = total + matrix%values(k)*x(matrix%column(k))
      end do
      y(i) = total
    end do
  end subroutine multiply

  !> Computes the product with a symmetric matrix of which the upper triangle is stored.
  pure subroutine multiply_triangle(matrix, x, y)
    !> The matrix A; every row begins with its diagonal.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Vector (n).
    real(wp), intent(in) :: x(:)
    !> Product (n).
    real(wp), intent(out) :: y(:)

    integer :: i, j, k
    real(wp) :: total

    y = 0.0_wp
    do i = 1, matrix%n
      k = matrix%row_first(i)
      total = y(i) + matrix%values(k)*x(i)
      do k = matrix%row_first(i) + 1, matrix%row_first(i + 1) - 1
        j = matrix%column(k)
        total = total + matrix%values(k)*x(j)
        y(j) = y(j) + matrix%values(k)*x(i)
      end do
      y(i) = total
    end do
  end subroutine multiply_triangle

  !> Returns the largest distance of an entry from the diagonal; 0 for a diagonal matrix.
  pure integer function bandwidth(matrix)
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

  !> Returns the number of entries in both triangles.
  pure integer function entry_count(matrix)
    type(sparse_matrix_type), intent(in) :: matrix

    entry_count = matrix%row_first(matrix%n + 1) - 1
    if (matrix%symmetric) entry_count = 2*entry_count - matrix%n
  end function entry_count

  !> Computes the sums of absolute values of the rows.
  pure subroutine row_sums(matrix, sums)
    type(sparse_matrix_type), intent(in) :: matrix
    !> One sum per row (n).
    real(wp), intent(out) :: sums(:)

    integer :: i, j, k

    sums = 0.0_wp
    do i = 1, matrix%n
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        j = matrix%column(k)
        sums(i) = sums(i) + abs(matrix%values(k))
        if (matrix%symmetric .and. j /= i) sums(j) = sums(j) + abs(matrix%values(k))
      end do
    end do
  end subroutine row_sums

  !> Returns the first row that contains a NaN or an infinity; 0 if there is none.
  pure integer function first_not_finite(matrix)
    type(sparse_matrix_type), intent(in) :: matrix

    integer :: i

    do i = 1, matrix%n
      if (all(ieee_is_finite(matrix%values(matrix%row_first(i):matrix%row_first(i + 1) - 1)))) cycle
      first_not_finite = i
      return
    end do
    first_not_finite = 0
  end function first_not_finite
end module qsmpm_sparse_matrix
