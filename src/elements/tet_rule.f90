!> Rules on the unit tetrahedron (xi, eta, zeta >= 0, sum <= 1). Weights sum to 1/6.
!>
!> Symmetric Gauss rules of 1, 4, 8 and 14 points, exact to degree 1, 2, 3 and 5; all points inside,
!> all weights positive. The figures of 8 points (two orbits of four) and of 14 (form of Walkington
!> 2000) are the solution of the moment equations to 19 digits. Higher degrees take the Gauss rule of
!> the cube with sides collapsed.
module qsmpm_tet_rule
  use qsmpm_kinds, only: wp
  use qsmpm_line_rule, only: line_gauss
  implicit none
  private

  public :: tet_gauss, tet_even, tet_degree

contains

  !> Gauss rule of a number of points: 1, 4, 8 or 14.
  pure subroutine tet_gauss(count, points, weights)
    !> Number of points.
    integer, intent(in) :: count
    !> Local coordinates (3, count); weights (count).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), parameter :: root5 = sqrt(5.0_wp)
    integer :: n

    allocate (points(3, count), weights(count))
    n = 0
    select case (count)
    case (1)
      points = 0.25_wp
      weights = 1.0_wp/6.0_wp
    case (4)
      call add_four((5.0_wp - root5)/20.0_wp, 0.25_wp, points, weights, n)
    case (8)
      call add_four(0.3280546967114265766_wp, 0.1385279665118637321_wp, points, weights, n)
      call add_four(0.1069522739329299185_wp, 0.1114720334881362679_wp, points, weights, n)
    case (14)
      call add_four(0.3108859192633006098_wp, 0.1126879257180158508_wp, points, weights, n)
      call add_four(0.09273525031089122640_wp, 0.07349304311636194954_wp, points, weights, n)
      call add_edges(0.04550370412564964949_wp, 0.04254602077708146644_wp, points, weights, n)
    end select
  end subroutine tet_gauss

  !> Centroids of eight equal pieces: the four corner tetrahedra, and the octahedron between them
  !> cut into four along its diagonal from the middle of edge 12 to the middle of edge 34.
  pure subroutine tet_even(points, weights)
    !> Local coordinates (3, 8); weights (8).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    ! Barycentric coordinates of the centroids times 8, without L1.
    integer, parameter :: eighths(3, 8) = reshape([1, 1, 1, 5, 1, 1, 1, 5, 1, 1, 1, 5, &
      1, 2, 2, 2, 1, 3, 3, 2, 2, 2, 3, 1], [3, 8])

    allocate (points(3, 8), weights(8))
    points = 0.125_wp*real(eighths, wp)
    weights = 1.0_wp/48.0_wp
  end subroutine tet_even

  !> Rule exact for polynomials of a degree.
  pure subroutine tet_degree(degree, points, weights)
    integer, intent(in) :: degree
    !> Local coordinates (3, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    integer, parameter :: counts(0:5) = [1, 1, 4, 14, 14, 14]

    if (degree <= ubound(counts, 1)) then
      call tet_gauss(counts(max(degree, 0)), points, weights)
    else
      call collapsed(degree, points, weights)
    end if
  end subroutine tet_degree

  !> Gauss rule of the cube under xi = u, eta = v (1-u), zeta = t (1-u) (1-v), all in [0, 1].
  pure subroutine collapsed(degree, points, weights)
    integer, intent(in) :: degree
    !> Local coordinates (3, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:)
    integer :: n, i, j, k, q

    ! The Jacobian (1-u)^2 (1-v) raises the degree in u by two.
    n = (degree + 4)/2
    call line_gauss(n, x, w)
    x = 0.5_wp*(1.0_wp + x)
    w = 0.5_wp*w
    allocate (points(3, n**3), weights(n**3))
    q = 0
    do k = 1, n
      do j = 1, n
        do i = 1, n
          q = q + 1
          points(:, q) = [x(i), x(j)*(1.0_wp - x(i)), x(k)*(1.0_wp - x(i))*(1.0_wp - x(j))]
          weights(q) = w(i)*w(j)*w(k)*(1.0_wp - x(i))**2*(1.0_wp - x(j))
        end do
      end do
    end do
  end subroutine collapsed

  !> Add the four points with barycentric coordinates (1-3a, a, a, a) in any order.
  pure subroutine add_four(a, weight, points, weights, n)
    !> The coordinate that occurs three times; weight of each as a share of the whole.
    real(wp), intent(in) :: a, weight
    !> The rule that grows.
    real(wp), intent(inout) :: points(:, :), weights(:)
    !> Points so far.
    integer, intent(inout) :: n
    integer :: i

    points(:, n + 1:n + 4) = a
    do i = 1, 3
      points(i, n + 1 + i) = 1.0_wp - 3.0_wp*a
    end do
    weights(n + 1:n + 4) = weight/6.0_wp
    n = n + 4
  end subroutine add_four

  !> Add the six points with barycentric coordinates (a, a, b, b), b = 1/2 - a, in any order.
  pure subroutine add_edges(a, weight, points, weights, n)
    !> The first coordinate of the pair; weight of each as a share of the whole.
    real(wp), intent(in) :: a, weight
    !> The rule that grows.
    real(wp), intent(inout) :: points(:, :), weights(:)
    !> Points so far.
    integer, intent(inout) :: n
    real(wp) :: b

    b = 0.5_wp - a
    points(:, n + 1:n + 6) = reshape( &
      [a, b, b, b, a, b, b, b, a, b, a, a, a, b, a, a, a, b], [3, 6])
    weights(n + 1:n + 6) = weight/6.0_wp
    n = n + 6
  end subroutine add_edges
end module qsmpm_tet_rule
