!> Quadrature rules on the unit triangle and the unit tetrahedron (local coordinates not negative, their sum at most 1).
!> Weights sum to 1/2 and 1/6.
!>
!> Symmetric Gauss rules with all points inside and all weights positive: for triangles 1, 3, 6, 7 and 12 points, exact
!> to degree 1, 2, 4, 5 and 6 (Strang and Fix 1973, Dunavant 1985); for tetrahedra 1, 4, 8 and 14 points, exact to
!> degree 1, 2, 3 and 5. The 6- and 7-point rules of triangles are closed forms; the numbers of the 12-point rule and of
!> the 8- and 14-point rules of tetrahedra (two orbits of four; form of Walkington 2000) are the solution of the moment
!> equations to 19 digits. Higher degrees use the Gauss rule of the square or cube with collapsed sides, and so do 4, 9
!> and 16 points of triangles, exact to degree 2, 4 and 6.
module qsmpm_simplex_rule
  use qsmpm_kinds, only: wp
  use qsmpm_line_rule, only: line_gauss, square_rule, cube_rule
  implicit none
  private

  public :: simplex_gauss, simplex_degree, triangle_even, tet_even

  !> Orbit: points whose barycentric coordinates are permutations of each other: the centre; (1 - d a, a, a ..); for
  !> triangles six of (a, b, 1 - a - b), for tetrahedra six of (a, a, b, b), b = 1/2 - a.
  type :: orbit_type
    !> Dimension 2 or 3, number of points of the rule to which the orbit belongs, number of points of the orbit.
    integer :: dimension, rule, points
    !> Parameters a, b; weight of each point as a fraction of the reference volume.
    real(wp) :: a, b, weight
  end type orbit_type

  real(wp), parameter :: third = 1.0_wp/3.0_wp, root5 = sqrt(5.0_wp), root10 = sqrt(10.0_wp), root15 = sqrt(15.0_wp), &
    root6 = sqrt(38.0_wp - 44.0_wp*sqrt(0.4_wp)), weight6 = sqrt(213125.0_wp - 53320.0_wp*root10), none = 0.0_wp
  type(orbit_type), parameter :: orbits(17) = [ &
    orbit_type(2, 1, 1, none, none, 1.0_wp), &
    orbit_type(2, 3, 3, 1.0_wp/6.0_wp, none, third), &
    orbit_type(2, 6, 3, (8.0_wp - root10 + root6)/18.0_wp, none, (620.0_wp + weight6)/3720.0_wp), &
    orbit_type(2, 6, 3, (8.0_wp - root10 - root6)/18.0_wp, none, (620.0_wp - weight6)/3720.0_wp), &
    orbit_type(2, 7, 1, none, none, 9.0_wp/40.0_wp), &
    orbit_type(2, 7, 3, (6.0_wp - root15)/21.0_wp, none, (155.0_wp - root15)/1200.0_wp), &
    orbit_type(2, 7, 3, (6.0_wp + root15)/21.0_wp, none, (155.0_wp + root15)/1200.0_wp), &
    orbit_type(2, 12, 3, 0.2492867451709104213_wp, none, 0.1167862757263793660_wp), &
    orbit_type(2, 12, 3, 0.06308901449150222834_wp, none, 0.05084490637020681692_wp), &
    orbit_type(2, 12, 6, 0.05314504984481694735_wp, 0.3103524510337844054_wp, 0.08285107561837357519_wp), &
    orbit_type(3, 1, 1, none, none, 1.0_wp), &
    orbit_type(3, 4, 4, (5.0_wp - root5)/20.0_wp, none, 0.25_wp), &
    orbit_type(3, 8, 4, 0.3280546967114265766_wp, none, 0.1385279665118637321_wp), &
    orbit_type(3, 8, 4, 0.1069522739329299185_wp, none, 0.1114720334881362679_wp), &
    orbit_type(3, 14, 4, 0.3108859192633006098_wp, none, 0.1126879257180158508_wp), &
    orbit_type(3, 14, 4, 0.09273525031089122640_wp, none, 0.07349304311636194954_wp), &
    orbit_type(3, 14, 6, 0.04550370412564964949_wp, none, 0.04254602077708146644_wp)]

contains

  !> Returns the Gauss rule of 1, 3, 4, 6, 7, 9, 12 or 16 points of a triangle, 1, 4, 8 or 14 of a tetrahedron.
  pure subroutine simplex_gauss(dimension, count, points, weights)
    !> 2 or 3; number of points.
    integer, intent(in) :: dimension, count
    !> Local coordinates (dimension, count); weights (count).
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    integer :: i, n

    n = nint(sqrt(real(count, wp)))
    if (dimension == 2 .and. n > 1 .and. n*n == count) then
      call collapsed_square(2*n - 2, points, weights)
      return
    end if
    allocate (points(dimension, count), weights(count))
    n = 0
    do i = 1, size(orbits)
      if (orbits(i)%dimension /= dimension .or. orbits(i)%rule /= count) cycle
      call add_orbit(orbits(i), points, weights, n)
    end do
  end subroutine simplex_gauss

  !> Appends the points of an orbit to a rule.
  pure subroutine add_orbit(orbit, points, weights, n)
    type(orbit_type), intent(in) :: orbit
    !> The rule.
    real(wp), intent(inout) :: points(:, :), weights(:)
    !> Number of points so far.
    integer, intent(inout) :: n
    real(wp) :: b, c
    integer :: i

    associate (d => orbit%dimension, a => orbit%a, own => points(:, n + 1:n + orbit%points))
      if (orbit%points == 1) then
        own = 1.0_wp/(d + 1)
      else if (orbit%points == d + 1) then
        own = a
        do i = 1, d
          own(i, i + 1) = 1.0_wp - d*a
        end do
      else if (d == 2) then
        b = orbit%b
        c = 1.0_wp - a - b
        own = reshape([a, b, b, a, a, c, c, a, b, c, c, b], [2, 6])
      else
        b = 0.5_wp - a
        own = reshape([a, b, b, b, a, b, b, b, a, b, a, a, a, b, a, a, a, b], [3, 6])
      end if
    end associate
    weights(n + 1:n + orbit%points) = orbit%weight/merge(2.0_wp, 6.0_wp, orbit%dimension == 2)
    n = n + orbit%points
  end subroutine add_orbit

  !> Returns the centroids of n x n equal sub-triangles, in rows of ascending eta.
  pure subroutine triangle_even(n, points, weights)
    !> Number of intervals per side.
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

  !> Returns the centroids of eight equal parts: the four corner tetrahedra, and the octahedron between them cut into
  !> four along its diagonal from the midpoint of edge 12 to the midpoint of edge 34.
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

  !> Returns a rule exact for polynomials of a given degree.
  pure subroutine simplex_degree(dimension, degree, points, weights)
    !> 2 or 3; the degree.
    integer, intent(in) :: dimension, degree
    !> Local coordinates (dimension, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    integer, parameter :: highest(2:3) = [6, 5], counts(0:6, 2:3) = reshape([1, 1, 3, 6, 6, 7, 12, &
      1, 1, 4, 14, 14, 14, 0], [7, 2])

    if (degree <= highest(dimension)) then
      call simplex_gauss(dimension, counts(max(degree, 0), dimension), points, weights)
    else if (dimension == 2) then
      call collapsed_square(degree, points, weights)
    else
      call collapsed_cube(degree, points, weights)
    end if
  end subroutine simplex_degree

  !> Maps the Gauss rule of the square by xi = u, eta = v (1 - u), u and v in [0, 1].
  pure subroutine collapsed_square(degree, points, weights)
    integer, intent(in) :: degree
    !> Local coordinates (2, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:)

    ! The Jacobian 1 - u raises the degree in u by one.
    call line_gauss((degree + 1)/2 + 1, x, w)
    call square_rule(x, w, points, weights)
    weights = 0.125_wp*weights*(1.0_wp - points(1, :))
    points(2, :) = 0.25_wp*(1.0_wp + points(2, :))*(1.0_wp - points(1, :))
    points(1, :) = 0.5_wp*(1.0_wp + points(1, :))
  end subroutine collapsed_square

  !> Maps the Gauss rule of the cube by xi = u, eta = v (1-u), zeta = t (1-u) (1-v), all in [0, 1].
  pure subroutine collapsed_cube(degree, points, weights)
    integer, intent(in) :: degree
    !> Local coordinates (3, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:)

    ! The Jacobian (1-u)^2 (1-v) raises the degree in u by two.
    call line_gauss((degree + 4)/2, x, w)
    call cube_rule(0.5_wp*(1.0_wp + x), 0.5_wp*w, points, weights)
    weights = weights*(1.0_wp - points(1, :))**2*(1.0_wp - points(2, :))
    points(3, :) = points(3, :)*(1.0_wp - points(1, :))*(1.0_wp - points(2, :))
    points(2, :) = points(2, :)*(1.0_wp - points(1, :))
  end subroutine collapsed_cube
end module qsmpm_simplex_rule
