!> Least-squares polynomials over a patch of points: products of Legendre polynomials P_i(x) P_j(y) P_k(z) of total
!> degree i + j + k up to 3, those of low degree first, in coordinates about the centre of the patch over its extent.
!>
!>   (sum V z z' / sum V) c = sum V z y / sum V,   z = (1, x, y, .., P_2(x), x y, ..)
!>
!> A term that the points cannot tell from those before it is left out: a direction in which they do not spread gets
!> no slope, three points in a row no cubic term. Legendre's polynomials keep the matrix near the identity for points
!> that fill the patch.
module qsmpm_patch_polynomial
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: term_count, patch_terms, solve_patch

  !> Highest total degree, and terms of it in space.
  integer, parameter, public :: most_degree = 3, most_terms = 20
  !> Least mean square, over the patch, of what is left of a term when the terms before it are taken away. Two points a
  !> direction in one cell leave 0.06 of a slope, three 0.006 of P_2.
  real(wp), parameter :: least_left = 1.0e-3_wp

contains

  !> Terms of total degree up to `degree`.
  pure integer function term_count(dimension, degree)
    integer, intent(in) :: dimension, degree

    term_count = ((degree + 1)*(degree + 2))/2
    if (dimension == 3) term_count = (term_count*(degree + 3))/3
  end function term_count

  !> Values of the terms at a place.
  pure subroutine patch_terms(x, degree, z)
    !> Coordinates about the centre of the patch over its extent (dimension).
    real(wp), intent(in) :: x(:)
    integer, intent(in) :: degree
    !> (term_count)
    real(wp), intent(out) :: z(:)
    real(wp) :: legendre(0:most_degree, 3)
    integer :: i, j, k, total, n

    legendre = 0.0_wp
    legendre(0, :) = 1.0_wp
    legendre(1, :size(x)) = x
    legendre(2, :size(x)) = 0.5_wp*(3.0_wp*x**2 - 1.0_wp)
    legendre(3, :size(x)) = 0.5_wp*x*(5.0_wp*x**2 - 3.0_wp)
    n = 0
    do total = 0, degree
      do i = total, 0, -1
        do j = total - i, 0, -1
          k = total - i - j
          if (k > 0 .and. size(x) == 2) cycle
          n = n + 1
          z(n) = legendre(i, 1)*legendre(j, 2)*legendre(k, 3)
        end do
      end do
    end do
  end subroutine patch_terms

  !> Coefficients of the terms: within a degree the term of which most is left goes first, as long as enough is left.
  pure subroutine solve_patch(dimension, degree, matrix, coefficients)
    integer, intent(in) :: dimension, degree
    !> Mean products of the terms (terms, terms), destroyed.
    real(wp), intent(inout) :: matrix(:, :)
    !> Mean products of terms and values, then the coefficients (values, terms).
    real(wp), intent(inout) :: coefficients(:, :)
    logical :: taken(size(matrix, 1))
    integer :: total, first, last, k, j

    taken = .false.
    first = 1
    do total = 0, degree
      last = term_count(dimension, total)
      do
        k = 0
        do j = first, last
          if (taken(j) .or. matrix(j, j) < least_left) cycle
          if (k == 0) k = j
          if (matrix(j, j) > matrix(k, k)) k = j
        end do
        if (k == 0) exit
        taken(k) = .true.
        call eliminate(k, matrix, coefficients)
      end do
      first = last + 1
    end do
    do j = 1, size(taken)
      if (.not. taken(j)) coefficients(:, j) = 0.0_wp
    end do
  end subroutine solve_patch

  !> One step of Gauss-Jordan's elimination.
  pure subroutine eliminate(k, matrix, coefficients)
    !> The pivot.
    integer, intent(in) :: k
    real(wp), intent(inout) :: matrix(:, :), coefficients(:, :)
    real(wp) :: factor
    integer :: i

    factor = 1.0_wp/matrix(k, k)
    matrix(k, :) = matrix(k, :)*factor
    coefficients(:, k) = coefficients(:, k)*factor
    do i = 1, size(matrix, 1)
      if (i == k) cycle
      factor = matrix(i, k)
      matrix(i, :) = matrix(i, :) - factor*matrix(k, :)
      coefficients(:, i) = coefficients(:, i) - factor*coefficients(:, k)
    end do
  end subroutine eliminate
end module qsmpm_patch_polynomial
