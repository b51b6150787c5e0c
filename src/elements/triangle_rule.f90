!> Rules on the unit triangle (xi, eta >= 0, xi + eta <= 1). Weights sum to 1/2.
!>
!> Symmetric Gauss rules of 1, 3, 6, 7 and 12 points, exact to degree 1, 2, 4, 5 and 6 (Strang and
!> Fix 1973, Dunavant 1985); all points inside, all weights positive. The 6 and 7 point rules are
!> closed forms; the 12 point figures are the solution of the moment equations to 19 digits.
!> Higher degrees take the Gauss rule of the square with one side collapsed, and so do 4, 9 and 16
!> points, exact to degree 2, 4 and 6.
module qsmpm_triangle_rule
  use qsmpm_kinds, only: wp
  use qsmpm_line_rule, only: line_gauss
  implicit none
  private

  public :: triangle_gauss, triangle_even, triangle_degree

  real(wp), parameter :: third = 1.0_wp/3.0_wp
  real(wp), parameter :: root10 = sqrt(10.0_wp)
  real(wp), parameter :: root15 = sqrt(15.0_wp)

contains

  !> Gauss rule of a number of points: 1, 3, 4, 6, 7, 9, 12 or 16.
  pure subroutine triangle_gauss(count, points, weights)
    !> Number of points.
    integer, intent(in) :: count
    !> Local coordinates (2, count); weights (count).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), parameter :: root6 = sqrt(38.0_wp - 44.0_wp*sqrt(0.4_wp))
    real(wp), parameter :: weight6 = sqrt(213125.0_wp - 53320.0_wp*root10)
    integer :: n

    n = nint(sqrt(real(count, wp)))
    if (n > 1 .and. n*n == count) then
      call collapsed(2*n - 2, points, weights)
      return
    end if
    allocate (points(2, count), weights(count))
    n = 0
    select case (count)
    case (1)
      call add_centre(1.0_wp, points, weights, n)
    case (3)
      call add_three(1.0_wp/6.0_wp, third, points, weights, n)
    case (6)
      call add_three((8.0_wp - root10 + root6)/18.0_wp, (620.0_wp + weight6)/3720.0_wp, points, weights, n)
      call add_three((8.0_wp - root10 - root6)/18.0_wp, (620.0_wp - weight6)/3720.0_wp, points, weights, n)
    case (7)
      call add_centre(9.0_wp/40.0_wp, points, weights, n)
      call add_three((6.0_wp - root15)/21.0_wp, (155.0_wp - root15)/1200.0_wp, points, weights, n)
      call add_three((6.0_wp + root15)/21.0_wp, (155.0_wp + root15)/1200.0_wp, points, weights, n)
    case (12)
      call add_three(0.2492867451709104213_wp, 0.1167862757263793660_wp, points, weights, n)
      call add_three(0.06308901449150222834_wp, 0.05084490637020681692_wp, points, weights, n)
      call add_six(0.05314504984481694735_wp, 0.3103524510337844054_wp, 0.08285107561837357519_wp, points, weights, n)
    end select
  end subroutine triangle_gauss

  !> Centroids of n x n equal sub-triangles, rows of rising eta.
  pure subroutine triangle_even(n, points, weights)
    !> Number of pieces of a side.
    integer, intent(in) :: n
    !> Local coordinates (2, n*n); weights (n*n).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    integer :: i, j, k

    allocate (points(2, n*n), weights(n*n))
    weights = 0.5_wp/real(n*n, wp)
    k = 0
    do j = 0, n - 1
      do i = 0, n - 1 - j
        k = k + 1
        points(:, k) = ([real(i, wp), real(j, wp)] + third)/real(n, wp)
        if (i + j > n - 2) cycle
        k = k + 1
        points(:, k) = ([real(i, wp), real(j, wp)] + 2.0_wp*third)/real(n, wp)
      end do
    end do
  end subroutine triangle_even

  !> Rule exact for polynomials of a degree.
  pure subroutine triangle_degree(degree, points, weights)
    integer, intent(in) :: degree
    !> Local coordinates (2, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    integer, parameter :: counts(0:6) = [1, 1, 3, 6, 6, 7, 12]

    if (degree <= ubound(counts, 1)) then
      call triangle_gauss(counts(max(degree, 0)), points, weights)
    else
      call collapsed(degree, points, weights)
    end if
  end subroutine triangle_degree

  !> Gauss rule of the square under xi = u, eta = v (1 - u), u and v in [0, 1].
  pure subroutine collapsed(degree, points, weights)
    integer, intent(in) :: degree
    !> Local coordinates (2, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:)
    integer :: n, i, j, k

    ! The Jacobian 1 - u raises the degree in u by one.
    n = (degree + 1)/2 + 1
    call line_gauss(n, x, w)
    allocate (points(2, n*n), weights(n*n))
    do j = 1, n
      do i = 1, n
        k = n*(j - 1) + i
        points(1, k) = 0.5_wp*(1.0_wp + x(i))
        points(2, k) = 0.25_wp*(1.0_wp + x(j))*(1.0_wp - x(i))
        weights(k) = 0.125_wp*w(i)*w(j)*(1.0_wp - x(i))
      end do
    end do
  end subroutine collapsed

  !> Add the centroid.
  pure subroutine add_centre(weight, points, weights, n)
    !> Weight as a share of the whole.
    real(wp), intent(in) :: weight
    !> The rule that grows.
    real(wp), intent(inout) :: points(:, :), weights(:)
    !> Points so far.
    integer, intent(inout) :: n

    n = n + 1
    points(:, n) = third
    weights(n) = 0.5_wp*weight
  end subroutine add_centre

  !> Add the three points with barycentric coordinates (1-2a, a, a) in any order.
  pure subroutine add_three(a, weight, points, weights, n)
    !> The coordinate that occurs twice; weight of each as a share of the whole.
    real(wp), intent(in) :: a, weight
    !> The rule that grows.
    real(wp), intent(inout) :: points(:, :), weights(:)
    !> Points so far.
    integer, intent(inout) :: n

    points(:, n + 1) = [a, a]
    points(:, n + 2) = [1.0_wp - 2.0_wp*a, a]
    points(:, n + 3) = [a, 1.0_wp - 2.0_wp*a]
    weights(n + 1:n + 3) = 0.5_wp*weight
    n = n + 3
  end subroutine add_three

  !> Add the six points with barycentric coordinates (a, b, 1-a-b) in any order.
  pure subroutine add_six(a, b, weight, points, weights, n)
    !> Two of the three coordinates.
    real(wp), intent(in) :: a, b
    !> Weight of each as a share of the whole.
    real(wp), intent(in) :: weight
    !> The rule that grows.
    real(wp), intent(inout) :: points(:, :), weights(:)
    !> Points so far.
    integer, intent(inout) :: n
    real(wp) :: c

    c = 1.0_wp - a - b
    points(:, n + 1:n + 6) = reshape([a, b, b, a, a, c, c, a, b, c, c, b], [2, 6])
    weights(n + 1:n + 6) = 0.5_wp*weight
    n = n + 6
  end subroutine add_six
end module qsmpm_triangle_rule
