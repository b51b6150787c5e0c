!> Quadrature rules on the line [-1, 1]: Gauss-Legendre, and midpoints of equal intervals, whose weights sum to 2; and
!> products of rules on squares, cubes and layers.
module qsmpm_line_rule
  use qsmpm_kinds, only: wp, pi
  implicit none
  private

  public :: line_gauss, line_even, square_rule, cube_rule, layer_rule

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

    points = [(real(2*i - 1 - n, wp)/real(n, wp), i=1, n)]
    weights = [(2.0_wp/real(n, wp), i=1, n)]
  end subroutine line_even

  !> Computes the product of a line rule with itself.
  pure subroutine square_rule(x, w, points, weights)
    !> Points and weights of the line rule.
    real(wp), intent(in) :: x(:), w(:)
    !> Local coordinates (2, n**2); weights (n**2).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    integer :: i, j, q

    allocate (points(2, size(x)**2), weights(size(x)**2))
    do j = 1, size(x)
      do i = 1, size(x)
        q = size(x)*(j - 1) + i
        points(:, q) = [x(i), x(j)]
        weights(q) = w(i)*w(j)
      end do
    end do
  end subroutine square_rule

  !> Computes the threefold product of a line rule with itself.
  pure subroutine cube_rule(x, w, points, weights)
    !> Points and weights of the line rule.
    real(wp), intent(in) :: x(:), w(:)
    !> Local coordinates (3, n**3); weights (n**3).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: square(:, :), square_weights(:)

    call square_rule(x, w, square, square_weights)
    call layer_rule(square, square_weights, x, w, points, weights)
  end subroutine cube_rule

  !> Computes the product of a plane rule and a line rule along zeta.
  pure subroutine layer_rule(plane, plane_weights, x, w, points, weights)
    !> Points (2, m) and weights of the plane rule.
    real(wp), intent(in) :: plane(:, :), plane_weights(:)
    !> Points and weights of the line rule.
    real(wp), intent(in) :: x(:), w(:)
    !> Local coordinates (3, m*n); weights (m*n).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    integer :: k, m, first

    m = size(plane_weights)
    allocate (points(3, m*size(x)), weights(m*size(x)))
    do k = 1, size(x)
      first = m*(k - 1)
      points(1:2, first + 1:first + m) = plane
      points(3, first + 1:first + m) = x(k)
      weights(first + 1:first + m) = plane_weights*w(k)
    end do
  end subroutine layer_rule
end module qsmpm_line_rule
