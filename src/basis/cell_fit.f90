!> Fit of the state of a cell: volume-weighted least squares of the averaging fields of the law and of ln J over the
!> points of a full cell, linear in the cell or quadratic for cubic splines.
!>
!>   ( sum V z z' / sum V + diag(0, r, .., r) ) c = sum V z y / sum V,   z = (1, centred local coordinates)
!>
!> The ridge r suppresses the slope if the points of a cell are collinear. docs/methods/cell_integration.md.
module qsmpm_cell_fit
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, local_centre
  use qsmpm_points, only: points_type
  use qsmpm_law, only: law_slot_type
  implicit none
  private

  public :: fit_cell, monomials, monomial_count

  !> Ridge of the fit, small compared with the value 1/36 of evenly distributed points.
  real(wp), parameter :: ridge = 1.0e-5_wp
  !> A point is counted as inaccurate if its field differs from the fit by more than this fraction.
  real(wp), parameter :: inaccurate_share = 0.1_wp

contains

  !> Computes the coefficients of the fit; the last field is ln J.
  subroutine fit_cell(kind, points, slot, chosen, coefficients, inaccurate)
    !> Element kind of the cell.
    integer, intent(in) :: kind
    type(points_type), intent(in) :: points
    type(law_slot_type), intent(in) :: slot
    !> Material points of the cell.
    integer, intent(in) :: chosen(:)
    !> (monomials, fields + 1).
    real(wp), intent(out) :: coefficients(:, :)
    !> Number of inaccurate points, incremented.
    integer, intent(inout) :: inaccurate
    real(wp) :: normal(size(coefficients, 1), size(coefficients, 1)), z(size(coefficients, 1))
    real(wp), allocatable :: y(:, :), monomial(:, :)
    real(wp) :: volume
    integer :: p, k, n, last, i

    n = size(chosen)
    last = size(coefficients, 2)
    allocate (y(last, n), monomial(size(z), n))
    normal = 0.0_wp
    coefficients = 0.0_wp
    volume = 0.0_wp
    do k = 1, n
      p = chosen(k)
      z = monomials(kind, points%local(:, p), size(z))
      call slot%law%to_fields(points%stress(:, p), points%state(:slot%law%state_count, p), y(:last - 1, k))
      y(last, k) = log(points%volume(p)/points%initial_volume(p))
      monomial(:, k) = z
      volume = volume + points%volume(p)
      do i = 1, size(z)
        normal(:, i) = normal(:, i) + points%volume(p)*z*z(i)
      end do
      do i = 1, last
        coefficients(:, i) = coefficients(:, i) + points%volume(p)*z*y(i, k)
      end do
    end do
    normal = normal/volume
    coefficients = coefficients/volume
    do i = 2, size(z)
      normal(i, i) = normal(i, i) + ridge
    end do
    call solve_small(normal, coefficients)
    inaccurate = inaccurate + count_inaccurate(y, monomial, coefficients)
  end subroutine fit_cell

  !> Number of points whose averaged fields differ from the fit by more than a fraction of the largest value.
  pure integer function count_inaccurate(y, monomial, coefficients) result(inaccurate)
    !> Fields (fields + 1, n) and monomials (m, n) of the points, and the fit.
    real(wp), intent(in) :: y(:, :), monomial(:, :), coefficients(:, :)
    real(wp) :: scale
    integer :: k, fields

    inaccurate = 0
    fields = size(y, 1) - 1
    scale = maxval(sqrt(sum(y(:fields, :)**2, dim=1)))
    do k = 1, size(y, 2)
      if (norm2(y(:fields, k) - matmul(monomial(:, k), coefficients(:, :fields))) &
        > inaccurate_share*scale) inaccurate = inaccurate + 1
    end do
  end function count_inaccurate

  !> Monomials: 1, the local coordinates relative to the centre of the cell, halved if they range from -1 to 1, and
  !> their products for a quadratic fit.
  pure function monomials(kind, local, count) result(z)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    !> Number of monomials.
    integer, intent(in) :: count
    real(wp) :: z(count)
    integer :: i, j, n

    n = 1 + size(local)
    z(1) = 1.0_wp
    z(2:n) = 0.5_wp*(local - local_centre(kind))
    if (corner_count(kind) == size(local) + 1) z(2:n) = 2.0_wp*z(2:n)
    if (corner_count(kind) == 6) z(2:3) = 2.0_wp*z(2:3)
    if (count == n) return
    do j = 2, 1 + size(local)
      do i = 2, j
        n = n + 1
        z(n) = z(i)*z(j)
      end do
    end do
  end function monomials

  !> Number of monomials of a complete polynomial.
  pure integer function monomial_count(dimension, order)
    !> 2 or 3, and order 1 or 2.
    integer, intent(in) :: dimension, order

    monomial_count = 1 + dimension
    if (order == 2) monomial_count = monomial_count + dimension*(dimension + 1)/2
  end function monomial_count

  !> Solves a small symmetric positive definite system in place (Cholesky).
  pure subroutine solve_small(matrix, rhs)
    !> Matrix (n,n), destroyed.
    real(wp), intent(inout) :: matrix(:, :)
    !> Right-hand sides (n,m), solution on return.
    real(wp), intent(inout) :: rhs(:, :)
    integer :: i, j, n

    n = size(matrix, 1)
    do j = 1, n
      matrix(j, j) = sqrt(matrix(j, j) - dot_product(matrix(j, :j - 1), matrix(j, :j - 1)))
      do i = j + 1, n
        matrix(i, j) = (matrix(i, j) - dot_product(matrix(i, :j - 1), matrix(j, :j - 1)))/matrix(j, j)
      end do
    end do
    do i = 1, n
      rhs(i, :) = (rhs(i, :) - matmul(matrix(i, :i - 1), rhs(:i - 1, :)))/matrix(i, i)
    end do
    do i = n, 1, -1
      rhs(i, :) = (rhs(i, :) - matmul(matrix(i + 1:, i), rhs(i + 1:, :)))/matrix(i, i)
    end do
  end subroutine solve_small
end module qsmpm_cell_fit
