!> Quadrature rules on the line [-1, 1]: Gauss-Legendre, and midpoints of equal intervals. Weights sum to 2.
module qsmpm_line_rule
  use qsmpm_kinds, only: wp, pi
  implicit none
  private

  public :: line_gauss, line_even

contains

  !> Computes the Gauss-Legendre rule, exact to degree 2n-1: the roots x of the Legendre polynomial P_n and w = 2 / ((1
  !> - x^2) P_n'(x)^2), in ascending order.
  pure subroutine line_gauss(n, points, weights)
    !> Number of points.
    integer, intent(in) :: n
    !> Coordinates in [-1, 1], and weights.
    real(wp), allocatable, intent(out) :: points(:), weights(:)
    ! Newton's method doubles the correct digits per step; from the cosine start four steps reach round-off for any n.
    integer, parameter :: newton_steps = 6
    real(wp) :: x, value, slope
    integer :: i, step

    allocate (points(n), weights(n))
    do i = 1, (n + 1)/2
      x = cos(pi*(real(i, wp) - 0.25_wp)/(real(n, wp) + 0.5_wp))
      if (2*i - 1 == n) x = 0.0_wp
      do step = 1, newton_steps
        call legendre(n, x, value, slope)
        x = x - value/slope
      end do
      call legendre(n, x, value, slope)
      points(i) = -x
      points(n + 1 - i) = x
      weights(i) = 2.0_wp/((1.0_wp - x*x)*slope*slope)
      weights(n + 1 - i) = weights(i)
    end do
  end subroutine line_gauss

  !> Evaluates the Legendre polynomial and its derivative by the three-term recurrence, |x| < 1.
  pure subroutine legendre(n, x, value, slope)
    !> Degree, at least 1.
    integer, intent(in) :: n
    !> Coordinate.
    real(wp), intent(in) :: x
    !> P_n(x); P_n'(x).
    real(wp), intent(out) :: value, slope
    real(wp) :: before, next
    integer :: k

    before = 1.0_wp
    value = x
    do k = 2, n
      next = (real(2*k - 1, wp)*x*value - real(k - 1, wp)*before)/real(k, wp)
      before = value
      value = next
    end do
    slope = real(n, wp)*(before - x*value)/(1.0_wp - x*x)
  end subroutine legendre

  !> Computes the rule of the midpoints of n equal intervals.
  pure subroutine line_even(n, points, weights)
    !> Number of intervals.
    integer, intent(in) :: n
    !> Coordinates in [-1, 1], and weights.
    real(wp), allocatable, intent(out) :: points(:), weights(:)
    integer :: i

    allocate (points(n), weights(n))
    do i = 1, n
      points(i) = real(2*i - 1 - n, wp)/real(n, wp)
      weights(i) = 2.0_wp/real(n, wp)
    end do
  end subroutine line_even
end module qsmpm_line_rule
