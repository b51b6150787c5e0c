!> Gauss rules of the reference elements: rules of a given degree, and the rule for a full cell.
!>
!> Weights sum to the reference volume (triangle 1/2, quad 4, tet 1/6, hex 8, wedge 1). Points are ordered with xi
!> fastest and zeta slowest; a wedge rule is a triangle rule repeated in layers.
module qsmpm_quadrature
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: tri3, quad4, tet4, hex8, wedge6, wedge15, linear_kind, elements
  use qsmpm_line_rule, only: line_gauss
  use qsmpm_simplex_rule, only: simplex_degree, simplex_gauss
  implicit none
  private

  public :: gauss_rule, full_rule, square_rule, cube_rule, layer_rule

contains

  !> Returns a rule exact for polynomials of a given degree: total degree on triangles and tets, degree in each
  !> coordinate on quads and hexes, total degree in the triangle times degree in zeta on wedges.
  pure subroutine gauss_rule(kind, degree, points, weights)
    !> Element kind; degree, 0 or more.
    integer, intent(in) :: kind, degree
    !> Local coordinates (local dimension, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:), triangle(:, :), triangle_weights(:)

    select case (linear_kind(kind))
    case (tri3)
      call simplex_degree(2, degree, points, weights)
    case (tet4)
      call simplex_degree(3, degree, points, weights)
    case (quad4)
      call line_gauss(degree/2 + 1, x, w)
      call square_rule(x, w, points, weights)
    case (hex8)
      call line_gauss(degree/2 + 1, x, w)
      call cube_rule(x, w, points, weights)
    case (wedge6)
      call simplex_degree(2, degree, triangle, triangle_weights)
      call line_gauss(degree/2 + 1, x, w)
      call layer_rule(triangle, triangle_weights, x, w, points, weights)
    end select
  end subroutine gauss_rule

  !> Returns the rule of a full cell for finite elements and cell integration: Gauss points for which the rigid body
  !> modes are the only zero-energy modes.
  pure subroutine full_rule(kind, points, weights)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (local dimension, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:), triangle(:, :), triangle_weights(:)

    if (kind /= wedge15) then
      call gauss_rule(kind, elements(kind)%full_degree, points, weights)
      return
    end if
    ! With two layers a wedge15 has three zero-energy modes too many; three layers suffice.
    call simplex_gauss(2, 3, triangle, triangle_weights)
    call line_gauss(3, x, w)
    call layer_rule(triangle, triangle_weights, x, w, points, weights)
  end subroutine full_rule

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
end module qsmpm_quadrature
